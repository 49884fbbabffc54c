import assert from "node:assert/strict";
import { test } from "node:test";
import { GoalDraft } from "../src/goal_draft";
import type { Pose, PreviewMessage, Sent } from "../src/protocol";

const HOME = [0, 1, 2];
const at = (x: number): Pose => [x, 0, 0, 0, 0, 0, 1];

function opened() {
  const sent: Sent[] = [];
  const world = { now: 1000, up: true };
  const draft = new GoalDraft((message) => {
    if (world.up) sent.push(message);
    return world.up;
  }, () => world.now);
  const questions = () => sent.map((message) => (message.op === "preview" ? message.pose[0] : NaN));
  /** To the newest question. */
  const answer = (change: Partial<PreviewMessage> = {}): void => {
    const asked = sent[sent.length - 1] as { id: number };
    draft.setAnswer({ type: "preview", id: asked.id, arm: "north", q: [3, 4, 5], verdict: "free", accepted: true, text: "",
                      pair: null, ...change });
  };
  return { draft, sent, world, questions, answer };
}

function dragging() {
  const page = opened();
  page.draft.begin("north", HOME);
  return page;
}

test("nothing is asked before the tool is dragged, and nothing can be ordered", () => {
  const { draft, sent } = dragging();
  draft.ask();
  assert.deepEqual(sent, []);
  assert.deepEqual(draft.q, HOME);
  assert.equal(draft.order, null);
  assert.match(draft.sentence, /north/);
});

test("a question begins where the ghost is", () => {
  const { draft, sent, world, answer } = dragging();
  draft.move(at(1));
  assert.deepEqual(sent, [{ op: "preview", id: -1, arm: "north", pose: at(1), start: HOME }]);
  answer();
  world.now += 50;
  draft.move(at(2));
  assert.deepEqual((sent[1] as { start: number[] }).start, [3, 4, 5]);
});

test("after a pose out of reach the search begins where the last pose was met", () => {
  const { draft, sent, world, answer } = dragging();
  draft.move(at(1));
  answer();
  world.now += 50;
  draft.move(at(2));
  answer({ verdict: "unreachable", accepted: false, q: [6, 7, 8] });
  assert.deepEqual(draft.q, [6, 7, 8]);
  world.now += 50;
  draft.move(at(3));
  assert.deepEqual((sent[2] as { start: number[] }).start, [3, 4, 5]);
});

test("at most twenty questions a second are sent, each about the newest pose", () => {
  const { draft, world, questions, answer } = dragging();
  for (let i = 0; i < 1000; ++i, world.now += 1) {
    draft.move(at(i));
    answer(); // at once
  }
  assert.equal(questions().length, 20);
  assert.deepEqual(questions(), Array.from({ length: 20 }, (_, i) => 50 * i));
});

test("one question is open at a time, and the newest pose comes next", () => {
  const { draft, world, questions, answer } = dragging();
  for (let i = 1; i <= 8; ++i, world.now += 100) draft.move(at(i));
  assert.deepEqual(questions(), [1]);
  answer();
  assert.deepEqual(questions(), [1, 8]);
  assert.equal(draft.settled, false);
  assert.equal(draft.mayGo, false);
  answer();
  assert.equal(draft.mayGo, true);
});

test("a lost answer is asked for again after a second", () => {
  const { draft, world, questions } = dragging();
  draft.move(at(1));
  world.now += 999;
  draft.ask();
  assert.deepEqual(questions(), [1]);
  world.now += 1;
  draft.ask();
  assert.deepEqual(questions(), [1, 1]);
});

test("while the ghost stands it is asked about twice a second, since others move", () => {
  const { draft, world, questions, answer } = dragging();
  draft.move(at(1));
  answer();
  for (let i = 0; i < 1000; ++i, ++world.now) {
    draft.ask();
    if (questions().length === 2 && !draft.blocked) answer({ verdict: "occupied", text: "north/hand and west/hand overlap by 3 mm" });
  }
  assert.equal(questions().length, 2);
  assert.equal(draft.blocked, true);
  assert.match(draft.sentence, /west/);
});

test("only what the cell would accept becomes an order", () => {
  for (const verdict of ["free", "near", "occupied"] as const) {
    const { draft, answer } = dragging();
    draft.move(at(1));
    answer({ verdict });
    assert.deepEqual(draft.order, { op: "goal", arm: "north", q: [3, 4, 5] }, verdict);
    assert.equal(draft.blocked, verdict === "occupied");
  }
  for (const verdict of ["collision", "unreachable", "unknown"] as const) {
    const { draft, answer } = dragging();
    draft.move(at(1));
    answer({ verdict, accepted: false, text: "no" });
    assert.equal(draft.order, null, verdict);
    assert.equal(draft.blocked, true);
    assert.deepEqual(draft.q, [3, 4, 5], "the ghost shows the nearest");
  }
});

test("a question that the server refuses blocks, with its sentence", () => {
  const { draft } = dragging();
  draft.move(at(1));
  draft.refused(-1, "this page does not control the cell");
  assert.equal(draft.order, null);
  assert.equal(draft.sentence, "this page does not control the cell");
});

test("after the end nothing is asked, and a late answer is ignored", () => {
  const { draft, sent, world, answer } = dragging();
  draft.move(at(1));
  world.now += 100;
  draft.move(at(2));
  draft.cancel();
  answer();
  world.now += 5000;
  draft.ask();
  draft.move(at(3));
  assert.equal(sent.length, 1);
  assert.equal(draft.arm, null);
  assert.equal(draft.order, null);
  draft.begin("north", HOME);
  answer();
  assert.deepEqual(draft.q, HOME, "the answer was for the former draft");
});

test("without a connection nothing is sent, and nothing can be ordered", () => {
  const { draft, sent, world } = dragging();
  world.up = false;
  draft.move(at(1));
  assert.deepEqual(sent, []);
  assert.equal(draft.order, null);
});
