// The surface to draw for a body from the server: its skin with creases, or the outside of its tetrahedra.
import type { Material, Surface } from "../common/film";

const CREASE_COSINE = 0.64; // 50 degrees: an edge where the rest shape bends by more is a crease

// Union-find over corners that share a normal.
class Unions {
  private readonly parent: Uint32Array;
  constructor(count: number) {
    this.parent = Uint32Array.from({ length: count }, (_, k) => k);
  }
  root(k: number): number {
    while (this.parent[k] !== k) k = this.parent[k] = this.parent[this.parent[k]];
    return k;
  }
  join(a: number, b: number): void {
    this.parent[this.root(b)] = this.root(a);
  }
}

function first_at_same_place(rest: Float32Array): Uint32Array {
  const first = new Map<string, number>();
  const result = new Uint32Array(rest.length / 3);
  for (let i = 0; i < result.length; ++i) {
    const key = `${rest[3 * i]},${rest[3 * i + 1]},${rest[3 * i + 2]}`;
    const known = first.get(key);
    if (known === undefined) first.set(key, i);
    result[i] = known ?? i;
  }
  return result;
}

export interface SkinArrays {
  rest: Float32Array;
  triangles: Uint32Array;
  material: Uint32Array | null; // per vertex; a triangle has its first corner's
  uvs: Float32Array | null;
  colours: Float32Array | null; // linear light
  layer: Uint8Array;
}

export interface Skin {
  surface: Surface;
  groups: { material: number; triangles: number }[];
  linear_colours: Float32Array | null; // per drawn vertex
}

// The skin with an extra vertex for each crease through a vertex; its places are the skin's own vertices.
export function skin_of(arrays: SkinArrays): Skin {
  const { rest } = arrays;
  const place = first_at_same_place(rest);
  const count = arrays.triangles.length / 3;
  const material_of = (t: number) => (arrays.material ? arrays.material[arrays.triangles[3 * t]] : 0);
  const order = Uint32Array.from({ length: count }, (_, t) => t).sort((a, b) => material_of(a) - material_of(b) || a - b);
  const triangles = new Uint32Array(3 * count);
  const groups: Skin["groups"] = [];
  order.forEach((from, to) => {
    for (let k = 0; k < 3; ++k) triangles[3 * to + k] = arrays.triangles[3 * from + k];
    const material = material_of(from);
    if (groups.at(-1)?.material !== material) groups.push({ material, triangles: 0 });
    ++groups[groups.length - 1].triangles;
  });
  const normals = new Float32Array(3 * count);
  for (let t = 0; t < count; ++t) {
    const [a, b, c] = [3 * triangles[3 * t], 3 * triangles[3 * t + 1], 3 * triangles[3 * t + 2]];
    const [ux, uy, uz] = [rest[b] - rest[a], rest[b + 1] - rest[a + 1], rest[b + 2] - rest[a + 2]];
    const [vx, vy, vz] = [rest[c] - rest[a], rest[c + 1] - rest[a + 1], rest[c + 2] - rest[a + 2]];
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(...normal) || 1;
    for (let k = 0; k < 3; ++k) normals[3 * t + k] = normal[k] / length;
  }
  // Joins corners of triangles across every edge that is not a crease; joined corners share a normal.
  const unions = new Unions(triangles.length);
  const sides = new Map<number, [number, number]>(); // the corners at the lower-numbered and at the
                                                     // higher-numbered place
  for (let k = 0; k < triangles.length; ++k) {
    const next = k % 3 === 2 ? k - 2 : k + 1;
    const [a, b] = [place[triangles[k]], place[triangles[next]]];
    const key = Math.min(a, b) * 0x4000000 + Math.max(a, b);
    const corners: [number, number] = a < b ? [k, next] : [next, k];
    const other = sides.get(key);
    if (!other) {
      sides.set(key, corners);
      continue;
    }
    const [t, o] = [3 * Math.floor(k / 3), 3 * Math.floor(other[0] / 3)];
    const cosine = normals[t] * normals[o] + normals[t + 1] * normals[o + 1] + normals[t + 2] * normals[o + 2];
    if (cosine < CREASE_COSINE) continue;
    unions.join(other[0], corners[0]);
    unions.join(other[1], corners[1]);
  }
  const drawn = new Map<number, number>();
  const numbers = new Map<number, number>();
  const source: number[] = [];
  const normal: number[] = [];
  const drawn_triangles = new Uint32Array(triangles.length);
  for (let k = 0; k < triangles.length; ++k) {
    const root = unions.root(k);
    const key = triangles[k] * 0x4000000 + root;
    let vertex = drawn.get(key);
    if (vertex === undefined) {
      vertex = source.length;
      drawn.set(key, vertex);
      source.push(triangles[k]);
      let number = numbers.get(root);
      if (number === undefined) {
        number = numbers.size;
        numbers.set(root, number);
      }
      normal.push(number);
    }
    drawn_triangles[k] = vertex;
  }
  const from = Uint32Array.from(source);
  const picked = (values: Float32Array, width: number) => {
    const result = new Float32Array(width * from.length);
    from.forEach((vertex, i) => {
      for (let c = 0; c < width; ++c) result[width * i + c] = values[width * vertex + c];
    });
    return result;
  };
  return {
    surface: {
      places: rest.length / 3,
      triangles: drawn_triangles,
      place: from,
      normal: Uint32Array.from(normal),
      layer: Uint32Array.from(from, (vertex) => arrays.layer[vertex]),
      source: from,
      uvs: arrays.uvs ? picked(arrays.uvs, 2) : null,
      colours: null,
    },
    groups,
    linear_colours: arrays.colours ? picked(arrays.colours, 3) : null,
  };
}

// The material of tetrahedra.
export const INSIDE: Material = { name: "", colour: [0.62, 0.6, 0.57], cutoff: 0, texture: -1 };

export interface Cut {
  axis: 0 | 1 | 2;
  place: number; // m, in the rest shape
}

const SIDES = [
  [1, 2, 3],
  [0, 3, 2],
  [0, 1, 3],
  [0, 2, 1],
];

// The outside of the tetrahedra that are not wholly beyond the cut, flat shaded.
export function tetrahedra_surface(
  rest: Float32Array,
  tetrahedra: Uint32Array,
  layer: Uint8Array,
  cut: Cut | null,
): Surface {
  const sides = new Map<string, { corners: number[]; tetrahedron: number } | null>();
  for (let t = 0; t < tetrahedra.length; t += 4) {
    if (cut && [0, 1, 2, 3].every((c) => rest[3 * tetrahedra[t + c] + cut.axis] >= cut.place)) continue;
    for (const side of SIDES) {
      const corners = side.map((c) => tetrahedra[t + c]);
      const [a, b, c] = [...corners].sort((x, y) => x - y);
      const key = `${a},${b},${c}`;
      sides.set(key, sides.has(key) ? null : { corners, tetrahedron: t });
    }
  }
  const place: number[] = [];
  const normal: number[] = [];
  const layers: number[] = [];
  for (const side of sides.values()) {
    if (!side) continue;
    const number = place.length / 3;
    const own = [0, 1, 2, 3].map((c) => layer[tetrahedra[side.tetrahedron + c]]).sort((x, y) => x - y);
    // The layer of most corners; in a tie, the lowest.
    const most = own.reduce((best, one) =>
      own.filter((other) => other === one).length > own.filter((other) => other === best).length ? one : best,
    );
    for (const corner of side.corners) {
      place.push(corner);
      normal.push(number);
      layers.push(most);
    }
  }
  const vertices = Uint32Array.from(place);
  return {
    places: rest.length / 3,
    triangles: Uint32Array.from(vertices, (_, k) => k),
    place: vertices,
    normal: Uint32Array.from(normal),
    layer: Uint32Array.from(layers),
    source: vertices,
    uvs: null,
    colours: null,
  };
}

export interface Hit {
  vertex: number; // the nearest corner
  place: [number, number, number];
  corners: [number, number, number];
  weights: [number, number, number]; // of the corners, at the place
}

// The nearest triangle that a ray (3 numbers each) hits, and where; null if it hits none.
export function hit(
  from: readonly number[],
  along: readonly number[],
  positions: Float32Array,
  surface: Surface,
): Hit | null {
  const { triangles, place } = surface;
  let nearest = Infinity;
  let found = -1;
  let weights: Hit["weights"] = [1, 0, 0];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * place[triangles[t]], 3 * place[triangles[t + 1]], 3 * place[triangles[t + 2]]];
    const [ux, uy, uz] = [positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[b + 2] - positions[a + 2]];
    const [vx, vy, vz] = [positions[c] - positions[a], positions[c + 1] - positions[a + 1], positions[c + 2] - positions[a + 2]];
    const [px, py, pz] = [along[1] * vz - along[2] * vy, along[2] * vx - along[0] * vz, along[0] * vy - along[1] * vx];
    const determinant = ux * px + uy * py + uz * pz;
    if (Math.abs(determinant) < 1e-20) continue;
    const [sx, sy, sz] = [from[0] - positions[a], from[1] - positions[a + 1], from[2] - positions[a + 2]];
    const u = (sx * px + sy * py + sz * pz) / determinant;
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
    const v = (along[0] * qx + along[1] * qy + along[2] * qz) / determinant;
    if (v < 0 || u + v > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / determinant;
    if (distance <= 0 || distance >= nearest) continue;
    nearest = distance;
    found = t;
    weights = [1 - u - v, u, v];
  }
  if (found < 0) return null;
  const where: [number, number, number] = [0, 1, 2].map((c) => from[c] + nearest * along[c]) as [number, number, number];
  const away = (k: number) => {
    const at = 3 * place[triangles[found + k]];
    return Math.hypot(positions[at] - where[0], positions[at + 1] - where[1], positions[at + 2] - where[2]);
  };
  const corner = [0, 1, 2].reduce((best, k) => (away(k) < away(best) ? k : best));
  const corners = [0, 1, 2].map((k) => place[triangles[found + k]]) as Hit["corners"];
  return { vertex: corners[corner], place: where, corners, weights };
}
