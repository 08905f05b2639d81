import assert from "node:assert/strict";
import { test } from "node:test";
import { short_names } from "./look";

test("a bake is called by as little of its path as tells it from others", () => {
  assert.deepEqual(short_names(["out/arm", "out/soft"]), ["arm", "soft"]);
  assert.deepEqual(short_names(["a/out/arm/", "b/out/arm", "out/soft"]), ["a/out/arm/", "b/out/arm", "soft"]);
  assert.deepEqual(short_names(["arm"]), ["arm"]);
  assert.deepEqual(short_names([]), []);
});
