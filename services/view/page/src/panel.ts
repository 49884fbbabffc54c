/// The panels beside the scene. They write a text only when it changes, so that a cell of 30 arms costs little.
import type { Arm, ArmStatus, CellMessage, Fault, ObstaclesMessage, StatusMessage } from "./protocol";
import {
  ageText, clockText, distanceText, durationText, isOpen, isSupervised, MARKS, matches, modeText, overrideText, reasonOf, stateOf,
  toolText, type ArmState,
} from "./words";

export function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element ${id}`);
  return element;
}

function setText(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

function element(tag: string, parent: HTMLElement, className = ""): HTMLElement {
  const child = document.createElement(tag);
  if (className) child.className = className;
  parent.append(child);
  return child;
}

/** A list with one row for each name, which stay while the names stay. */
class Rows<T extends Record<string, HTMLElement>> {
  private readonly rows = new Map<string, { row: HTMLElement; parts: T }>();
  constructor(private readonly list: HTMLElement, private readonly make: (row: HTMLElement, name: string) => T) {}

  get(name: string): { row: HTMLElement; parts: T } {
    let entry = this.rows.get(name);
    if (!entry) {
      const row = element("li", this.list);
      entry = { row, parts: this.make(row, name) };
      this.rows.set(name, entry);
    }
    return entry;
  }
  find(name: string): HTMLElement | null {
    return this.rows.get(name)?.row ?? null;
  }
  /** Removes the rows of other names. */
  keep(names: ReadonlySet<string>): void {
    for (const [name, { row }] of this.rows) {
      if (names.has(name)) continue;
      row.remove();
      this.rows.delete(name);
    }
  }
  clear(): void {
    this.keep(new Set());
  }
}

type Ages = (arm: string) => number;

export class Panel {
  onSelect: (arm: string | null) => void = () => {};
  onObstacle: (obstacle: string) => void = () => {};
  private cell: CellMessage | null = null;
  private query = "";
  private selected: string | null = null;
  private readonly arms: Rows<{ mark: HTMLElement; name: HTMLElement; age: HTMLElement; why: HTMLElement }>;
  private readonly nodes: Rows<{ mark: HTMLElement; name: HTMLElement; value: HTMLElement }>;
  private readonly obstacles: Rows<{ name: HTMLElement; value: HTMLElement }>;
  private faultKey = "";
  private obstacle: string | null = null; // the chosen one

  constructor() {
    this.arms = new Rows(byId("arms"), (row, name) => {
      row.setAttribute("role", "option");
      row.id = `arm-${name}`;
      row.onclick = () => this.onSelect(name);
      const parts = {
        mark: element("span", row), name: element("span", row, "name"),
        age: element("span", row, "number dim"), why: element("span", row, "why"),
      };
      parts.name.textContent = name;
      return parts;
    });
    this.nodes = new Rows(byId("nodes"), (row) => ({
      mark: element("span", row), name: element("span", row, "name"), value: element("span", row, "number dim"),
    }));
    this.obstacles = new Rows(byId("obstacles"), (row, name) => {
      row.setAttribute("role", "option");
      row.tabIndex = -1;
      row.onclick = () => this.onObstacle(name);
      row.onkeydown = (event) => this.pressInObstacles(event, row, name);
      return { name: element("span", row, "name"), value: element("span", row, "dim") };
    });
  }

  setCell(cell: CellMessage): void {
    this.cell = cell;
    this.arms.clear();
    setText(byId("cell"), cell.name);
    byId("cell").title = cell.name;
    document.title = `${cell.name} – Hecaton`;
  }

  setQuery(query: string): void {
    this.query = query;
  }
  select(arm: string | null): void {
    this.selected = arm;
    byId("arms").setAttribute("aria-activedescendant", arm === null ? "" : `arm-${arm}`);
    if (arm !== null) document.getElementById(`arm-${arm}`)?.scrollIntoView({ block: "nearest" });
  }

  /** Arms that the search shows, in the order of the cell. */
  visibleArms(status: StatusMessage | null, age: Ages): string[] {
    if (!this.cell) return [];
    return this.cell.arms.map((arm) => arm.name).filter((name) => {
      const arm = status?.arms.find((candidate) => candidate.name === name);
      return matches(this.query, name, arm ? reasonOf(arm) : "", arm ? `is:${stateOf(arm, age(name))}` : "");
    });
  }

  setObstacles(message: ObstaclesMessage): void {
    setText(byId("obstaclecount"), String(message.obstacles.length));
    const shown = new Set<string>();
    for (const obstacle of message.obstacles) {
      if (!matches(this.query, obstacle.name, obstacle.motion, obstacle.attached_to)) continue;
      shown.add(obstacle.name);
      const { row, parts } = this.obstacles.get(obstacle.name);
      row.setAttribute("aria-selected", String(obstacle.name === this.obstacle));
      setText(parts.name, obstacle.name);
      setText(parts.value, obstacle.attached_to ? `carried by ${obstacle.attached_to}` : obstacle.motion);
    }
    this.obstacles.keep(shown);
    const list = byId("obstacles");
    if (!list.querySelector('[tabindex="0"]')) list.querySelector("li")?.setAttribute("tabindex", "0");
  }
  /** The one that a page moves or removes; null: none. */
  chooseObstacle(name: string | null): void {
    if (name === this.obstacle) return;
    for (const [chosen, is] of [[this.obstacle, "false"], [name, "true"]] as const) {
      if (chosen !== null) this.obstacles.find(chosen)?.setAttribute("aria-selected", is);
    }
    this.obstacle = name;
  }
  /** The list is one stop of the Tab key, however many rows it has; the arrow keys go from row to row. */
  private pressInObstacles(event: KeyboardEvent, row: HTMLElement, name: string): void {
    const { key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (key === "Enter" || key === " ") {
      if (!event.repeat) this.onObstacle(name);
    } else if (key === "ArrowDown" || key === "ArrowUp") {
      const next = key === "ArrowDown" ? row.nextElementSibling : row.previousElementSibling;
      if (next instanceof HTMLElement) {
        row.tabIndex = -1;
        next.tabIndex = 0;
        next.focus();
      }
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation(); // these keys of the page are for arms, goals and recordings
  }

  setStatus(status: StatusMessage, age: Ages): void {
    this.showHeader(status);
    this.showArms(status, age);
    this.showNodes(status);
    this.showFaults(status);
    this.showDetail(status, age);
  }

  private showHeader(status: StatusMessage): void {
    const mode = byId("mode");
    setText(mode, modeText(status));
    mode.title = modeText(status); // a narrow window cuts it
    mode.dataset.mode = isSupervised(status) ? status.mode ?? "none" : "none";
    setText(byId("cause"), status.cause?.text ?? "");
    const open = status.faults.filter(isOpen).length;
    setText(byId("faultcount"), `${open} open fault${open === 1 ? "" : "s"}`);
    byId("faultcount").dataset.state = open ? "fault" : "idle";
    const contacts = status.contacts?.count ?? 0;
    setText(byId("contacts"), status.contacts === null ? "" : `${contacts} contact${contacts === 1 ? "" : "s"}`);
    byId("contacts").dataset.state = contacts ? "fault" : "idle";
    byId("contacts").title = status.contacts?.smallest
      ? `smallest separation so far: ${distanceText(status.contacts.smallest.distance)}, ` +
        `${status.contacts.smallest.a} – ${status.contacts.smallest.b}` : "";
    setText(byId("clock"), clockText(status.wall));
  }

  private showArms(status: StatusMessage, age: Ages): void {
    const visible = new Set(this.visibleArms(status, age));
    this.arms.keep(visible);
    setText(byId("armcount"), visible.size === status.arms.length ? String(visible.size)
                                                                  : `${visible.size} of ${status.arms.length}`);
    for (const arm of status.arms) {
      if (!visible.has(arm.name)) continue;
      const { row, parts } = this.arms.get(arm.name);
      const state = stateOf(arm, age(arm.name));
      setText(parts.mark, MARKS[state]);
      parts.mark.dataset.state = state;
      parts.mark.title = state;
      setText(parts.age, [state === "stale" ? ageText(age(arm.name)) : state, overrideText(arm.speed_override)]
        .filter(Boolean).join(" "));
      setText(parts.why, sentence(arm, state, age(arm.name)));
      row.setAttribute("aria-selected", String(arm.name === this.selected));
    }
  }

  private showNodes(status: StatusMessage): void {
    const shown = new Set<string>();
    for (const node of status.nodes) {
      if (!matches(this.query, node.name, node.host, node.state)) continue;
      shown.add(node.name);
      const { row, parts } = this.nodes.get(node.name);
      const bad = !node.alive || node.state === "failed";
      const state: ArmState = bad ? "fault" : node.state === "degraded" ? "waiting"
                            : node.state === "standby" ? "idle" : "moving";
      setText(parts.mark, MARKS[state]);
      parts.mark.dataset.state = state;
      setText(parts.name, node.name);
      setText(parts.value, node.alive ? node.state === "running" ? `${Math.round(node.tick[1])} µs` : node.state
                                      : `silent ${ageText(node.age)}`);
      row.title = `${node.state} on ${node.host}, process ${node.pid}, ${Math.round(node.memory / 1e6)} MB` +
        (node.cause ? `: ${node.cause.text}` : "");
    }
    this.nodes.keep(shown);
    const alive = status.nodes.filter((node) => node.alive).length;
    setText(byId("nodecount"), `${alive} of ${status.nodes.length} alive`);
  }

  private showFaults(status: StatusMessage): void {
    const SPAN = 600_000;
    const timeline = byId("timeline");
    const from = status.wall - SPAN;
    const key = JSON.stringify(status.faults) + Math.floor(status.wall / 1000);
    if (key === this.faultKey) return;
    this.faultKey = key;
    timeline.replaceChildren();
    const list = byId("faultlist");
    list.replaceChildren();
    for (const fault of status.faults) {
      const end = isOpen(fault) ? status.wall : fault.since + (fault.duration ?? 0) * 1000;
      if (end > from) {
        const bar = element("span", timeline, isOpen(fault) ? "open" : "");
        bar.dataset.severity = fault.severity;
        bar.style.left = `${(Math.max(0, fault.since - from) / SPAN) * 100}%`;
        bar.style.width = `${((end - Math.max(from, fault.since)) / SPAN) * 100}%`;
        bar.title = faultText(fault);
      }
      const row = element("li", list, isOpen(fault) ? "open" : "");
      element("span", row, "number").textContent = clockText(fault.since);
      const mark = element("span", row);
      mark.textContent = isOpen(fault) ? MARKS.fault : MARKS.idle;
      mark.dataset.state = isOpen(fault) ? "fault" : "idle";
      element("span", row).textContent = fault.text;
      element("span", row, "number dim").textContent = isOpen(fault) ? "open" : durationText(fault.duration ?? 0);
    }
    if (!status.faults.length) element("li", list, "dim").textContent = "none since the cell came up";
  }

  private showDetail(status: StatusMessage, age: Ages): void {
    const right = byId("right");
    const description = this.cell?.arms.find((arm) => arm.name === this.selected);
    const arm = status.arms.find((candidate) => candidate.name === this.selected);
    if (!arm || !description) {
      right.dataset.arm = "";
      if (!right.querySelector(".hint")) {
        right.replaceChildren();
        element("p", right, "dim hint").textContent =
          "Select an arm in the list or in the scene: its goal, what binds its motion, and its joints are here.";
      }
      return;
    }
    const milliseconds = age(arm.name);
    const state = stateOf(arm, milliseconds);
    if (right.dataset.arm !== arm.name) this.layOutDetail(right, description);
    right.dataset.arm = arm.name;
    const set = (name: string, text: string): void => {
      const field = right.querySelector<HTMLElement>(`[data-field="${name}"]`);
      if (field) setText(field, text);
    };
    set("state", `${MARKS[state]} ${state}`);
    right.querySelector<HTMLElement>('[data-field="state"]')!.dataset.state = state;
    set("why", sentence(arm, state, milliseconds));
    const goal = arm.goal;
    set("goal", goal ? `${goal.id}: ${goal.state}, ${goal.distance.toFixed(2)} to go, ${goal.elapsed.toFixed(1)} s` : "none");
    set("binding", goal?.binding && !goal.final
      ? `${goal.binding.own} – ${goal.binding.other}, ${distanceText(goal.binding.distance)} ` +
        `(safe: ${distanceText(description.security_distance)})` : "no pair bounds the motion");
    set("note", [goal?.note, description.note].filter(Boolean).join("; ") || "–");
    set("age", ageText(milliseconds));
    set("command", arm.command_age === undefined ? "–" : durationText(arm.command_age));
    set("planner", arm.planner);
    set("carried", arm.carried || "nothing");
    set("gripper", toolText(arm.tool));
    set("speed", [arm.speed === undefined ? "–" : arm.speed.toFixed(2), arm.speed_override < 1 && `at most ${overrideText(arm.speed_override)}`].filter(Boolean).join(", "));
  }

  private layOutDetail(right: HTMLElement, arm: Arm): void {
    right.replaceChildren();
    const head = element("h2", right);
    head.textContent = `${arm.name} `;
    element("span", head, "dim").textContent = arm.robot;
    const list = element("dl", right);
    const fields = ["state", "why", "goal", "binding", "note", "age", "command", "planner", "carried", "gripper", "speed"];
    for (const name of fields) {
      element("dt", list).textContent = name;
      element("dd", list, "number").dataset.field = name;
    }
    const table = element("table", right);
    arm.joints.forEach((joint, i) => {
      const row = element("tr", table);
      element("td", row).textContent = joint;
      const value = element("td", row, "n");
      value.dataset.joint = String(i);
      const cell = element("td", row);
      const meter = document.createElement("meter");
      meter.min = arm.lower[i];
      meter.max = arm.upper[i];
      meter.dataset.joint = String(i);
      cell.append(meter);
    });
  }

  /** The joint positions of the selected arm, more often than the rest. */
  setJoints(q: readonly number[]): void {
    const right = byId("right");
    q.forEach((value, i) => {
      const text = right.querySelector<HTMLElement>(`td[data-joint="${i}"]`);
      const meter = right.querySelector<HTMLMeterElement>(`meter[data-joint="${i}"]`);
      if (text) setText(text, value.toFixed(3));
      if (meter) meter.value = value;
    });
  }
}

function sentence(arm: ArmStatus, state: ArmState, age: number): string {
  if (state === "stale") return Number.isFinite(age) ? `no state for ${ageText(age)}` : "no state was received yet";
  if (state === "lost") return "no supervisor hears it; the other arms keep away from where it may be";
  return reasonOf(arm);
}

function faultText(fault: Fault): string {
  return `${clockText(fault.since)} ${fault.text} (${isOpen(fault) ? "open" : durationText(fault.duration ?? 0)})`;
}
