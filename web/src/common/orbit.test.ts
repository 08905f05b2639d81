import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import { Orbit, VIEWS } from "./orbit";

// Points on a sphere around 0.
function ball(radius: number): number[] {
  const points: number[] = [];
  for (let k = 0; k < 400; ++k) {
    const height = 1 - (2 * k) / 399;
    const flat = Math.sqrt(1 - height * height);
    points.push(radius * flat * Math.cos(2.4 * k), radius * height, radius * flat * Math.sin(2.4 * k));
  }
  return points;
}

function framed(points: number[], aspect: number): [Orbit, PerspectiveCamera] {
  const orbit = new Orbit(() => undefined);
  const camera = new PerspectiveCamera(32, aspect, 0.1, 100);
  orbit.frame(new Vector3(1, 2, 3), points, (32 * Math.PI) / 180, aspect);
  orbit.apply(camera);
  camera.updateMatrixWorld();
  return [orbit, camera];
}

test("framed points fit and fill pictures of any aspect", () => {
  const shapes = [ball(2), ball(1).map((value, k) => (k % 3 === 1 ? 5 * value : value))];
  for (const points of shapes)
    for (const aspect of [0.4, 1, 2.2]) {
      const [orbit, camera] = framed(points, aspect);
      let most = 0;
      for (const view of Object.values(VIEWS)) {
        orbit.look(view);
        orbit.apply(camera);
        camera.updateMatrixWorld();
        for (let k = 0; k < points.length; k += 3) {
          const point = new Vector3(1 + points[k], 2 + points[k + 1], 3 + points[k + 2]).project(camera);
          most = Math.max(most, Math.abs(point.x), Math.abs(point.y));
          assert.ok(Math.abs(point.z) <= 1);
        }
      }
      assert.ok(most <= 1 && most > 0.85, `${aspect}: ${most}`);
    }
});

test("panning to the right moves the picture to the right", () => {
  const [orbit, camera] = framed(ball(1), 1);
  const before = new Vector3(1, 2, 3).project(camera);
  orbit.pan(0.1, 0);
  orbit.apply(camera);
  camera.updateMatrixWorld();
  const after = new Vector3(1, 2, 3).project(camera);
  assert.ok(after.x > before.x + 0.05);
  assert.ok(Math.abs(after.y - before.y) < 1e-6);
});

test("the camera never passes over the top", () => {
  const [orbit] = framed(ball(1), 1);
  orbit.turn(0, 100);
  assert.ok(orbit.elevation < Math.PI / 2);
});
