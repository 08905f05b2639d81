import assert from "node:assert/strict";
import { test } from "node:test";
import { range_of, step_of, STEPS, value_of } from "./slider";

test("a slider ends at its bounds, and its values increase from one to the other", () => {
  for (const range of [
    { least: 0, most: 60, logarithmic: false },
    { least: 0.5, most: 100, logarithmic: true },
    { least: -20, most: 20, logarithmic: false },
  ]) {
    assert.equal(value_of(0, range), range.least);
    assert.equal(value_of(STEPS, range), range.most);
    for (let step = 1; step <= STEPS; ++step) assert.ok(value_of(step, range) >= value_of(step - 1, range));
    assert.equal(step_of(value_of(STEPS / 2, range), range), STEPS / 2);
  }
});

test("soft bounds take precedence over hard ones, and a key without two bounds has no slider", () => {
  assert.deepEqual(range_of({ minimum: 0, maximum: 1e9, soft_minimum: 1, soft_maximum: 10, logarithmic: true }), {
    least: 1,
    most: 10,
    logarithmic: true,
  });
  assert.equal(range_of({ minimum: 0 }), null);
  assert.equal(range_of({ minimum: 0, maximum: 1, logarithmic: true })?.logarithmic, false);
});
