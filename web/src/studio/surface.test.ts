import assert from "node:assert/strict";
import { test } from "node:test";
import { hit, skin_of, tetrahedra_surface } from "./surface";

// A cube of 8 vertices and 12 triangles.
const cube = Float32Array.from([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1]);
const sides = Uint32Array.from(
  [0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7],
);

test("a cube has one normal per side, three at each corner", () => {
  const { surface, groups } = skin_of({
    rest: cube,
    triangles: sides,
    material: Uint32Array.from([1, 0, 0, 0, 0, 0, 0, 0]),
    uvs: null,
    colours: null,
    layer: new Uint8Array(8),
  });
  assert.equal(surface.place.length, 24);
  // The four corners of each side are joined only along its diagonal, not around the cube's edges.
  assert.equal(groups.length, 2);
  assert.equal(groups.reduce((sum, group) => sum + group.triangles, 0), 12);
  const corners = (list: ArrayLike<number>, of = (k: number) => k) => {
    const all: string[] = [];
    for (let t = 0; t < list.length; t += 3) all.push([of(list[t]), of(list[t + 1]), of(list[t + 2])].join());
    return all.sort();
  };
  assert.deepEqual(corners(surface.triangles, (k) => surface.place[k]), corners(sides));
});

test("the outside of two tetrahedra has no shared side, and a cut removes the tetrahedra beyond it", () => {
  const rest = Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1]);
  const tetrahedra = Uint32Array.from([0, 1, 2, 3, 1, 2, 3, 4]);
  const layer = Uint8Array.from([0, 0, 0, 0, 1]);
  assert.equal(tetrahedra_surface(rest, tetrahedra, layer, null).triangles.length, 18);
  const cut = tetrahedra_surface(rest, tetrahedra, layer, { axis: 2, place: 2 });
  assert.equal(cut.triangles.length, 18);
  assert.equal(tetrahedra_surface(rest, tetrahedra, layer, { axis: 0, place: -1 }).triangles.length, 0);
});

test("a ray hits the nearest side, and reports the nearest corner", () => {
  const { surface } = skin_of({
    rest: cube,
    triangles: sides,
    material: null,
    uvs: null,
    colours: null,
    layer: new Uint8Array(8),
  });
  const found = hit([0.9, 0.8, 5], [0, 0, -1], cube, surface);
  assert.equal(found?.vertex, 6);
  assert.ok(Math.abs(found!.place[2] - 1) < 1e-6);
  assert.equal(hit([3, 3, 5], [0, 0, -1], cube, surface), null);
});
