import assert from "node:assert/strict";
import { test } from "node:test";
import { short_names, shows_sides } from "./look";

test("a bake's short name is the shortest unique end of its path", () => {
  assert.deepEqual(short_names(["out/arm", "out/soft"]), ["arm", "soft"]);
  assert.deepEqual(short_names(["a/out/arm/", "b/out/arm", "out/soft"]), ["a/out/arm/", "b/out/arm", "soft"]);
  assert.deepEqual(short_names(["arm"]), ["arm"]);
  assert.deepEqual(short_names([]), []);
});

test("choosing another bake shows both side by side; a rewritten bake leaves the view as it is", () => {
  assert.equal(shows_sides("", "out/arm", "flesh"), true);
  assert.equal(shows_sides("out/soft", "out/arm", "flesh"), true);
  assert.equal(shows_sides("out/arm", "out/arm", "flesh"), false);
  assert.equal(shows_sides("", "out/arm", "ghost"), false);
});
