import assert from "node:assert/strict";
import { test } from "node:test";
import { texture_cutoff } from "./body";

test("a texel is cut out where its alpha times the base colour's is below the cutoff", () => {
  for (const base of [1, 0.8, 0.5, 0.25, 0])
    for (const texel of [0, 0.3, 0.55, 0.7, 0.97, 1])
      assert.equal(texel < texture_cutoff(0.5, base), base * texel < 0.5, `${base} ${texel}`);
  assert.equal(texture_cutoff(0, 0.3), 0);
});
