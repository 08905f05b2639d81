import assert from "node:assert/strict";
import { test } from "node:test";
import { read_array, read_frame } from "./wire";

function frame_bytes(points: number, cut = 0): ArrayBuffer {
  const size = 80 + 32 + ((6 * points + 3) & ~3);
  const buffer = new ArrayBuffer(size - cut);
  const view = new DataView(buffer);
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setUint16(2, 1, true);
  view.setUint32(4, 77, true);
  view.setBigUint64(32, 0x0123456789abcdefn, true);
  view.setUint32(76, size, true);
  [0.5, 1, 2].forEach((least, axis) => view.setFloat32(80 + 4 * axis, least, true));
  [0.25, 0.5, 0].forEach((step, axis) => view.setFloat32(92 + 4 * axis, step, true));
  view.setUint32(104, points, true);
  if (cut === 0) for (let k = 0; k < 3 * points; ++k) view.setUint16(112 + 2 * k, k, true);
  return buffer;
}

test("a frame's points are restored from their quantised steps", () => {
  const frame = read_frame(frame_bytes(2));
  assert.equal(frame.sequence, 77);
  assert.equal(frame.hash, "0123456789abcdef");
  assert.deepEqual([...frame.blocks.surface!], [0.5, 1.5, 2, 1.25, 3, 2]);
  assert.equal(frame.blocks.ghost, undefined);
});

test("the comparison bake's frame follows in the same message, and keeps its alignment", () => {
  const [first, second] = [new Uint8Array(frame_bytes(1)), new Uint8Array(frame_bytes(2))];
  second[0] = 3;
  const both = new Uint8Array(first.length + second.length);
  both.set(first);
  both.set(second, first.length);
  const frame = read_frame(both.buffer);
  assert.deepEqual([...frame.blocks.surface!], [0.5, 1.5, 2]);
  assert.deepEqual([...frame.beside!.blocks.surface!], [0.5, 1.5, 2, 1.25, 3, 2]);
  assert.equal(frame.beside!.beside, null);
  assert.equal(read_frame(first.buffer).beside, null);
  both[first.length] = 1; // a frame of the same kind
  assert.throws(() => read_frame(both.buffer), /invalid frame/);
});

test("a truncated message is reported, and not read past its end", () => {
  assert.throws(() => read_frame(frame_bytes(20, 60)), /invalid frame/);
  assert.throws(() => read_frame(new ArrayBuffer(10)), /invalid frame/);
  assert.throws(() => read_array(new ArrayBuffer(16)), /invalid array/);
});

test("an array is read with its name and its items", () => {
  const buffer = new ArrayBuffer(16 + 8 + 8);
  const view = new DataView(buffer);
  [2, 1, 3, 5].forEach((value, k) => view.setUint8(k, value));
  view.setUint32(4, 9, true);
  view.setUint32(8, 2, true);
  new Uint8Array(buffer).set(new TextEncoder().encode("fibre"), 16);
  view.setFloat32(24, 1.5, true);
  view.setFloat32(28, -2, true);
  const array = read_array(buffer);
  assert.equal(array.name, "fibre");
  assert.equal(array.body, 9);
  assert.deepEqual([...array.items], [1.5, -2]);
});
