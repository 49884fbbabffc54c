/// A goal that a person drags: what the page asks the server about it, and what the server answers. It knows no element
/// of the page and no scene. Nothing of it moves an arm before order() is given.
import type { Order, Pose, PreviewMessage, Sent } from "./protocol";

const PERIOD = 50; // between two questions [ms]
const REFRESH = 500; // after it, the newest pose is asked again: obstacles and other arms move [ms]
const PATIENCE = 1000; // for an answer [ms]

export class GoalDraft {
  onChange: () => void = () => {};
  /** Of the ghost; empty: no draft. */
  q: readonly number[] = [];
  private start: readonly number[] = []; // of the next search: where the ghost last met its pose
  private name: string | null = null;
  private pose: Pose | null = null; // wanted, since the tool was dragged
  private answer: PreviewMessage | null = null;
  private refusal = "";
  private ids = 0; // below 0: not those of orders
  private asked: { id: number; pose: Pose; at: number } | null = null; // without an answer
  private lastAsked = Number.NEGATIVE_INFINITY;
  private answered: Pose | null = null;

  constructor(private readonly send: (message: Sent) => boolean, private readonly clock: () => number) {}

  begin(arm: string, q: readonly number[]): void {
    this.name = arm;
    this.q = this.start = [...q];
    this.pose = this.answered = this.answer = this.asked = null;
    this.refusal = "";
    this.onChange();
  }
  /** Nothing is sent, then or later. */
  cancel(): void {
    if (this.name === null) return;
    this.name = this.pose = this.answered = this.answer = this.asked = null;
    this.q = [];
    this.onChange();
  }

  /** The tool is wanted there. */
  move(pose: Pose): void {
    if (this.name === null) return;
    this.pose = pose;
    this.ask();
    this.onChange();
  }

  /** Call it often. Asks for the newest pose when that is due. */
  ask(): void {
    if (this.name === null || this.pose === null) return;
    const now = this.clock();
    if (now - this.lastAsked < (this.settled ? REFRESH : PERIOD)) return;
    if (this.asked !== null && now - this.asked.at < PATIENCE) return;
    const id = --this.ids;
    if (!this.send({ op: "preview", id, arm: this.name, pose: this.pose, start: [...this.start] })) return;
    this.asked = { id, pose: this.pose, at: now };
    this.lastAsked = now;
  }

  setAnswer(answer: PreviewMessage): void {
    if (this.asked === null || answer.id !== this.asked.id) return; // of an earlier draft
    this.answered = this.asked.pose;
    this.asked = null;
    this.answer = answer;
    this.refusal = "";
    if (answer.q.length) this.q = answer.q;
    // An arm that has stretched after a pose out of reach shall come back with the elbow where it was.
    if (answer.q.length && answer.verdict !== "unreachable") this.start = answer.q;
    this.ask();
    this.onChange();
  }
  /** The server does not answer this question. */
  refused(id: number, text: string): void {
    if (this.asked === null || id !== this.asked.id) return;
    this.answered = this.asked.pose;
    this.asked = this.answer = null;
    this.refusal = text;
    this.onChange();
  }

  get arm(): string | null {
    return this.name;
  }
  /** The answer is about the newest pose. */
  get settled(): boolean {
    return this.pose !== null && this.pose === this.answered;
  }
  /** The arm could not be where the ghost is, or not at present. */
  get blocked(): boolean {
    return this.refusal !== "" || (this.answer !== null && !["free", "near"].includes(this.answer.verdict));
  }
  get near(): boolean {
    return this.answer?.verdict === "near";
  }
  get mayGo(): boolean {
    return this.settled && this.answer !== null && this.answer.accepted;
  }
  get order(): Order | null {
    return this.mayGo && this.name !== null ? { op: "goal", arm: this.name, q: [...this.q] } : null;
  }

  /** For people; empty: no draft. */
  get sentence(): string {
    if (this.name === null) return "";
    if (this.refusal !== "") return this.refusal;
    if (this.answer !== null) return this.answer.text || "The arm can be there.";
    return this.pose === null ? `Drag the gizmo at the tool of ${this.name}.` : "…";
  }
}
