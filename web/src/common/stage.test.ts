import assert from "node:assert/strict";
import { test } from "node:test";
import { spared_more, whole_cells } from "./stage";

test("a slow machine first drops shadows, then resolution, down to a limit", () => {
  let spared = { shadows: false, ratio: 1 };
  const seen = [spared];
  for (let k = 0; k < 20; ++k) {
    const more = spared_more(spared, 2);
    if (more === spared) break;
    seen.push((spared = more));
  }
  assert.deepEqual(seen[1], { shadows: true, ratio: 1 });
  assert.ok(seen[2].ratio > 1);
  assert.ok(seen.length < 10, "it ends");
  // The resolution never drops below a third of the page's pixels.
  assert.ok(2 / spared.ratio > 1 / 3);
  // A screen with more pixels gains no further step, because moving pictures have at most two pixels per page
  // pixel.
  assert.deepEqual(spared_more({ shadows: true, ratio: 1 }, 3), spared_more({ shadows: true, ratio: 1 }, 2));
});

test("a floor follows to within half a cell, and its lines stay where they are", () => {
  for (const cell of [0.05, 0.2, 1, 5])
    for (let way = -7.3; way < 8; way += 0.37) {
      const moved = whole_cells(way, cell);
      assert.ok(Math.abs(moved - way) <= 0.5 * cell * (1 + 1e-9), `${way} ${cell}`);
      assert.ok(Math.abs(moved / cell - Math.round(moved / cell)) < 1e-9);
    }
});
