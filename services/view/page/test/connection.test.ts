import assert from "node:assert/strict";
import { test } from "node:test";
import { Connection } from "../src/connection";

/** A socket without network. */
class Socket {
  static readonly OPEN = 1;
  static newest: Socket;
  readyState = Socket.OPEN;
  onopen = (): void => {};
  onmessage = (_: { data: string }): void => {};
  onclose = (): void => {};
  constructor() {
    Socket.newest = this;
  }
  receive(message: object): void {
    this.onmessage({ data: JSON.stringify(message) });
  }
}

test("the newest state of the connection is that of its newest frame or status", () => {
  Object.assign(globalThis, { WebSocket: Socket });
  const connection = new Connection("");
  connection.open();
  const first = Socket.newest;
  first.onopen();
  first.receive({ type: "control" });
  assert.equal(connection.seen, null);
  first.receive({ type: "status", t: 10 });
  first.receive({ type: "frame", t: 43.5 });
  first.receive({ type: "obstacles", obstacles: [] });
  assert.equal(connection.seen, 43.5);

  connection.open(); // again after a loss
  Socket.newest.onopen();
  assert.equal(connection.seen, null, "the server may have been restarted");
});
