import assert from "node:assert/strict";
import { test } from "node:test";
import { Player } from "./player";

test("a second at 60 fps shows 60 frames, whatever the display's rate", () => {
  for (const rate of [24, 59, 60, 144]) {
    const player = new Player(1000, 60);
    player.play();
    for (let k = 0; k < rate; ++k) player.advance(1 / rate);
    assert.ok(Math.abs(player.frame - 60) <= 1, `${player.frame} frames at ${rate}`);
  }
});

test("playback loops to the beginning, or stops at the last frame", () => {
  const player = new Player(10, 10);
  player.play();
  player.advance(1.25);
  assert.equal(player.frame, 2);
  player.loops = false;
  player.advance(5);
  assert.equal(player.frame, 9);
  assert.equal(player.playing, false);
});

test("at half speed playback takes twice as long", () => {
  const player = new Player(100, 20);
  player.speed = 0.5;
  player.play();
  player.advance(1);
  assert.equal(player.frame, 10);
});

test("steps pause playback, wrap around in a loop and stay within the frames", () => {
  const player = new Player(10, 10);
  player.play();
  player.step(-1);
  assert.equal(player.frame, 9);
  assert.equal(player.playing, false);
  player.step(1);
  assert.equal(player.frame, 0);
  player.step(-10);
  assert.equal(player.frame, 0);
  player.show(99);
  assert.equal(player.frame, 9);
});

test("a single frame cannot be played", () => {
  const player = new Player(1, 60);
  player.play();
  assert.equal(player.advance(1), false);
});
