import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, Quaternion, Vector3 } from "three";
import type { SolidMessage } from "./protocol";
import { distance_to, floor_of, poses_of, rounded_box, touching } from "./solids";
import type { Pose } from "./solids";

const UPRIGHT: Pose = { middle: [0, 0, 0], axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] };
const solid = (shape: SolidMessage["shape"], half_size: [number, number, number], radius: number): SolidMessage => ({
  name: shape,
  shape,
  half_size,
  radius,
  middle: [0, 0, 0],
  up: [0, 1, 0],
});

function turned(middle: Vector3, rotation: Quaternion): Pose {
  const matrix = new Matrix4().makeRotationFromQuaternion(rotation);
  const axis = (column: number) => new Vector3().setFromMatrixColumn(matrix, column).toArray();
  return { middle: middle.toArray(), axes: [axis(0), axis(1), axis(2)] };
}

test("distances match values calculated by hand", () => {
  assert.equal(distance_to(solid("plane", [0, 0, 0], 0.1), UPRIGHT, 5, 0.3, -7), 0.3 - 0.1);
  assert.ok(Math.abs(distance_to(solid("sphere", [0, 0, 0], 2), UPRIGHT, 3, 4, 0) - 3) < 1e-12);
  const capsule = solid("capsule", [0, 1, 0], 0.5);
  assert.ok(Math.abs(distance_to(capsule, UPRIGHT, 0.8, 0.3, 0) - 0.3) < 1e-12);
  assert.ok(Math.abs(distance_to(capsule, UPRIGHT, 0, 2, 0) - 0.5) < 1e-12);
  const box = solid("box", [1, 2, 3], 0);
  assert.ok(Math.abs(distance_to(box, UPRIGHT, 2, 3, 0) - Math.SQRT2) < 1e-12);
  assert.ok(Math.abs(distance_to(box, UPRIGHT, 0.9, 0, 0) + 0.1) < 1e-12);
});

test("the drawn vertices of a solid lie on its surface in any pose", () => {
  const rotation = new Quaternion().setFromAxisAngle(new Vector3(1, 2, -0.5).normalize(), 0.7);
  const pose = turned(new Vector3(0.4, -1, 2), rotation);
  for (const one of [solid("sphere", [0, 0, 0], 0.3), solid("capsule", [0, 0.5, 0], 0.2), solid("box", [0.3, 0.5, 0.1], 0.05)]) {
    const { positions, triangles } = rounded_box(one.half_size, one.radius);
    assert.ok(triangles.every((corner) => corner < positions.length / 3));
    for (let k = 0; k < positions.length; k += 3) {
      const place = new Vector3(positions[k], positions[k + 1], positions[k + 2]).applyQuaternion(rotation);
      place.add(new Vector3(...pose.middle));
      assert.ok(Math.abs(distance_to(one, pose, place.x, place.y, place.z)) < 1e-6, one.shape);
    }
  }
});

test("the pose of a solid is read from its four points, and rounding does not stretch it", () => {
  const rotation = new Quaternion().setFromAxisAngle(new Vector3(0, 0.6, 0.8), 1.1);
  const pose = turned(new Vector3(3, 2, 1), rotation);
  const numbers = [...pose.middle, ...pose.axes.flatMap((axis) => axis.map((one, c) => 1.0003 * one + pose.middle[c]))];
  const [read] = poses_of(Float32Array.from(numbers));
  read.axes.forEach((axis, a) => {
    assert.ok(Math.abs(Math.hypot(...axis) - 1) < 1e-6);
    axis.forEach((one, c) => assert.ok(Math.abs(one - pose.axes[a][c]) < 1e-5));
  });
});

test("the floor of a falling body is the highest plane below it", () => {
  const at = (y: number, up: [number, number, number] = [0, 1, 0], radius = 0): SolidMessage => ({
    ...solid("plane", [0, 0, 0], radius),
    middle: [0, y, 0],
    up,
  });
  assert.equal(floor_of([], 0.3), 0.3);
  assert.equal(floor_of([at(-1), at(-2), at(1)], 0.3), -1);
  assert.equal(floor_of([at(-1, [0, 1, 0], 0.25)], 0.3), -0.75);
  assert.equal(floor_of([at(-1, [0, -1, 0]), at(-1, [1, 0, 0])], 0.3), 0.3);
  // A slope of 45 degrees through (1, -2, 0), 3 m away.
  assert.ok(Math.abs(floor_of([{ ...at(-2, [Math.SQRT1_2, Math.SQRT1_2, 0]), middle: [1, -2, 0] }], 0.3, 4, 9) + 5) < 1e-12);
  assert.equal(floor_of([solid("box", [1, 1, 1], 0)], 0.3), 0.3);
});

test("free vertices within the gap touch; kinematic, deeper and distant ones do not", () => {
  const vertices = Float32Array.from([0, 0, 0, 0, 0.0009, 0, 0, -0.5, 0, 0, 0.5, 0, 0, 0.0005, 0]);
  const floor = solid("plane", [0, 0, 0], 0);
  assert.deepEqual(touching([floor], [UPRIGHT], vertices, Uint8Array.from([0, 0, 0, 0, 1]), 0.001), [0, 1]);
});
