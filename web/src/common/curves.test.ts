import assert from "node:assert/strict";
import { test } from "node:test";
import { range_of, value_text } from "./curves";

const curve = (values: (number | null)[], limit: number | null = null) => ({ name: "lag", unit: "mm", limit, values });

test("a curve's range holds its values, its limit, and 0 where that is near", () => {
  assert.deepEqual(range_of(curve([1, 9])), [0, 9]);
  assert.deepEqual(range_of(curve([99, 100])), [99, 100]);
  assert.deepEqual(range_of(curve([0, 0.5], 1)), [0, 1]);
  const [least, most] = range_of(curve([3, 3]));
  assert.ok(least < 3 && most > 3);
  assert.deepEqual(range_of(curve([null])), [0, 1]);
});

test("a value that is missing is shown as missing", () => {
  assert.equal(value_text(curve([1.23456, null]), 0), "1.23 mm");
  assert.equal(value_text(curve([1, null]), 1), "–");
});
