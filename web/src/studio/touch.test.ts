import assert from "node:assert/strict";
import { test } from "node:test";
import type { SceneKey } from "./protocol";
import { is_near, title_of } from "./touch";

const key = (path: string, more: Partial<SceneKey> = {}): SceneKey => ({
  path,
  name: path,
  doc: "",
  kind: "number",
  value: 1,
  is_set: false,
  fallback: null,
  effect: "live",
  ...more,
});

test("of the equivalent keys for a layer's stiffness, the one that the scene sets is shown", () => {
  const is_set = (path: string) => path === "layers.fat.alpha";
  const slider = { soft_minimum: 0, soft_maximum: 1 };
  assert.ok(is_near(key("layers.fat.alpha", { ...slider, is_set: true, rivals: ["layers.fat.frequency"] }), is_set));
  assert.ok(!is_near(key("layers.fat.frequency", { ...slider, rivals: ["layers.fat.alpha"] }), is_set));
  assert.ok(is_near(key("layers.fat.damping", slider), is_set));
  assert.ok(is_near(key("gravity", { kind: "vector" }), is_set));
  assert.ok(!is_near(key("solver.seed"), is_set));
});

test("keys that the scene would refuse are hidden", () => {
  const slider = { soft_minimum: 0, soft_maximum: 1 };
  assert.ok(is_near(key("layers.fat.least_volume", slider), () => false));
  assert.ok(!is_near(key("layers.fat.least_volume", { ...slider, why_unused: "for the implicit integrator" }), () => false));
});

test("groups have readable titles", () => {
  const title = (path: string) => title_of({ path, title: path, doc: "", keys: [] });
  assert.equal(title("layers.fat"), "Layer fat");
  assert.equal(title("layers.fat.where.bone_distance"), "Layer fat, where bone distance");
  assert.equal(title("flesh"), "Flesh");
  assert.equal(title(""), "Scene");
});
