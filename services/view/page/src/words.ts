/// Numbers and states in words, with widths that do not jump.
import type { ArmStatus, Fault, StatusMessage, Tool } from "./protocol";

/** The state of an arm for people. Each has its own colour and its own mark, so that neither is needed alone. */
export type ArmState = "moving" | "waiting" | "idle" | "held" | "stopped" | "fault" | "lost" | "stale" | "observed";

export const MARKS: Record<ArmState, string> = {
  moving: "●", waiting: "◆", idle: "○", held: "‖", stopped: "■", fault: "▲", lost: "✕", stale: "◌", observed: "◇",
};

const FAULT_DRIVES = new Set(["failed"]);
/** Ages above this count as stale [ms]. */
export const STALE_AGE = 500;

/** `age`: of its newest state [ms]. */
export function stateOf(arm: ArmStatus, age: number): ArmState {
  if (arm.lost) return "lost";
  if (!(age <= STALE_AGE)) return "stale";
  if (arm.drive !== null && FAULT_DRIVES.has(arm.drive)) return "fault";
  if (arm.drive === "observed") return "observed";
  if (arm.mode === "stop") return "stopped";
  if (arm.mode === "hold" || arm.mode === "unknown") return "held";
  if (arm.waiting === null) return "moving";
  return arm.waiting.kind === "no_goal" ? "idle" : "waiting";
}

/** One sentence: why the arm stands, or what it does. */
export function reasonOf(arm: ArmStatus): string {
  if (arm.waiting !== null) {
    const text = arm.waiting.text || arm.waiting.kind.replace(/_/g, " ");
    return arm.waiting.kind === "no_goal" ? `waits for ${text}` : text;
  }
  if (arm.goal !== null && !arm.goal.final) return arm.goal.action || `goes to goal ${arm.goal.id}`;
  return "moves";
}

export function ageText(milliseconds: number | null): string {
  if (milliseconds === null || !Number.isFinite(milliseconds)) return "never";
  if (milliseconds < 1000) return `${Math.round(milliseconds)} ms`;
  if (milliseconds < 60_000) return `${(milliseconds / 1000).toFixed(1)} s`;
  return `${Math.floor(milliseconds / 60_000)} min ${Math.floor((milliseconds % 60_000) / 1000)} s`;
}

export function durationText(seconds: number): string {
  return ageText(seconds * 1000);
}

export function distanceText(metres: number): string {
  return Math.abs(metres) < 1 ? `${Math.round(metres * 1000)} mm` : `${metres.toFixed(2)} m`;
}

export function clockText(unix: number): string {
  const date = new Date(unix);
  const two = (n: number): string => String(n).padStart(2, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
}

/** The gripper of an arm: "40 mm wide, holds crate". */
export function toolText(tool: Tool | null): string {
  if (tool === null) return "no gripper";
  const width = tool.width === null ? "width not known" : `${distanceText(tool.width)} wide`;
  return [width, tool.moving && "moves", tool.holding ? `holds ${tool.holding}` : "holds nothing"].filter(Boolean).join(", ");
}

/** A time since the begin of a recording [ms]: "1:02.345". */
export function offsetText(milliseconds: number): string {
  const all = Math.max(0, Math.round(milliseconds));
  const two = (n: number): string => String(n).padStart(2, "0");
  const minutes = Math.floor(all / 60_000);
  const hours = minutes >= 60 ? `${Math.floor(minutes / 60)}:` : "";
  const clock = `${hours ? two(minutes % 60) : minutes}:${two(Math.floor(all / 1000) % 60)}`;
  return `${hours}${clock}.${String(all % 1000).padStart(3, "0")}`;
}

/** The share of `part` in `whole`, within 0 and 1. */
export function shareOf(part: number, whole: number): number {
  return whole > 0 ? Math.min(1, Math.max(0, part / whole)) : 0;
}

export const isOpen = (fault: Fault): boolean => fault.duration === null;

/** "RUN", or what holds the cell; a lower speed: "RUN 30 %". */
export function modeText(status: Pick<StatusMessage, "mode" | "mode_age" | "speed_override">): string {
  if (status.mode === null) return "NO SUPERVISOR";
  const order = [status.mode.toUpperCase(), overrideText(status.speed_override ?? 1)].filter(Boolean).join(" ");
  return isSupervised(status) ? order : `NO SUPERVISOR FOR ${ageText(status.mode_age)}, LAST ${order}`;
}

/** A supervisor sends the mode every few milliseconds; one of its standbys takes over within a second. */
export function isSupervised(status: Pick<StatusMessage, "mode" | "mode_age">): boolean {
  return status.mode !== null && status.mode_age !== null && status.mode_age < 1000;
}

/** "30 %"; empty at full speed. */
export function overrideText(share: number): string {
  return share < 1 ? `${Math.round(share * 1e4) / 100} %` : "";
}

/** Every word of `query` is part of one of the texts; case does not matter. */
export function matches(query: string, ...texts: string[]): boolean {
  const all = texts.join(" ").toLowerCase();
  return query.toLowerCase().split(/\s+/).every((word) => all.includes(word));
}
