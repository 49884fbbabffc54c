import assert from "node:assert/strict";
import { test } from "node:test";
import type { ArmStatus } from "../src/protocol";
import { ageText, distanceText, matches, offsetText, modeText, reasonOf, shareOf, stateOf, toolText } from "../src/words";

const arm = (change: Partial<ArmStatus> = {}): ArmStatus => ({
  name: "north", mode: "run", speed_override: 1, waiting: null, planner: "planner/north", drive: "running", goal: null, tool: null,
  lost: false,
  ...change,
});
const cause = (kind: string, text = "why"): ArmStatus["waiting"] => ({ kind, subject: "", text });

test("each state of an arm has its word", () => {
  assert.equal(stateOf(arm(), 10), "moving");
  assert.equal(stateOf(arm({ waiting: cause("giving_way") }), 10), "waiting");
  assert.equal(stateOf(arm({ waiting: cause("no_goal") }), 10), "idle");
  assert.equal(stateOf(arm({ mode: "hold", waiting: cause("hold_ordered") }), 10), "held");
  assert.equal(stateOf(arm({ mode: "unknown" }), 10), "held");
  assert.equal(stateOf(arm({ mode: "stop" }), 10), "stopped");
  assert.equal(stateOf(arm({ drive: "failed" }), 10), "fault");
  assert.equal(stateOf(arm({ drive: "observed", mode: "hold" }), 10), "observed");
});

test("a lost or stale arm is not called moving", () => {
  assert.equal(stateOf(arm(), 800), "stale");
  assert.equal(stateOf(arm(), Number.POSITIVE_INFINITY), "stale");
  assert.equal(stateOf(arm(), Number.NaN), "stale");
  assert.equal(stateOf(arm({ lost: true }), 800), "lost");
});

test("the reason is the sentence of the cell", () => {
  assert.equal(reasonOf(arm({ waiting: cause("path_blocked", "blocked: by west") })), "blocked: by west");
  assert.equal(reasonOf(arm({ waiting: cause("no_goal", "a goal; the last was reached") })),
               "waits for a goal; the last was reached");
  assert.equal(reasonOf(arm({ waiting: cause("mode_unknown", "") })), "mode unknown");
  assert.equal(reasonOf(arm()), "moves");
});

test("a gripper has a width and holds something", () => {
  assert.equal(toolText(null), "no gripper");
  assert.equal(toolText({ moving: false, width: 0.0402, holding: "crate" }), "40 mm wide, holds crate");
  assert.equal(toolText({ moving: true, width: null, holding: "" }), "width not known, moves, holds nothing");
});

test("ages and distances have units", () => {
  assert.equal(ageText(3.6), "4 ms");
  assert.equal(ageText(2500), "2.5 s");
  assert.equal(ageText(125_000), "2 min 5 s");
  assert.equal(ageText(null), "never");
  assert.equal(ageText(Number.POSITIVE_INFINITY), "never");
  assert.equal(distanceText(0.0312), "31 mm");
  assert.equal(distanceText(-0.002), "-2 mm");
  assert.equal(distanceText(1.5), "1.50 m");
});

test("times of a recording have minutes, and hours where there are some", () => {
  assert.equal(offsetText(0), "0:00.000");
  assert.equal(offsetText(62_345.4), "1:02.345");
  assert.equal(offsetText(3_723_004), "1:02:03.004");
  assert.equal(offsetText(-5), "0:00.000");
});

test("a place on the time line is within the recording", () => {
  assert.equal(shareOf(25, 100), 0.25);
  assert.equal(shareOf(-3, 100), 0);
  assert.equal(shareOf(130, 100), 1);
  assert.equal(shareOf(5, 0), 0);
});

test("a search finds all of its words, in any order and case", () => {
  assert.ok(matches("", "north"));
  assert.ok(matches("NOR wait", "north", "waits for west"));
  assert.ok(!matches("north south", "north"));
});

test("the mode says a lower speed", () => {
  assert.equal(modeText({ mode: "run", mode_age: 5, speed_override: 1 }), "RUN");
  assert.equal(modeText({ mode: "run", mode_age: 20, speed_override: 0.3 }), "RUN 30 %");
  assert.equal(modeText({ mode: "hold", mode_age: 5, speed_override: 0.015 }), "HOLD 1.5 %");
  assert.equal(modeText({ mode: null, mode_age: null, speed_override: null }), "NO SUPERVISOR");
  assert.equal(modeText({ mode: "run", mode_age: 3200, speed_override: 0.3 }), "NO SUPERVISOR FOR 3.2 s, LAST RUN 30 %");
});
