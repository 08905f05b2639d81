import assert from "node:assert/strict";
import { test } from "node:test";
import { is_apart, radius_of, stiffness_of, write_paint_colour } from "./paint";

test("radii range from a 500th to a fifth of the size", () => {
  assert.ok(Math.abs(radius_of(0, 2) - 0.004) < 1e-12);
  assert.ok(Math.abs(radius_of(100, 2) - 0.4) < 1e-12);
  assert.ok(Math.abs(radius_of(50, 2) - 0.04) < 1e-12);
});

test("stiffness is a fraction of alpha, or a tenth to ten times a modulus", () => {
  assert.equal(stiffness_of(30, 1), 0.3);
  assert.deepEqual([0, 50, 65, 100].map((step) => stiffness_of(step, 10)), [0.1, 1, 2, 10]);
  const colour = (value: number, most: number) => {
    const to = new Float32Array(3);
    write_paint_colour("_STIFFNESS", Float32Array.of(value), 0, to, 0, most);
    return [...to].map((part) => part.toFixed(6));
  };
  assert.deepEqual(colour(0.1, 10), colour(0, 1));
  assert.deepEqual(colour(1, 10), colour(0.5, 1));
  assert.deepEqual(colour(10, 10), colour(1, 1));
});

test("places closer together than the spacing are skipped", () => {
  assert.ok(is_apart([0, 0, 0], [0.3, 0.4, 0], 0.5));
  assert.ok(!is_apart([0, 0, 0], [0.3, 0.39, 0], 0.5));
});

test("everything unpainted has one colour, and opposite fibre directions have the same colour", () => {
  const colour = (kind: string, values: number[] | null, vertex: number) => {
    const to = new Float32Array(3);
    write_paint_colour(kind, values && Float32Array.from(values), vertex, to, 0);
    return [...to];
  };
  assert.deepEqual(colour("_LAYER", null, 5), colour("_RIGID", [0.4], 0));
  assert.deepEqual(colour("_LAYER", [0], 0), colour("_FIBER", [0, 0, 0], 0));
  assert.notDeepEqual(colour("_LAYER", [1], 0), colour("_LAYER", [3], 0));
  assert.notDeepEqual(colour("_RIGID", [0.5], 0), colour("_RIGID", [0.4], 0));
  assert.deepEqual(colour("_STIFFNESS", null, 0), colour("_STIFFNESS", [1], 0));
  assert.deepEqual(colour("_FIBER", [0.6, 0.8, 0], 0), colour("_FIBER", [-0.6, -0.8, 0], 0));
  assert.notDeepEqual(colour("_FIBER", [0.6, 0.8, 0], 0), colour("_FIBER", [0, 0, 1], 0));
});
