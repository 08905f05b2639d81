import assert from "node:assert/strict";
import { test } from "node:test";
import type { Surface } from "./film";
import { Normals } from "./normals";

function surface(triangles: number[], normal: number[]): Surface {
  const count = normal.length;
  return {
    places: count,
    triangles: Uint32Array.from(triangles),
    place: Uint32Array.from({ length: count }, (_, k) => k),
    normal: Uint32Array.from(normal),
    layer: new Uint32Array(count),
    source: new Uint32Array(count),
    uvs: null,
    colours: null,
  };
}

// Two triangles at a right angle along x = 0.
const roof = Float32Array.from([0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, -1, 0]);
const triangles = [0, 1, 2, 3, 5, 4];

test("vertices with the same normal number are shaded smoothly, others have a crease", () => {
  const to = new Float32Array(18);
  new Normals(surface(triangles, [0, 1, 2, 3, 4, 5])).write(roof, to);
  assert.deepEqual([...to.slice(0, 3)], [0, 1, 0]);
  assert.deepEqual([...to.slice(9, 12)].map(Math.abs), [1, 0, 0]);
  new Normals(surface(triangles, [0, 1, 2, 0, 1, 5])).write(roof, to);
  assert.deepEqual(to.slice(0, 3), to.slice(9, 12));
  assert.ok(Math.abs(Math.hypot(to[0], to[1], to[2]) - 1) < 1e-6);
});

test("a triangle without area gives finite normals", () => {
  const to = new Float32Array(9);
  new Normals(surface([0, 1, 2], [0, 1, 2])).write(new Float32Array(9), to);
  assert.ok(to.every(Number.isFinite));
});
