/// What `hecaton render` wants, from the query of the address. The program has checked all values.
import type { Preset, Toggles } from "./scene";

interface Appearance {
  toggles: Toggles;
  view: Preset;
  dark: boolean;
}
export interface PictureRequest extends Appearance {
  kind: "png";
  at: number | null; // since the begin of the recording [ms]; null: the cell stands
}
export interface FilmRequest extends Appearance {
  kind: "webm";
  from: number; // [ms]
  until: number; // [ms]
  fps: number;
  speed: number; // of the recording in the film
}
export type Request = PictureRequest | FilmRequest;

const LAYERS: (keyof Toggles)[] = ["goals", "ways", "halos", "planning", "binding", "names", "trails"];
const TRAIL = 2000; // before the first time [ms]
const TRAIL_STEP = 50; // [ms]

export function requestIn(query: URLSearchParams): Request {
  const wanted = new Set((query.get("layers") ?? "").split(","));
  const toggles = Object.fromEntries(LAYERS.map((layer) => [layer, wanted.has(layer)])) as unknown as Toggles;
  const appearance = { toggles, view: (query.get("view") ?? "free") as Preset, dark: query.get("theme") === "dark" };
  const at = query.get("at");
  if (query.get("picture") !== "webm") return { ...appearance, kind: "png", at: at === null ? null : Number(at) };
  return { ...appearance, kind: "webm", from: Number(at), until: Number(query.get("until")), fps: Number(query.get("fps")),
           speed: Number(query.get("speed")) };
}

/** The times of the recording that the frames of a film show [ms]. */
export function timesOf({ from, until, fps, speed }: FilmRequest): number[] {
  const step = (1000 * speed) / fps;
  const frames = Math.max(1, Math.floor((until - from) / step + 1e-6) + 1);
  return Array.from({ length: frames }, (_, i) => from + i * step);
}

/** Times before the first one, from which the way of a tool is drawn [ms]. */
export function trailOf(request: Request): number[] {
  const begin = request.kind === "webm" ? request.from : request.at;
  if (begin === null) return [];
  const first = Math.max(0, begin - TRAIL);
  return Array.from({ length: Math.floor((begin - first) / TRAIL_STEP) }, (_, i) => first + i * TRAIL_STEP);
}
