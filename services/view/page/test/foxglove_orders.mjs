// Gives orders to a live cell as Foxglove does: calls services with the client of npm.
//
// usage: node foxglove_orders.mjs URL SUBPROTOCOL SERVICE…
//
// It calls the services in turn and prints {"services": [NAME…], "warnings": [TEXT…], "answers": [{"success", "message"}…]}.
// A service that the server does not offer has the answer null. Fails after 30 seconds.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import wsProtocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [url, protocol, ...calls] = process.argv.slice(2);
setTimeout(() => { console.error("no answer within 30 s"); process.exit(1); }, 30_000).unref();

const client = new wsProtocol.FoxgloveClient({ ws: new WebSocket(url, [protocol]) });
client.on("error", (error) => { console.error(error); process.exit(1); });
const event = (name) => new Promise((resolve) => {
  const take = (value) => { client.off(name, take); resolve(value); };
  client.on(name, take);
});

let services = [];
const warnings = [];
client.on("advertiseServices", (offered) => { services = offered; });
client.on("status", ({ message }) => warnings.push(message));
await event("advertise");
// The greeting has come when a request has its answer.
client.getParameters(["cell.name"], "greeted");
await event("parameterValues");

const answers = [];
for (const name of calls) {
  const service = services.find((one) => one.name === name);
  if (!service) {
    answers.push(null);
    continue;
  }
  const answered = event("serviceCallResponse");
  // An empty message: the header of CDR and the octet that ROS 2 puts into it.
  const data = new DataView(new Uint8Array([0, 1, 0, 0, 0]).buffer);
  client.sendServiceCallRequest({ serviceId: service.id, callId: answers.length + 1, encoding: "cdr", data });
  const reader = new MessageReader(parse(service.response?.schema ?? service.responseSchema, { ros2: true }));
  answers.push(reader.readMessage((await answered).data));
}
console.log(JSON.stringify({ services: services.map(({ name }) => name), warnings, answers }));
client.close();
