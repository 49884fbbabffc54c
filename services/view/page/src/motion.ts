/// Smooth motion from states that arrive 30 times a second: the page shows the cell a little in the past, between two
/// states that it has. It never extrapolates.
import type { Pose } from "./protocol";

/** How far in the past the page shows the cell. One state may be late, and the motion is still smooth. */
export const SHOWN_DELAY = 80;
const WINDOW = 150; // messages; five seconds

/** The clock of the server on this machine, from the messages that took the shortest time. */
export class ServerClock {
  private readonly offsets: number[] = [];
  private next = 0;
  private offset = Number.POSITIVE_INFINITY;

  /** A message of server time `t` arrived at local time `now`. */
  received(t: number, now: number): void {
    this.offsets[this.next] = now - t;
    this.next = (this.next + 1) % WINDOW;
    this.offset = Math.min(...this.offsets);
  }
  /** The server's time at local time `now`; before the first message −∞. */
  at(now: number): number {
    return now - this.offset;
  }
  /** After a new connection: the server may be another process. */
  reset(): void {
    this.offsets.length = 0;
    this.next = 0;
    this.offset = Number.POSITIVE_INFINITY;
  }
}

/** The states of an arm that its driver numbers from 1 on. A recorded simulation begins anew with each episode. */
export class StateNumbers {
  private newest = 0;

  /** True: the driver has begun anew, so the arm may be elsewhere without having moved there. */
  beginsAnew(number: number): boolean {
    const anew = number < this.newest;
    this.newest = number;
    return anew;
  }
}

/** The last values of a vector with the server's times of their measurement. */
export class Track {
  private readonly times: number[] = [];
  private readonly values: (readonly number[])[] = [];

  /** Returns false for a value that was known before. */
  add(time: number, value: readonly number[]): boolean {
    const newest = this.times.length - 1;
    // The same sample's time varies by what the server rounds off.
    if (newest >= 0 && time <= this.times[newest] + 0.5) return false;
    this.times.push(time);
    this.values.push(value);
    if (this.times.length > 16) {
      this.times.shift();
      this.values.shift();
    }
    return true;
  }

  get newestTime(): number {
    return this.times.length ? this.times[this.times.length - 1] : Number.NEGATIVE_INFINITY;
  }
  get newest(): readonly number[] | undefined {
    return this.values[this.values.length - 1];
  }

  /** Writes the value at `time` to `out`; false when there is none. Before the oldest and after the newest it stays. */
  sample(time: number, out: number[]): boolean {
    const last = this.times.length - 1;
    if (last < 0) return false;
    let i = last;
    while (i > 0 && this.times[i - 1] > time) --i;
    const later = this.values[i];
    const earlier = i > 0 ? this.values[i - 1] : later;
    const span = i > 0 ? this.times[i] - this.times[i - 1] : 1;
    const share = i > 0 ? Math.min(1, Math.max(0, (time - this.times[i - 1]) / span)) : 1;
    out.length = later.length;
    for (let k = 0; k < later.length; ++k) {
      const from = earlier[k] ?? later[k];
      out[k] = from + (later[k] - from) * share;
    }
    return true;
  }
}

/** As Track, for poses: orientations on the shorter way. */
export class PoseTrack {
  private readonly track = new Track();
  private readonly raw: number[] = [];

  add(time: number, pose: Pose): void {
    const newest = this.track.newest;
    let value: readonly number[] = pose;
    if (newest) {
      const dot = newest[3] * pose[3] + newest[4] * pose[4] + newest[5] * pose[5] + newest[6] * pose[6];
      if (dot < 0) value = [pose[0], pose[1], pose[2], -pose[3], -pose[4], -pose[5], -pose[6]];
    }
    this.track.add(time, value);
  }
  sample(time: number, out: number[]): boolean {
    if (!this.track.sample(time, this.raw)) return false;
    const length = Math.hypot(this.raw[3], this.raw[4], this.raw[5], this.raw[6]) || 1;
    for (let k = 0; k < 3; ++k) out[k] = this.raw[k];
    for (let k = 3; k < 7; ++k) out[k] = this.raw[k] / length;
    return true;
  }
  get newestTime(): number {
    return this.track.newestTime;
  }
}

/** How much of an arm is visible at this age of its state [ms]: 1 while it is fresh, down to 0.25. */
export function freshness(age: number): number {
  const FRESH = 150;
  const STALE = 2000;
  if (!(age > FRESH)) return 1;
  return 1 - 0.75 * Math.min(1, (age - FRESH) / (STALE - FRESH));
}
