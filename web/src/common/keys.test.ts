import assert from "node:assert/strict";
import { test } from "node:test";
import { name_of_key } from "./keys";

test("shift is named for letters and named keys; other characters already include it", () => {
  assert.equal(name_of_key({ key: "A", shiftKey: true }), "Shift+a");
  assert.equal(name_of_key({ key: "A", shiftKey: false }), "a"); // caps lock
  assert.equal(name_of_key({ key: "?", shiftKey: true }), "?");
  assert.equal(name_of_key({ key: "ArrowLeft", shiftKey: true }), "Shift+ArrowLeft");
  assert.equal(name_of_key({ key: " ", shiftKey: false }), " ");
});
