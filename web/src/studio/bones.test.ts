import assert from "node:assert/strict";
import { test } from "node:test";
import { changes_for, nearest_of } from "./bones";

test("a joint is in at most one of the two lists, and an empty list removes its key", () => {
  const none = { chosen: [], unchosen: [] };
  assert.deepEqual(changes_for({ name: "a", is_bone: true }, none), { "skeleton.not_bones": ["a"] });
  assert.deepEqual(changes_for({ name: "a", is_bone: false }, none), { "skeleton.bones": ["a"] });
  assert.deepEqual(changes_for({ name: "a", is_bone: true }, { chosen: ["a"], unchosen: ["b"] }), {
    "skeleton.bones": null,
    "skeleton.not_bones": ["b", "a"],
  });
  assert.deepEqual(changes_for({ name: "a", is_bone: false }, { chosen: ["c"], unchosen: ["a", "b"] }), {
    "skeleton.bones": ["c", "a"],
    "skeleton.not_bones": ["b"],
  });
});

test("the joint under the pointer is the nearest one within reach", () => {
  const places: [number, number][] = [[0, 0], [10, 0], [14, 0]];
  assert.equal(nearest_of(places, 11, 1, 18), 1);
  assert.equal(nearest_of(places, 13, 0, 18), 2);
  assert.equal(nearest_of(places, 40, 0, 18), -1);
});
