/// The stream of the server. After a loss it connects again, at growing intervals up to two seconds.
import type { Message, Sent } from "./protocol";

export class Connection {
  onMessage: (message: Message, now: number) => void = () => {};
  onState: (connected: boolean) => void = () => {};
  private delay = 250;
  private socket: WebSocket | null = null;

  constructor(private readonly url: string) {}

  open(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.onopen = () => {
      this.delay = 250;
      this.onState(true);
    };
    socket.onmessage = (event) => this.onMessage(JSON.parse(String(event.data)) as Message, performance.now());
    socket.onclose = () => {
      this.onState(false);
      setTimeout(() => this.open(), this.delay);
      this.delay = Math.min(2000, this.delay * 2);
    };
  }

  /** Without a connection it sends nothing, also not later: false. */
  send(message: Sent): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
