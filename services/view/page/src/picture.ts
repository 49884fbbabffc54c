/// Pictures and films of the scene, for `hecaton render`. It opens the page in a browser without a window, with what it
/// wants in the query of the address, and gets the file in pieces over a WebSocket of its own.
import { BufferTarget, CanvasSource, Output, QUALITY_HIGH, WebMOutputFormat } from "mediabunny";
import type { Connection } from "./connection";
import { type FilmRequest, type PictureRequest, type Request, requestIn, timesOf, trailOf } from "./picture_request";
import type { Message } from "./protocol";
import type { CellScene, Preset, Toggles } from "./scene";

const PIECE = 1 << 20; // of the file [byte]; the program takes no longer message

export interface Shown {
  scene: CellScene;
  connection: Connection;
  /** Applies what the request says of the appearance. */
  show(toggles: Partial<Toggles>, preset: Preset, dark: boolean): void;
}

/** The state that the page has received. */
class Arrivals {
  private waiting: (() => void)[] = [];
  private at: number | null = null; // of the recording; null: unknown, or no recording
  private sought: number | null = null;
  private framed = false; // a frame has arrived since the time that is sought was there

  constructor(private readonly connection: Connection) {
    const former = connection.onMessage;
    connection.onMessage = (message, now) => {
      former(message, now);
      this.note(message);
    };
  }

  /** The page shows that time of the recording; null: the newest state of a cell that stands. */
  async frameAt(at: number | null): Promise<void> {
    this.sought = at;
    this.framed = false;
    if (at !== null) this.connection.send({ op: "seek", at });
    await new Promise<void>((resolve) => this.waiting.push(resolve));
  }

  private note(message: Message): void {
    if (message.type === "playback") this.at = message.at;
    if (message.type !== "frame") return;
    const there = this.sought === null || (this.at !== null && Math.abs(this.at - this.sought) < 1);
    if (!there) return;
    // The first frame may have been under way before the time was there.
    if (this.framed) this.waiting.splice(0).forEach((resolve) => resolve());
    this.framed = true;
  }
}

export async function takePicture({ scene, connection, show }: Shown): Promise<void> {
  const query = new URLSearchParams(location.search);
  const socket = new WebSocket(`ws://${location.host}/?token=${query.get("token") ?? ""}`, "hecaton.picture");
  await new Promise((resolve, reject) => {
    socket.onopen = resolve;
    socket.onerror = () => reject(new Error("the program takes no picture"));
  });
  try {
    const arrivals = new Arrivals(connection);
    await arrivals.frameAt(null);
    const request = requestIn(query);
    show(request.toggles, request.view, request.dark);
    scene.beginPictures();
    await scene.loading;
    scene.look(request.view);
    await visitTrail(request, scene, arrivals);
    const file = request.kind === "png" ? await picture(request, scene, arrivals) : await film(request, scene, arrivals, socket);
    for (let from = 0; from < file.byteLength; from += PIECE) socket.send(file.slice(from, from + PIECE));
    socket.send(JSON.stringify({ done: file.byteLength }));
  } catch (error) {
    socket.send(JSON.stringify({ failed: error instanceof Error ? error.message : String(error) }));
  }
}

/** The way of the tools before the first time. */
async function visitTrail(request: Request, scene: CellScene, arrivals: Arrivals): Promise<void> {
  if (!request.toggles.trails) return;
  for (const at of trailOf(request)) {
    await arrivals.frameAt(at);
    scene.drawPicture();
  }
}

async function picture(request: PictureRequest, scene: CellScene, arrivals: Arrivals): Promise<ArrayBuffer> {
  await arrivals.frameAt(request.at);
  scene.drawPicture(); // moves the bodies to their places
  scene.frame(request.view);
  const canvas = scene.drawPicture();
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
  if (blob === null) throw new Error("the browser makes no PNG of this size");
  return blob.arrayBuffer();
}

async function film(request: FilmRequest, scene: CellScene, arrivals: Arrivals, socket: WebSocket): Promise<ArrayBuffer> {
  const times = timesOf(request);
  const target = new BufferTarget();
  const output = new Output({ format: new WebMOutputFormat(), target });
  const source = new CanvasSource(scene.drawPicture(), { codec: "vp9", bitrate: QUALITY_HIGH });
  output.addVideoTrack(source, { frameRate: request.fps });
  await output.start();
  for (let i = 0; i < times.length; ++i) {
    await arrivals.frameAt(times[i]);
    scene.drawPicture();
    await source.add(i / request.fps, 1 / request.fps);
    socket.send(JSON.stringify({ frame: i + 1, of: times.length }));
  }
  await output.finalize();
  if (target.buffer === null) throw new Error("the browser has encoded nothing");
  return target.buffer;
}
