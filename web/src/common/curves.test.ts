import assert from "node:assert/strict";
import { test } from "node:test";
import { axis_texts, range_of, time_ticks, value_text } from "./curves";

const curve = (values: (number | null)[], limit: number | null = null) => ({ name: "lag", unit: "mm", limit, values });

test("a curve's range includes its values, its limit, and 0 if that is close", () => {
  assert.deepEqual(range_of(curve([1, 9])), [0, 9]);
  assert.deepEqual(range_of(curve([99, 100])), [99, 100]);
  assert.deepEqual(range_of(curve([0, 0.5], 1)), [0, 1]);
  assert.deepEqual(range_of(curve([119, 121], 1)), [0, 121]);
  const [least, most] = range_of(curve([3, 3]));
  assert.ok(least < 3 && most > 3);
  assert.deepEqual(range_of(curve([null])), [0, 1]);
  assert.deepEqual(range_of(curve([0, 0])), [0, 1]);
});

test("a missing value is shown as a dash", () => {
  assert.equal(value_text(curve([1.23456, null]), 0), "1.23 mm");
  assert.equal(value_text(curve([1, null]), 1), "–");
});

test("curves in one lane share a scale, which includes their limits", () => {
  assert.deepEqual(range_of(curve([1, 9]), curve([2, 30])), [0, 30]);
  assert.deepEqual(range_of(curve([0, 0.5]), curve([0, 0.2], 1)), [0, 1]);
  assert.deepEqual(range_of(curve([null]), curve([0, 4])), [0, 4]);
});

test("ticks are round times within the clip", () => {
  assert.deepEqual(time_ticks(0, 2, 8), { times: [0, 0.5, 1, 1.5, 2], digits: 1 });
  const late = time_ticks(0.25, 0.61, 4);
  assert.equal(late.digits, 1);
  assert.deepEqual(late.times.map((time) => time.toFixed(1)), ["0.3", "0.4", "0.5", "0.6"]);
  assert.deepEqual(time_ticks(1, 1, 5).times, [1]);
  for (const [start, end, wanted] of [[0, 0.016, 3], [-1, 59, 11], [3, 3600, 9]]) {
    const { times, digits } = time_ticks(start, end, wanted);
    assert.ok(times.length >= 1 && times.length <= wanted + 1);
    assert.ok(times.every((time) => time >= start - 1e-9 && time <= end + 1e-6));
    assert.equal(new Set(times.map((time) => time.toFixed(digits))).size, times.length, "labels differ");
  }
});

test("the labels of an axis's ends differ, however close their values are", () => {
  assert.deepEqual(axis_texts(0, 12.34), ["0", "12.3"]);
  assert.deepEqual(axis_texts(99.87, 100.02), ["99.87", "100.02"]);
  assert.deepEqual(axis_texts(-1e-9, 5), ["0", "5"]);
  assert.deepEqual(axis_texts(-2, 3), ["-2", "3"]);
});
