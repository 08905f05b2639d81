import assert from "node:assert/strict";
import { test } from "node:test";
import { in_full, nice_above, short_number } from "./numbers";

test("nice numbers are 1, 2 or 5 times a power of ten, and never below the value", () => {
  for (const [value, nice] of [[1, 1], [1.01, 2], [3, 5], [5.1, 10], [0.031, 0.05], [700, 1000]])
    assert.ok(Math.abs(nice_above(value) - nice) < 1e-9 * nice, `${value}`);
});

test("numbers in full keep what distinguishes rates and durations", () => {
  for (const text of ["24", "23.976", "29.97", "59.94", "1234.5", "0", "0.042", "120", "100000"])
    assert.equal(in_full(Number(text)), text);
  assert.equal(in_full(24000 / 1001), "23.976");
  assert.equal(in_full(36 / 23.976), "1.502");
});

test("short numbers have three significant digits", () => {
  assert.equal(short_number(0), "0");
  assert.equal(short_number(12.345), "12.3");
  assert.equal(short_number(0.01234), "0.0123");
  assert.equal(short_number(1234), "1230");
  assert.equal(short_number(1.5e-7), "1.50e-7");
});
