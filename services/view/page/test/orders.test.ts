import assert from "node:assert/strict";
import { test } from "node:test";
import { MOST_SILENCE, OrderBook, tokenIn } from "../src/orders";
import type { ControlMessage, Order, ReplyMessage, Sent } from "../src/protocol";

const TOKEN = "0123456789abcdef".repeat(4);

const control = (change: Partial<ControlMessage> = {}): ControlMessage => ({
  type: "control", stop: true, control: true, refusal: "", controller: null, ...change,
});
const reply = (id: number, op: string, change: Partial<ReplyMessage> = {}): ReplyMessage => ({
  type: "reply", id, op, done: true, final: true, text: "text", ...change,
});

interface Link {
  up: boolean;
  silence: number; // [ms]
  seen: number | null; // [ms]
}

function opened(token: string | null = TOKEN): { book: OrderBook; sent: Sent[]; link: Link } {
  const sent: Sent[] = [];
  const link = { up: true, silence: 20, seen: 5000.5 };
  const book = new OrderBook((message) => {
    if (link.up) sent.push(message);
    return link.up;
  }, token, () => link.silence, () => link.seen);
  return { book, sent, link };
}

/** A page that controls. */
function controlling(): ReturnType<typeof opened> {
  const page = opened();
  page.book.setControl(control());
  page.book.setReply(reply(1, "take", { number: 7 }));
  page.book.setControl(control({ controller: { number: 7, address: "127.0.0.1:1" } }));
  page.sent.length = 0;
  return page;
}

test("only a whole token in the fragment counts", () => {
  assert.equal(tokenIn(`#token=${TOKEN}`), TOKEN);
  assert.equal(tokenIn("#token=12"), null);
  assert.equal(tokenIn(`#token=${TOKEN}&x`), null);
  assert.equal(tokenIn(""), null);
});

test("a page without token only stops", () => {
  const { book, sent } = opened(null);
  book.setControl(control());
  assert.equal(book.mayTake, false);
  book.stop();
  assert.deepEqual(sent, [{ op: "stop", id: 1 }]);
});

test("a page with token takes control once, when it is opened", () => {
  const { book, sent } = opened();
  book.setControl(control());
  book.setControl(control());
  assert.deepEqual(sent, [{ op: "take", token: TOKEN, id: 1 }]);
});

test("a page that found another in control takes it on a person's order only", () => {
  const { book, sent } = opened();
  book.setControl(control({ controller: { number: 1, address: "127.0.0.1:1" } }));
  assert.match(book.sentence, /127\.0\.0\.1:1 controls/);
  book.setControl(control());
  assert.deepEqual(sent, []);
  assert.equal(book.sentence, "No page controls the cell.");
  book.take();
  assert.deepEqual(sent, [{ op: "take", token: TOKEN, id: 1 }]);
});

test("control that was lost is not taken again without a person", () => {
  const { book, sent } = controlling();
  assert.equal(book.controls, true);
  book.keepControl();
  assert.deepEqual(sent, [{ op: "alive" }]);
  book.setControl(control());
  assert.equal(book.controls, false);
  book.keepControl();
  assert.equal(sent.length, 1);
  assert.equal(book.entries[0].state, "failed");
  book.take();
  assert.equal(sent.length, 2);
});

test("a lost connection sends nothing, then or later", () => {
  const { book, sent, link } = controlling();
  book.give({ op: "hold" }, "hold the cell");
  link.up = false;
  book.disconnected();
  assert.equal(book.entries[0].state, "failed");
  assert.match(book.entries[0].text, /connection was lost/);
  assert.equal(book.give({ op: "hold" }, "hold the cell"), false);
  book.stop();
  assert.match(book.entries[0].text, /Not sent/);
  link.up = true;
  book.setControl(control());
  assert.equal(sent.length, 1);
});

test("with --no-stop only the page that controls stops", () => {
  const other = opened(null);
  other.book.setControl(control({ stop: false }));
  other.book.stop();
  assert.deepEqual(other.sent, []);
  const { book, sent } = controlling();
  book.setControl(control({ stop: false, controller: { number: 7, address: "127.0.0.1:1" } }));
  book.stop();
  assert.equal(sent.length, 1);
});

test("an order has its outcome", () => {
  const { book } = controlling();
  book.give({ op: "goal", arm: "north", named: "ready" }, "north to ready");
  const { id } = book.entries[0];
  book.setReply(reply(id, "goal", { final: false, text: "sent" }));
  assert.equal(book.entries[0].state, "waiting");
  book.setReply(reply(id, "goal", { done: false, text: "rejected, no path" }));
  assert.deepEqual(book.entries[0], { id, op: "goal", state: "failed", text: "rejected, no path" });
});

test("what moves arms is not sent to a server that was not heard for long: it may arrive late", () => {
  const { book, sent, link } = controlling();
  link.silence = MOST_SILENCE + 1;
  const moving: Order[] = [
    { op: "resume" }, { op: "resume", arms: ["north"] }, { op: "goal", arm: "north", named: "ready" },
    { op: "goal", arm: "north", q: [0] }, { op: "obstacle_move", name: "crate", pose: [0, 0, 0, 0, 0, 0, 1] },
    { op: "obstacle_remove", name: "crate" },
  ];
  for (const order of moving) {
    assert.equal(book.give(order, "move"), false);
    assert.equal(book.entries[0].state, "failed");
    assert.equal(book.entries[0].text, "Not sent, the page hears nothing from its server: move");
  }
  assert.equal(sent.length, 0);
  book.stop();
  assert.equal(book.give({ op: "hold", arms: ["north"] }, "hold north"), true);
  assert.deepEqual(sent.map((message) => message.op), ["stop", "hold"]);
  link.silence = MOST_SILENCE;
  assert.equal(book.give({ op: "resume" }, "resume"), true);
});

test("what moves arms names the newest state, so that the server can refuse it when it arrives late", () => {
  const { book, sent, link } = controlling();
  book.give({ op: "resume" }, "resume");
  link.seen = 6000;
  book.give({ op: "obstacle_remove", name: "crate" }, "remove crate");
  book.give({ op: "hold" }, "hold the cell");
  book.stop();
  assert.deepEqual(sent, [{ op: "resume", id: 2, seen: 5000.5 }, { op: "obstacle_remove", name: "crate", id: 3, seen: 6000 },
                          { op: "hold", id: 4 }, { op: "stop", id: 5 }]);
});

test("what moves arms is not sent before a state was received", () => {
  const { book, sent, link } = controlling();
  link.seen = null;
  assert.equal(book.give({ op: "resume" }, "resume"), false);
  assert.equal(book.give({ op: "hold" }, "hold the cell"), true);
  assert.deepEqual(sent, [{ op: "hold", id: 3 }]);
});
