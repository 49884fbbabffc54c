/// Nearest points of two capsules, for the line of the binding pair. The distance that the page shows is the planner's.

export type Point = readonly [number, number, number];

/** A capsule in W: the ends of its axis, and its radius. */
export interface Segment {
  a: Point;
  b: Point;
  radius: number;
}

const minus = (p: Point, q: Point): Point => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
const dot = (p: Point, q: Point): number => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
const along = (p: Point, d: Point, s: number): Point => [p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]];
const clamp = (s: number): number => Math.min(1, Math.max(0, s));

export interface Nearest {
  distance: number; // between the surfaces; negative when they overlap
  own: Point; // on the surface of the first one
  other: Point;
}

/** Points of two segments with the smallest distance [Ericson 2004, 5.1.9]. */
export function nearest(first: Segment, second: Segment): Nearest {
  const d1 = minus(first.b, first.a);
  const d2 = minus(second.b, second.a);
  const r = minus(first.a, second.a);
  const a = dot(d1, d1);
  const e = dot(d2, d2);
  const f = dot(d2, r);
  const c = dot(d1, r);
  const b = dot(d1, d2);
  const EPSILON = 1e-12;
  let s = 0;
  let t = 0;
  if (a > EPSILON && e > EPSILON) {
    const denominator = a * e - b * b;
    if (denominator > EPSILON * a * e) s = clamp((b * f - c * e) / denominator);
    t = (b * s + f) / e;
    if (t < 0) {
      t = 0;
      s = clamp(-c / a);
    } else if (t > 1) {
      t = 1;
      s = clamp((b - c) / a);
    }
  } else if (a > EPSILON) {
    s = clamp(-c / a);
  } else if (e > EPSILON) {
    t = clamp(f / e);
  }
  const p = along(first.a, d1, s);
  const q = along(second.a, d2, t);
  const between = minus(q, p);
  const length = Math.sqrt(dot(between, between));
  const unit: Point = length > 1e-9 ? [between[0] / length, between[1] / length, between[2] / length] : [0, 0, 1];
  return {
    distance: length - first.radius - second.radius,
    own: along(p, unit, Math.min(first.radius, length)),
    other: along(q, unit, -Math.min(second.radius, length)),
  };
}

/** The nearest pair of two bodies, each of several capsules; undefined when one has none. */
export function nearestOf(first: readonly Segment[], second: readonly Segment[]): Nearest | undefined {
  let best: Nearest | undefined;
  for (const own of first) {
    for (const other of second) {
      const found = nearest(own, other);
      if (!best || found.distance < best.distance) best = found;
    }
  }
  return best;
}
