import assert from "node:assert/strict";
import { test } from "node:test";
import { nearest, nearestOf, type Point, type Segment } from "../src/nearest";

/** The smallest distance of the axes among many pairs of points. */
function byScan(first: Segment, second: Segment): number {
  const STEPS = 200;
  let best = Number.POSITIVE_INFINITY;
  for (let i = 0; i <= STEPS; ++i) {
    for (let k = 0; k <= STEPS; ++k) {
      const at = (s: Segment, share: number, axis: number): number => s.a[axis] + (s.b[axis] - s.a[axis]) * share;
      best = Math.min(best, Math.hypot(...[0, 1, 2].map((axis) =>
        at(first, i / STEPS, axis) - at(second, k / STEPS, axis))));
    }
  }
  return best - first.radius - second.radius;
}

test("the distance of capsules agrees with a scan over both axes", () => {
  let seed = 7;
  const random = (): number => ((seed = (seed * 16807) % 2147483647) / 2147483647) * 2 - 1;
  const point = (): Point => [random(), random(), random()];
  for (let i = 0; i < 40; ++i) {
    const first = { a: point(), b: point(), radius: 0.05 };
    const second = { a: point(), b: point(), radius: 0.1 };
    const found = nearest(first, second);
    assert.ok(Math.abs(found.distance - byScan(first, second)) < 0.012, `pair ${i}`);
    const between = Math.hypot(...[0, 1, 2].map((axis) => found.own[axis] - found.other[axis]));
    if (found.distance > 0) assert.ok(Math.abs(between - found.distance) < 1e-9, `points of pair ${i}`);
  }
});

test("balls, parallel axes and equal centres have a distance", () => {
  const ball = (x: number): Segment => ({ a: [x, 0, 0], b: [x, 0, 0], radius: 0.5 });
  assert.ok(Math.abs(nearest(ball(0), ball(3)).distance - 2) < 1e-12);
  assert.equal(nearest(ball(0), ball(0)).distance, -1);
  const rod = (y: number): Segment => ({ a: [0, y, 0], b: [1, y, 0], radius: 0.1 });
  assert.ok(Math.abs(nearest(rod(0), rod(1)).distance - 0.8) < 1e-12);
  assert.ok(Math.abs(nearest(rod(0), ball(3)).distance - (2 - 0.6)) < 1e-12);
});

test("bodies take the nearest of their capsules", () => {
  const ball = (x: number): Segment => ({ a: [x, 0, 0], b: [x, 0, 0], radius: 0.5 });
  assert.equal(nearestOf([ball(0), ball(10)], [ball(12)])?.distance, 1);
  assert.equal(nearestOf([], [ball(0)]), undefined);
});
