import assert from "node:assert/strict";
import { test } from "node:test";
import { lowest_of, points_to_fit } from "./framing";

test("the camera fits the body with room for its motion, and not the floor below it", () => {
  const rest = [0, 1, 0, 2, 3, 0, 40, -1, 40];
  assert.deepEqual(points_to_fit(rest, new Uint8Array([0, 0, 1]), [1, 2, 0], 0), [-1.5, -1.5, 0, 1.5, 1.5, 0]);
  assert.deepEqual(points_to_fit(rest, null, [1, 2, 0], 0).slice(6), [58.5, -4.5, 60]);
});

test("a body that falls is fitted at its start and at its end", () => {
  assert.deepEqual(points_to_fit([0, 1, 0], null, [0, 0, 0], 2), [0, 1.5, 0, 0, -1.5, 0]);
});

test("the floor of the picture is below all that is drawn", () => {
  assert.equal(lowest_of([0, 1, 0, 40, -1, 40]), -1);
});
