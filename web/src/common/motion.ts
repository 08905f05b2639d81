// The decoder for host/page/motion.cpp: frames of integers from a coded motion.
import { bit_length, NumberDecoder, RangeDecoder } from "./range_decoder";

const AXES = 3;
const CONTEXTS = 13;
const MOST_NEIGHBOURS = 4;
const FACTORS = [
  [0, 0, 0],
  [1, 0, 0],
  [2, -1, 0],
  [3, -3, 1],
];

// For each point, at most four neighbours with lower numbers: those with the highest, ascending. CSR.
export interface Neighbours {
  offset: Uint32Array;
  point: Uint32Array;
}

export function lower_neighbours(points: number, triangles: ArrayLike<number>): Neighbours {
  const lists: number[][] = Array.from({ length: points }, () => []);
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; ++k)
      for (let other = 0; other < 3; ++other) {
        const to = triangles[t + k];
        const from = triangles[t + other];
        if (from < to && !lists[to].includes(from)) lists[to].push(from);
      }
  const offset = new Uint32Array(points + 1);
  const point: number[] = [];
  lists.forEach((list, i) => {
    list.sort((a, b) => a - b);
    point.push(...list.slice(-MOST_NEIGHBOURS));
    offset[i + 1] = point.length;
  });
  return { offset, point: Uint32Array.from(point) };
}

export class MotionDecoder {
  private readonly numbers = new NumberDecoder(AXES * CONTEXTS);
  // Offset from the base in the last three frames, latest first.
  private past: Int32Array[];
  private rest: Int32Array;
  private left: Int32Array;
  private before: Int32Array;

  constructor(
    private readonly neighbours: Neighbours,
    private readonly points: number,
  ) {
    const make = () => new Int32Array(AXES * points);
    this.past = [make(), make(), make()];
    this.rest = make();
    this.left = make();
    this.before = make();
  }

  // The next frame: 3 numbers per point. `base`: predicted positions; null: the grid's origin.
  take(from: RangeDecoder, base: Int32Array | null): Int32Array {
    const factor = FACTORS[from.direct(2)];
    const { offset, point } = this.neighbours;
    const { rest, left, before, numbers } = this;
    const [p1, p2, p3] = this.past;
    const cells = new Int32Array(AXES * this.points);
    const now = p3;
    for (let i = 0; i < this.points; ++i) {
      const begin = offset[i];
      const end = offset[i + 1];
      for (let axis = 0; axis < AXES; ++axis) {
        const at = AXES * i + axis;
        let around = Math.abs(before[at]);
        let sum = 0;
        for (let k = begin; k < end; ++k) {
          const of = AXES * point[k] + axis;
          around += Math.abs(left[of]);
          sum += rest[of];
        }
        const context = Math.min(bit_length(around), CONTEXTS - 1);
        left[at] = numbers.take(from, axis * CONTEXTS + context);
        const count = end - begin;
        rest[at] = left[at] + (count === 0 ? 0 : Math.floor((2 * sum + count) / (2 * count)));
        const past = factor[0] * p1[at] + factor[1] * p2[at] + factor[2] * p3[at];
        now[at] = rest[at] + past;
        cells[at] = now[at] + (base === null ? 0 : base[at]);
      }
    }
    this.past = [now, p1, p2];
    this.before = left;
    this.left = before;
    return cells;
  }
}
