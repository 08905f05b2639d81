// What the studio's camera fits before the body moves.

// Leaves room for motion: this times the body's size covers most clips, including a jump with raised arms.
const ROOM = 1.5;

// Points around `middle` that the camera is to fit. `rest`: vertices, 3 numbers each. `beside`: per vertex,
// whether it is on a floor or wall of the character's file, which the camera does not fit; null: none is.
// `fall`: how far the body falls. Both its start and its end are fitted.
export function points_to_fit(
  rest: ArrayLike<number>,
  beside: ArrayLike<number> | null,
  middle: readonly [number, number, number],
  fall: number,
): number[] {
  const points: number[] = [];
  for (const down of fall > 0 ? [0, fall] : [0])
    for (let k = 0; k < rest.length; ++k) {
      if (beside?.[Math.floor(k / 3)]) continue;
      points.push(ROOM * (rest[k] - (k % 3 === 1 ? down : 0) - middle[k % 3]));
    }
  return points;
}

// The height of the lowest vertex, floors included.
export function lowest_of(rest: ArrayLike<number>): number {
  let lowest = Infinity;
  for (let k = 1; k < rest.length; k += 3) lowest = Math.min(lowest, rest[k]);
  return lowest;
}
