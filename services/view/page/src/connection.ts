/// The stream of the server. After a loss it connects again, at growing intervals up to two seconds.
import type { Message, Sent } from "./protocol";

export class Connection {
  onMessage: (message: Message, now: number) => void = () => {};
  onState: (connected: boolean) => void = () => {};
  private delay = 250;
  private socket: WebSocket | null = null;
  private newest: number | null = null;
  private heard = Number.NEGATIVE_INFINITY; // local time of the newest message, or of the connection

  constructor(private readonly url: string) {}

  open(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.onopen = () => {
      this.delay = 250;
      this.newest = null; // of a server that may have been restarted
      this.heard = performance.now();
      this.onState(true);
    };
    socket.onmessage = (event) => {
      this.heard = performance.now();
      const message = JSON.parse(String(event.data)) as Message;
      if (message.type === "frame" || message.type === "status") this.newest = message.t;
      this.onMessage(message, this.heard);
    };
    socket.onclose = () => {
      this.onState(false);
      setTimeout(() => this.open(), this.delay);
      this.delay = Math.min(2000, this.delay * 2);
    };
  }

  /** Time since the server was heard [ms]. It sends 30 messages a second: a cut cable shows here minutes before the end. */
  get silence(): number {
    return performance.now() - this.heard;
  }

  /** Time of the newest state of this connection, on the server's clock [ms]; null: none yet. */
  get seen(): number | null {
    return this.newest;
  }

  /** Without a connection it sends nothing, also not later: false. */
  send(message: Sent): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
