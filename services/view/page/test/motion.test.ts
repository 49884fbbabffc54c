import assert from "node:assert/strict";
import { test } from "node:test";
import { freshness, PoseTrack, ServerClock, StateNumbers, Track } from "../src/motion";
import type { Pose } from "../src/protocol";

test("the clock follows the fastest message", () => {
  const clock = new ServerClock();
  assert.equal(clock.at(0), Number.NEGATIVE_INFINITY);
  clock.received(1000, 5040);
  clock.received(1033, 5045); // 28 ms faster
  clock.received(1066, 5150); // late
  assert.equal(clock.at(5045), 1033);
  clock.reset();
  clock.received(7, 6000);
  assert.equal(clock.at(6000), 7);
});

test("the clock forgets a message after five seconds", () => {
  const clock = new ServerClock();
  clock.received(0, 10);
  for (let i = 1; i <= 150; ++i) clock.received(33 * i, 33 * i + 20);
  assert.equal(clock.at(33 * 150 + 20), 33 * 150);
});

test("states whose numbers begin anew belong to another episode", () => {
  const numbers = new StateNumbers();
  assert.deepEqual([1, 2, 2, 7, 1, 2, 0].map((number) => numbers.beginsAnew(number)),
                   [false, false, false, false, true, false, true]);
});

test("a track interpolates and never extrapolates", () => {
  const track = new Track();
  const out: number[] = [];
  assert.equal(track.sample(0, out), false);
  assert.equal(track.add(100, [0, 10]), true);
  assert.equal(track.add(200, [1, 20]), true);
  assert.equal(track.sample(150, out), true);
  assert.deepEqual(out, [0.5, 15]);
  track.sample(50, out);
  assert.deepEqual(out, [0, 10]);
  track.sample(900, out);
  assert.deepEqual(out, [1, 20]);
});

test("a track ignores a sample that it has, and so its age grows", () => {
  const track = new Track();
  track.add(100, [0]);
  assert.equal(track.add(100.2, [0]), false);
  assert.equal(track.newestTime, 100);
});

test("a track finds its place among many samples", () => {
  const track = new Track();
  for (let i = 0; i < 100; ++i) track.add(10 * i, [i]);
  const out: number[] = [];
  track.sample(955, out);
  assert.deepEqual(out, [95.5]);
});

test("poses turn the shorter way and stay unit quaternions", () => {
  const track = new PoseTrack();
  const half = Math.SQRT1_2;
  track.add(0, [0, 0, 0, 0, 0, 0, 1]);
  track.add(100, [1, 0, 0, 0, 0, -half, -half] as Pose); // the same turn as (0, 0, half, half)
  const out: number[] = [];
  track.sample(50, out);
  assert.equal(out[0], 0.5);
  assert.ok(Math.abs(Math.hypot(...out.slice(3)) - 1) < 1e-12);
  assert.ok(Math.abs(2 * Math.atan2(out[5], out[6]) - Math.PI / 4) < 1e-12);
});

test("stale arms fade", () => {
  assert.equal(freshness(33), 1);
  assert.equal(freshness(Number.NEGATIVE_INFINITY), 1);
  assert.ok(freshness(1000) < 1 && freshness(1000) > 0.25);
  assert.equal(freshness(60_000), 0.25);
  assert.equal(freshness(Number.POSITIVE_INFINITY), 0.25);
});
