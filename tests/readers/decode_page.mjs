// Decodes a page of `fascicle view`, written from docs/formats.md alone, and compares it with the bake's point cache:
//   node decode_page.mjs PAGE.html [SURFACE.pc2]
// Prints one JSON object: counts, the largest error (m) of any vertex in any frame, what the page states, and for each
// frame the largest distance between flesh and ghost.
import { readFileSync } from "node:fs";

const page = readFileSync(process.argv[2], "utf8");
const open = '<script type="application/json" id="bake">';
const start = page.indexOf(open) + open.length;
const bake = JSON.parse(page.slice(start, page.indexOf("</script>", start)));
const bytes = Buffer.from(bake.motion, "base64");

let at = 5;
let range = 2 ** 32 - 1;
let code = bytes.readUInt32BE(1);
const refill = () => {
  while (range < 2 ** 24) {
    if (at >= bytes.length) throw new Error("the data end too early");
    range = range * 256;
    code = code * 256 + bytes[at++];
  }
};
const adaptive = (box) => {
  const bound = Math.floor(range / 4096) * box.zero;
  const one = code >= bound;
  if (one) {
    code -= bound;
    range -= bound;
    box.zero -= box.zero >> 5;
  } else {
    range = bound;
    box.zero += (4096 - box.zero) >> 5;
  }
  refill();
  return one ? 1 : 0;
};
const plain = (count) => {
  let value = 0;
  for (; count > 0; --count) {
    range = Math.floor(range / 2);
    const one = code >= range ? 1 : 0;
    if (one) code -= range;
    value = 2 * value + one;
    refill();
  }
  return value;
};

const boxes = (count) => Array.from({ length: count }, () => ({ zero: 2048 }));
class Numbers {
  contexts = [];
  low = Array.from({ length: 32 }, () => boxes(4));
  take(context) {
    const own = (this.contexts[context] ??= { tree: boxes(32), sign: { zero: 2048 } });
    let node = 1;
    while (node < 32) node = 2 * node + adaptive(own.tree[node]);
    const length = node - 32;
    if (length === 0) return 0;
    const negative = adaptive(own.sign);
    let value = 1;
    let below = length - 1;
    for (let k = 0; k < 2 && below > 0; ++k, --below)
      value = 2 * value + adaptive(this.low[length][k === 0 ? 1 : 2 + (value & 1)]);
    value = value * 2 ** below + plain(below);
    return negative ? -value : value;
  }
}

const lists = new Numbers();
let context = 0;
const list = (count, width) => {
  const values = [];
  for (let k = 0; k < count; ++k) values.push(lists.take(context) + (k < width ? 0 : values[k - width]));
  ++context;
  return values;
};
const corners = list(3 * bake.triangles, 1);
const place = list(bake.vertices, 1);
list(bake.vertices, 1); // normals
list(bake.vertices, 1); // layers
const source = list(bake.vertices, 1);
const uvs = bake.has_uvs ? list(2 * bake.vertices, 2) : [];
if (bake.has_colours) list(3 * bake.vertices, 3);

const around = Array.from({ length: bake.places }, () => new Set());
for (let t = 0; t < corners.length; t += 3) {
  const three = [place[corners[t]], place[corners[t + 1]], place[corners[t + 2]]];
  for (const a of three) for (const b of three) if (b < a) around[a].add(b);
}
const parents = around.map((set) => [...set].sort((a, b) => b - a).slice(0, 4));

const zeros = () => new Float64Array(3 * bake.places);
class Motion {
  numbers = new Numbers();
  past = [zeros(), zeros(), zeros()];
  before = zeros();
  take(base) {
    const order = plain(2);
    const [one, two, three] = this.past;
    const rest = zeros();
    const left = zeros();
    const cells = zeros();
    const offsets = zeros();
    for (let p = 0; p < bake.places; ++p)
      for (let axis = 0; axis < 3; ++axis) {
        const k = 3 * p + axis;
        let expected = Math.abs(this.before[k]);
        let sum = 0;
        for (const parent of parents[p]) {
          expected += Math.abs(left[3 * parent + axis]);
          sum += rest[3 * parent + axis];
        }
        const bits = expected === 0 ? 0 : Math.floor(Math.log2(expected)) + 1;
        left[k] = this.numbers.take(13 * axis + Math.min(bits, 12));
        const count = parents[p].length;
        rest[k] = left[k] + (count > 0 ? Math.floor(sum / count + 0.5) : 0);
        const foreseen = [0, one[k], 2 * one[k] - two[k], 3 * one[k] - 3 * two[k] + three[k]][order];
        offsets[k] = rest[k] + foreseen;
        cells[k] = offsets[k] + base[k];
      }
    this.past = [offsets, one, two];
    this.before = left;
    return cells;
  }
}

let cache = null;
if (process.argv[3]) {
  const file = readFileSync(process.argv[3]);
  if (file.toString("latin1", 0, 11) !== "POINTCACHE2") throw new Error("no PC2");
  const vertices = file.readUInt32LE(16);
  const frames = file.readUInt32LE(28);
  cache = {
    vertices,
    frames,
    at: (frame, vertex, axis) => file.readFloatLE(32 + 4 * (3 * (frame * vertices + vertex) + axis)),
  };
}

const ghost_motion = new Motion();
const flesh_motion = new Motion();
let ghost = zeros();
let largest = 0;
const lag = [];
let first_box = null;
const box = { least: [Infinity, Infinity, Infinity], most: [-Infinity, -Infinity, -Infinity] };
for (let frame = 0; frame < bake.frames; ++frame) {
  if (frame < bake.ghost_frames) ghost = ghost_motion.take(zeros());
  const flesh = flesh_motion.take(ghost);
  let furthest = 0;
  for (let p = 0; p < bake.places; ++p)
    furthest = Math.max(
      furthest,
      Math.hypot(flesh[3 * p] - ghost[3 * p], flesh[3 * p + 1] - ghost[3 * p + 1], flesh[3 * p + 2] - ghost[3 * p + 2]),
    );
  lag.push(furthest * bake.step);
  for (let v = 0; v < bake.vertices; ++v) {
    let square = 0;
    for (let axis = 0; axis < 3; ++axis) {
      const here = bake.origin[axis] + bake.step * flesh[3 * place[v] + axis];
      box.least[axis] = Math.min(box.least[axis], here);
      box.most[axis] = Math.max(box.most[axis], here);
      if (cache) square += (here - cache.at(frame, source[v], axis)) ** 2;
    }
    largest = Math.max(largest, Math.sqrt(square));
  }
  first_box ??= structuredClone(box);
}
console.log(
  JSON.stringify({
    frames: bake.frames,
    cache_frames: cache?.frames,
    cache_vertices: cache?.vertices,
    drawn: new Set(source).size,
    vertices: bake.vertices,
    triangles: bake.triangles,
    places: bake.places,
    stated: bake.error,
    largest,
    lag,
    first_box,
    box,
    uvs: uvs.length,
    bytes: bytes.length,
    left_over: bytes.length - at,
  }),
);
