import assert from "node:assert/strict";
import { test } from "node:test";
import { same_items, write_distances } from "./beside";

test("arrays are the same only if all items and the length are", () => {
  assert.ok(same_items(Uint32Array.from([0, 1, 2]), Uint32Array.from([0, 1, 2])));
  assert.ok(!same_items(Uint32Array.from([0, 1, 2]), Uint32Array.from([0, 1, 3])));
  assert.ok(!same_items(Uint32Array.from([0, 1, 2]), Uint32Array.from([0, 1, 2, 0])));
  assert.ok(!same_items(undefined, undefined));
});

test("distances between places, and the largest one", () => {
  const to = new Float32Array(2);
  const most = write_distances(Float32Array.from([0, 0, 0, 1, 2, 3]), Float32Array.from([0, 3, 4, 1, 2, 3]), to);
  assert.deepEqual([...to], [5, 0]);
  assert.equal(most, 5);
});
