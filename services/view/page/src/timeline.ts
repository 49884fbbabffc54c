/// The time line of a recording: what happened in it, and the controls that choose the time.
import type { Command, Mark, PlaybackMessage, RecordingMessage } from "./protocol";
import { clockText, offsetText, shareOf } from "./words";

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10];
const LANES: [Mark["kind"], string][] = [["mode", "modes"], ["goal", "goals"], ["fault", "faults"]];
/** A seek that no message has answered for so long is lost [ms]. */
const PATIENCE = 500;

function element<K extends keyof HTMLElementTagNameMap>(tag: K, parent: HTMLElement, className = ""): HTMLElementTagNameMap[K] {
  const child = document.createElement(tag);
  if (className) child.className = className;
  parent.append(child);
  return child;
}

export class Timeline {
  onCommand: (command: Command) => void = () => {};
  /** The arm whose ticks steps go through; null: any arm. */
  arm: () => string | null = () => null;
  private recording: RecordingMessage | null = null;
  private playback: PlaybackMessage = { type: "playback", at: 0, plays: false, speed: 1 };
  private readonly play: HTMLButtonElement;
  private readonly speed: HTMLSelectElement;
  private readonly time: HTMLElement;
  private readonly track: HTMLElement;
  private readonly lanes = new Map<Mark["kind"], HTMLElement>();
  private readonly cursor: HTMLElement;
  private readonly notes: HTMLElement;
  private dragged: number | null = null; // where the pointer is [ms]
  private wanted: number | null = null; // the next seek, while one is under way
  private asked = Number.NEGATIVE_INFINITY; // when the seek under way was sent

  constructor(private readonly host: HTMLElement) {
    const controls = element("div", host, "controls");
    controls.setAttribute("role", "toolbar");
    controls.setAttribute("aria-label", "Playback");
    const button = (text: string, title: string, press: () => void): HTMLButtonElement => {
      const made = element("button", controls);
      made.textContent = text;
      made.title = title;
      made.setAttribute("aria-label", title);
      made.onclick = press;
      return made;
    };
    button("◂❙", "One tick back (,)", () => this.step(-1));
    this.play = button("▶", "Play or pause (Space)", () => this.toggle());
    button("❙▸", "One tick on (.)", () => this.step(1));
    this.speed = element("select", controls);
    this.speed.title = "Speed ([ and ])";
    this.speed.setAttribute("aria-label", "Speed");
    for (const value of SPEEDS) this.speed.add(new Option(`${value}×`, String(value), value === 1, value === 1));
    this.speed.onchange = () => this.onCommand({ op: "speed", value: Number(this.speed.value) });
    this.time = element("span", controls, "number");

    this.track = element("div", host, "track");
    this.track.tabIndex = 0;
    this.track.setAttribute("role", "slider");
    this.track.setAttribute("aria-label", "Time of the recording");
    this.track.setAttribute("aria-valuemin", "0");
    for (const [kind, name] of LANES) {
      const lane = element("div", this.track, "lane");
      lane.dataset.name = name;
      this.lanes.set(kind, lane);
    }
    this.cursor = element("i", this.track, "cursor");
    this.notes = element("p", host, "notes");
    this.listen();
  }

  get active(): boolean {
    return this.recording !== null;
  }

  setRecording(recording: RecordingMessage): void {
    this.recording = recording;
    this.host.hidden = false;
    this.track.setAttribute("aria-valuemax", (recording.length / 1000).toFixed(3));
    for (const lane of this.lanes.values()) lane.replaceChildren();
    for (const mark of recording.marks) this.draw(mark, recording);
    this.notes.hidden = recording.notes.length === 0;
    this.notes.textContent = recording.notes.length ? `▲ ${recording.notes[0]}` +
      (recording.notes.length > 1 ? ` (and ${recording.notes.length - 1} more)` : "") : "";
    this.notes.title = recording.notes.join("\n");
    this.show();
  }

  setPlayback(playback: PlaybackMessage): void {
    this.playback = playback;
    this.asked = Number.NEGATIVE_INFINITY;
    if (this.wanted !== null) this.seek(this.wanted);
    this.show();
  }

  toggle(): void {
    this.onCommand({ op: this.playback.plays ? "pause" : "play" });
  }
  step(by: -1 | 1): void {
    this.onCommand({ op: "step", by, arm: this.arm() ?? "" });
  }
  /** The next faster (1) or slower (−1) speed. */
  faster(by: -1 | 1): void {
    const nearest = SPEEDS.reduce((best, speed, i) =>
      Math.abs(speed - this.playback.speed) < Math.abs(SPEEDS[best] - this.playback.speed) ? i : best, 0);
    const value = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, nearest + by))];
    this.onCommand({ op: "speed", value });
  }
  /** To a time since the begin of the recording [ms]. One seek is under way at a time; the last of several counts. */
  seek(at: number): void {
    if (performance.now() - this.asked < PATIENCE) {
      this.wanted = at;
      return;
    }
    this.wanted = null;
    this.asked = performance.now();
    this.onCommand({ op: "seek", at });
  }

  private draw(mark: Mark, { length, begin }: RecordingMessage): void {
    const lane = this.lanes.get(mark.kind);
    if (!lane) return;
    const span = element("span", lane);
    span.style.left = `${shareOf(mark.at, length) * 100}%`;
    if (mark.kind === "fault") {
      span.dataset.severity = mark.severity;
      span.style.width = `${(shareOf(mark.until ?? length, length) - shareOf(mark.at, length)) * 100}%`;
    }
    if (mark.kind === "mode") span.dataset.mode = mark.text.split(":")[0];
    if (mark.kind === "goal") span.dataset.begun = String(mark.text.endsWith(" begun"));
    span.title = `${offsetText(mark.at)}, ${clockText(begin + mark.at)}: ` +
      `${mark.subject && mark.kind !== "fault" ? `${mark.subject}: ` : ""}${mark.text}`;
  }

  private show(): void {
    if (!this.recording) return;
    const { length, files } = this.recording;
    const at = this.dragged ?? this.playback.at;
    this.play.textContent = this.playback.plays ? "❚❚" : "▶";
    this.speed.value = String(SPEEDS.find((speed) => Math.abs(speed - this.playback.speed) < 1e-6) ?? 1);
    this.time.textContent = `${offsetText(at)} / ${offsetText(length)}`;
    this.time.title = files.join(", ");
    this.cursor.style.left = `${shareOf(at, length) * 100}%`;
    this.track.setAttribute("aria-valuenow", (at / 1000).toFixed(6));
    this.track.setAttribute("aria-valuetext", offsetText(at));
  }

  private listen(): void {
    const follow = (event: PointerEvent): void => {
      if (!this.recording) return;
      const { left, width } = this.track.getBoundingClientRect();
      this.dragged = shareOf(event.clientX - left, width) * this.recording.length;
      this.seek(this.dragged);
      this.show();
    };
    this.track.addEventListener("pointerdown", (event) => {
      this.track.setPointerCapture(event.pointerId);
      follow(event);
    });
    this.track.addEventListener("pointermove", (event) => {
      if (this.dragged !== null) follow(event);
    });
    for (const end of ["pointerup", "pointercancel"] as const) {
      this.track.addEventListener(end, () => {
        this.dragged = null;
      });
    }
    this.track.addEventListener("keydown", (event) => {
      if (!this.recording) return;
      const steps: Record<string, number> = {
        ArrowLeft: this.playback.at - 1000, ArrowRight: this.playback.at + 1000,
        PageUp: this.playback.at - 10_000, PageDown: this.playback.at + 10_000, Home: 0, End: this.recording.length,
      };
      const at = steps[event.key];
      if (at === undefined) return;
      this.seek(Math.min(this.recording.length, Math.max(0, at)));
      event.preventDefault();
      event.stopPropagation(); // the arrow keys of the page move the section
    });
  }
}
