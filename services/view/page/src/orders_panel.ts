/// Buttons for orders, and the list of their outcomes.
import type { Entry, OrderBook } from "./orders";
import type { CellMessage, Order, StatusMessage } from "./protocol";

/** Sizes of an obstacle that the page adds [m], as the cell file has them. */
const ADDED: { kind: "box" | "sphere" | "cylinder"; size: number[]; text: string; half: number }[] = [
  { kind: "box", size: [0.2, 0.2, 0.2], text: "box 0.2 × 0.2 × 0.2 m", half: 0.1 },
  { kind: "sphere", size: [0.1], text: "sphere, radius 0.1 m", half: 0.1 },
  { kind: "cylinder", size: [0.05, 0.6], text: "cylinder, radius 0.05, height 0.6 m", half: 0.3 },
];

const MARKS: Record<Entry["state"], string> = { waiting: "…", done: "✓", failed: "✕" };

export class OrdersPanel {
  private cell: CellMessage | null = null;
  private status: StatusMessage | null = null;
  private arm: string | null = null;
  private readonly who = document.createElement("span");
  private readonly change = document.createElement("button");
  private readonly controls = document.createElement("div");
  private readonly forArm = document.createElement("div");
  private readonly armName = document.createElement("strong");
  private readonly pose = document.createElement("select");
  private readonly cancel: HTMLButtonElement;
  /** Where a new obstacle appears [m]. */
  placeForObstacle: () => [number, number, number] = () => [0, 0, 0];
  onRotate: () => void = () => {};
  private readonly turn: HTMLButtonElement;
  /** Begins or ends the drag of a goal of the selected arm. */
  onDrag: () => void = () => {};
  private readonly drag: HTMLButtonElement;
  private obstacle: string | null = null;
  private readonly forObstacle = document.createElement("div");
  private readonly obstacleName = document.createElement("strong");
  private readonly log = document.createElement("ul");

  constructor(private readonly host: HTMLElement, private readonly stop: HTMLButtonElement,
              private readonly book: OrderBook) {
    stop.onclick = () => book.stop();
    const head = this.row(host);
    this.change.onclick = () => (book.controls ? book.give({ op: "release" }, "release control") : book.take());
    this.change.id = "takecontrol";
    head.append(this.who, this.change);
    this.controls.id = "controls";
    host.append(this.controls);
    const cellRow = this.row(this.controls);
    const name = document.createElement("strong");
    name.textContent = "cell";
    cellRow.append(name);
    this.button(cellRow, "Hold", () => book.give({ op: "hold" }, "hold the cell"));
    this.button(cellRow, "Resume", () => book.give({ op: "resume" }, "resume the cell"));
    const save = this.button(cellRow, "Save recording", () => book.give({ op: "save" }, "save recordings"));
    save.title = "The recorders of the cell save the last minutes that they keep, and the next one.";
    save.id = "saverecordings";
    this.controls.append(this.forArm);
    const armRow = this.row(this.forArm);
    armRow.append(this.armName);
    this.button(armRow, "Hold", () => this.give("hold"));
    this.button(armRow, "Resume", () => this.give("resume"));
    this.button(armRow, "Stop", () => this.give("stop")).className = "warn";
    const goalRow = this.row(this.forArm);
    const label = document.createElement("label");
    label.textContent = "goal";
    label.htmlFor = this.pose.id = "pose";
    goalRow.append(label, this.pose);
    this.button(goalRow, "Go", () => {
      if (this.arm === null) return;
      book.give({ op: "goal", arm: this.arm, named: this.pose.value }, `${this.arm} to ${this.pose.value}`);
    });
    this.drag = this.button(goalRow, "Drag a goal", () => this.onDrag());
    this.drag.title = "Shows a ghost of the arm with a gizmo at its tool (D). Nothing moves before the order.";
    this.drag.id = "draggoal";
    this.cancel = this.button(goalRow, "Cancel goal", () => {
      const goal = this.goal();
      if (this.arm !== null && goal) book.give({ op: "cancel", arm: this.arm, goal }, `cancel the goal of ${this.arm}`);
    });
    this.turn = this.addObstacleRows();
    const note = document.createElement("p");
    note.className = "dim";
    note.textContent = "Hold and stop are orders over the network, not safety functions. In danger press the emergency stop of the robot.";
    this.log.id = "orderlog";
    this.log.setAttribute("role", "log");
    host.append(note, this.log);
    this.show();
  }

  setCell(cell: CellMessage): void {
    this.cell = cell;
    this.show();
  }
  select(arm: string | null): void {
    this.arm = arm;
    const poses = this.cell?.arms.find((candidate) => candidate.name === arm)?.poses ?? [];
    this.pose.replaceChildren(...poses.map((pose) => new Option(pose, pose)));
    this.show();
  }
  setStatus(status: StatusMessage): void {
    this.status = status;
    this.cancel.disabled = this.goal() === null;
  }

  chooseObstacle(name: string | null): void {
    this.obstacle = name;
    this.show();
  }

  /** Returns the button that rotates the gizmo. */
  private addObstacleRows(): HTMLButtonElement {
    const chosen = this.row(this.forObstacle);
    chosen.append(this.obstacleName);
    const turn = this.button(chosen, "Rotate", () => this.onRotate());
    this.button(chosen, "Remove", () => {
      if (this.obstacle !== null) this.book.give({ op: "obstacle_remove", name: this.obstacle }, `remove ${this.obstacle}`);
    }).className = "warn";
    this.controls.append(this.forObstacle);
    const added = this.row(this.controls);
    const shape = document.createElement("select");
    shape.id = "newshape";
    shape.setAttribute("aria-label", "Shape of a new obstacle");
    shape.append(...ADDED.map((one, i) => new Option(one.text, String(i))));
    const name = document.createElement("input");
    name.id = "newname";
    name.placeholder = "obstacle's name";
    name.setAttribute("aria-label", "Name of a new obstacle");
    added.append(shape, name);
    this.button(added, "Add", () => {
      const { kind, size, half } = ADDED[Number(shape.value)];
      const [x, y] = this.placeForObstacle();
      // On the floor, a finger above it.
      const z = (this.cell?.floor ?? 0) + half + 0.01;
      const order: Order = { op: "obstacle_add", name: name.value.trim(), shape: { kind, size }, pose: [x, y, z, 0, 0, 0, 1] };
      this.book.give(order, `add ${name.value.trim()}`);
    });
    return turn;
  }

  setRotation(rotates: boolean): void {
    this.turn.setAttribute("aria-pressed", String(rotates));
  }
  /** A goal is dragged. */
  setDrag(drags: boolean): void {
    this.drag.setAttribute("aria-pressed", String(drags));
  }

  /** The selected arm's present goal. */
  private goal(): string | null {
    const goal = this.status?.arms.find((candidate) => candidate.name === this.arm)?.goal;
    return goal && !goal.final ? goal.id : null;
  }

  private give(op: "hold" | "resume" | "stop"): void {
    if (this.arm !== null) this.book.give({ op, arms: [this.arm] }, `${op} ${this.arm}`);
  }

  show(): void {
    const { book } = this;
    this.host.hidden = !book.known || book.silent;
    this.stop.hidden = !book.offersStop;
    this.who.textContent = book.sentence;
    this.change.hidden = !book.controls && !book.mayTake;
    this.change.textContent = book.controls ? "Release control" : "Take control";
    this.controls.hidden = !book.controls;
    this.forArm.hidden = this.arm === null;
    this.armName.textContent = this.arm;
    this.forObstacle.hidden = this.obstacle === null;
    this.obstacleName.textContent = this.obstacle;
    this.cancel.disabled = this.goal() === null;
    this.log.replaceChildren(...book.entries.slice(0, 8).map((entry) => {
      const row = document.createElement("li");
      const mark = document.createElement("span");
      mark.textContent = MARKS[entry.state];
      const text = document.createElement("span");
      text.textContent = entry.text;
      mark.dataset.state = text.dataset.state = entry.state;
      if (entry.state !== "failed") delete text.dataset.state;
      row.append(mark, text);
      return row;
    }));
  }

  private row(host: HTMLElement): HTMLElement {
    const row = document.createElement("div");
    row.className = "row";
    host.append(row);
    return row;
  }
  private button(host: HTMLElement, text: string, press: () => void): HTMLButtonElement {
    const made = document.createElement("button");
    made.textContent = text;
    made.onclick = press;
    host.append(made);
    return made;
  }
}
