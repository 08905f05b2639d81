import assert from "node:assert/strict";
import { test } from "node:test";
import { lower_neighbours } from "./motion";
import { bit_length, RangeDecoder } from "./range_decoder";

test("neighbours have lower numbers; at most the four highest are kept", () => {
  // A fan around vertex 6.
  const triangles = [6, 0, 1, 6, 1, 2, 6, 2, 3, 6, 3, 4, 6, 4, 5];
  const { offset, point } = lower_neighbours(7, triangles);
  assert.deepEqual([...point.slice(offset[6], offset[7])], [2, 3, 4, 5]);
  assert.deepEqual([...point.slice(offset[1], offset[2])], [0]);
  assert.equal(offset[1] - offset[0], 0);
});

test("a triangle with a repeated vertex does not make it its own neighbour", () => {
  const { offset, point } = lower_neighbours(3, [0, 2, 2]);
  assert.deepEqual([...point.slice(offset[2], offset[3])], [0]);
});

test("the bit length of a number", () => {
  assert.deepEqual([0, 1, -1, 2, 255, -256, 2 ** 30].map(bit_length), [0, 1, 1, 2, 8, 9, 31]);
});

test("truncated data is reported, and not read past its end", () => {
  const decoder = new RangeDecoder(new Uint8Array(5));
  assert.throws(() => decoder.direct(31), /too early/);
});
