/// Orders of this page and what became of them. It knows no element of the page.
import type { ControlMessage, Order, ReplyMessage, Sent } from "./protocol";

export interface Entry {
  id: number;
  op: string;
  state: "waiting" | "done" | "failed";
  text: string;
}

const MOST_ENTRIES = 20;
/** What a person orders for a scene older than this may arrive late, in a cell that has changed [ms]. */
export const MOST_SILENCE = 3000;
/** These make arms stand, or move nothing: they are sent also to a server that was not heard. */
const ALWAYS_SENT = new Set(["stop", "hold", "take", "release"]);

/** The token in the fragment of an address: "#token=…"; null: there is none. */
export function tokenIn(hash: string): string | null {
  return /^#token=([0-9a-f]{64})$/.exec(hash)?.[1] ?? null;
}

export class OrderBook {
  onChange: () => void = () => {};
  /** The newest first. */
  readonly entries: Entry[] = [];
  /** The server is one of a running cell; that of a recording takes no orders. */
  known = false;
  private control: ControlMessage | null = null;
  private number: number | null = null; // of this page, once it has taken control
  private stops = false; // as the server said last, also without a connection: pressing it then says that nothing is sent
  private asked = false; // for control, or seen that another page has it, since the page was opened
  private ids = 0;

  /** `silence`: since the server was heard [ms]. `seen`: time of the newest state on the server's clock [ms]; null: none. */
  constructor(private readonly send: (message: Sent) => boolean, private readonly token: string | null,
              private readonly silence: () => number, private readonly seen: () => number | null) {}

  setControl(control: ControlMessage): void {
    this.control = control;
    this.known = true;
    this.stops = control.stop;
    // Control that was lost stays lost until a person takes it again.
    if (this.number !== null && control.controller?.number !== this.number) {
      this.number = null;
      this.add({ id: 0, op: "take", state: "failed", text: "This page no longer controls the cell." });
    }
    // Of its own accord only when it is opened: a page that finds another in control does not follow it unseen.
    if (!this.asked && this.mayTake) this.take();
    this.asked = true;
    this.onChange();
  }

  setReply(reply: ReplyMessage): void {
    if (reply.op === "take" && reply.done) this.number = reply.number ?? null;
    if (reply.op === "release" && reply.done) this.number = null;
    const entry = this.entries.find((candidate) => candidate.id === reply.id);
    if (!entry) return;
    entry.state = !reply.done ? "failed" : reply.final ? "done" : "waiting";
    entry.text = reply.text;
    this.onChange();
  }

  /** No order is sent again: its outcome is unknown. */
  disconnected(): void {
    for (const entry of this.entries) {
      if (entry.state !== "waiting") continue;
      entry.state = "failed";
      entry.text += " (the connection was lost before the answer)";
    }
    this.control = null;
    this.number = null;
    this.onChange();
  }

  /** False: it was not sent. */
  give(order: Order, text: string): boolean {
    const id = ++this.ids;
    const always = ALWAYS_SENT.has(order.op);
    const seen = this.seen();
    const old = !always && (seen === null || this.silence() > MOST_SILENCE);
    const sent = !old && this.send(always || seen === null ? { ...order, id } : { ...order, id, seen });
    const why = old ? "the page hears nothing from its server" : "there is no connection";
    this.add({ id, op: order.op, state: sent ? "waiting" : "failed", text: sent ? text : `Not sent, ${why}: ${text}` });
    this.onChange();
    return sent;
  }

  stop(): void {
    if (this.offersStop) this.give({ op: "stop" }, "stop the cell");
  }

  take(): void {
    if (this.token === null) return;
    this.asked = true;
    this.give({ op: "take", token: this.token }, "take control");
  }

  /** Also while a person only looks. */
  keepControl(): void {
    if (this.controls) this.send({ op: "alive" });
  }

  /** An order of this kind has no answer yet. */
  waits(op: string): boolean {
    return this.entries.some((entry) => entry.op === op && entry.state === "waiting");
  }
  get controls(): boolean {
    return this.number !== null && this.control?.controller?.number === this.number;
  }
  get offersStop(): boolean {
    return this.stops || this.controls;
  }
  get mayTake(): boolean {
    return this.control !== null && this.control.control && this.token !== null && this.control.controller === null;
  }
  /** A view without orders. */
  get silent(): boolean {
    return this.control !== null && !this.control.stop && !this.control.control && this.control.refusal === "";
  }

  /** Who controls, for people. */
  get sentence(): string {
    if (this.control === null) return "Not connected: orders cannot be sent.";
    if (this.controls) return "This page controls the cell.";
    if (this.control.refusal !== "") return `No orders: ${this.control.refusal}`;
    if (!this.control.control) return this.control.stop ? "This page only stops the cell." : "This page only shows the cell.";
    if (this.control.controller !== null) return `The page at ${this.control.controller.address} controls the cell.`;
    return this.token === null ? "No page controls the cell. Open the address with the token to do so."
                               : "No page controls the cell.";
  }

  private add(entry: Entry): void {
    this.entries.unshift(entry);
    this.entries.length = Math.min(this.entries.length, MOST_ENTRIES);
  }
}
