// Reads a live cell as Foxglove does: with the client of npm, schemas of the server, and CDR.
//
// usage: node foxglove.mjs URL SUBPROTOCOL
//
// It subscribes to every channel, decodes messages of each, and tries what the server must refuse. It prints
// {"server", "protocol", "channels", "joints": {JOINT: POSITION}, "fixed", "moving", "arms", "diagnostics", "parameters"},
// and fails when something is missing for 30 seconds.
import assert from "node:assert/strict";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import wsProtocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [url, protocol] = process.argv.slice(2);
const guard = setTimeout(() => { console.error(`the test waits for ${waiting}`); process.exit(1); }, 30_000);
let waiting = "the connection";

const socket = new WebSocket(url, [protocol]);
const client = new wsProtocol.FoxgloveClient({ ws: socket });
client.on("error", (error) => { console.error(error); process.exit(1); });
const event = (name, what = name) => {
  waiting = what;
  return new Promise((resolve) => {
    const take = (value) => { client.off(name, take); resolve(value); };
    client.on(name, take);
  });
};

const [server, channels] = await Promise.all([event("serverInfo"), event("advertise")]);
assert.equal(socket.protocol, protocol);
assert.deepEqual(server.capabilities, ["time", "parameters", "assets"], "no services without orders");

// One message of every channel. The latched ones were sent before this client came.
const byTopic = new Map();
const bySubscription = new Map();
const last = new Map();
let missing = channels.length;
const complete = new Promise((resolve) => {
  client.on("message", ({ subscriptionId, timestamp, data }) => {
    const channel = bySubscription.get(subscriptionId);
    assert.ok(channel, "a message without a subscription");
    assert.ok(Math.abs(Number(timestamp / 1_000_000n) - Date.now()) < 60_000, "log time is wall time");
    if (!last.has(channel.topic)) missing -= 1;
    last.set(channel.topic, channel.reader.readMessage(data));
    if (missing === 0) resolve();
  });
});
for (const channel of channels) {
  assert.equal(channel.encoding, "cdr");
  assert.equal(channel.schemaEncoding, "ros2msg");
  channel.reader = new MessageReader(parse(channel.schema, { ros2: true }));
  channel.subscription = client.subscribe(channel.id);
  bySubscription.set(channel.subscription, channel);
  byTopic.set(channel.topic, channel);
}
waiting = "a message of each channel";
const named = setInterval(() => { waiting = `messages of ${channels.map((c) => c.topic).filter((t) => !last.has(t))}`; }, 500);
await complete;
clearInterval(named);
const time = await event("time");
assert.ok(Math.abs(Number(time.timestamp / 1_000_000n) - Date.now()) < 60_000);

const parameters = async (names, id) => {
  client.getParameters(names, id);
  const answer = await event("parameterValues");
  assert.equal(answer.id, id);
  return answer.parameters;
};
const all = await parameters([], "all");
assert.deepEqual(await parameters(["cell.name"], "one"), all.filter(({ name }) => name === "cell.name"));

// What the server refuses, without an end of the connection.
const refused = async (send, pattern) => {
  send();
  const { level, message } = await event("status", `the refusal ${pattern}`);
  assert.ok(level > 0);
  assert.match(message, pattern);
};
await refused(() => client.setParameters([{ name: "cell.name", value: "other" }]), /cannot be set/);
await refused(() => client.advertise({ topic: "/x", encoding: "cdr", schemaName: "std_msgs/msg/String" }), /'advertise'/);
await refused(() => client.sendMessage(1, new Uint8Array(8)), /message data/);
await refused(() => client.subscribeConnectionGraph(), /subscribeConnectionGraph/);
await refused(() => client.subscribe(9999), /no channel 9999/);
assert.deepEqual(await parameters([], "again"), all, "nothing was set");
let request = 0;
for (const uri of ["file:///etc/passwd", "/etc/passwd", "package://hecaton/../../../etc/passwd", "package://hecaton/meshes/0/../x",
                   "http://localhost/"]) {
  client.fetchAsset(uri, ++request);
  const answer = await event("fetchAssetResponse");
  assert.equal(answer.requestId, request);
  assert.equal(answer.status, 1, `${uri} is no asset`);
}
client.sendServiceCallRequest({ serviceId: 1, callId: 7, encoding: "cdr", data: new DataView(new ArrayBuffer(4)) });
assert.equal((await event("serviceCallFailure")).callId, 7);

// An unsubscribed channel is silent from the next answer on; the others go on.
client.unsubscribe(byTopic.get("/joint_states").subscription);
await parameters(["cell.name"], "unsubscribed");
bySubscription.delete(byTopic.get("/joint_states").subscription);
for (let i = 0; i < 20; ++i) await event("message");
// It can be subscribed again.
const again = client.subscribe(byTopic.get("/joint_states").id);
bySubscription.set(again, byTopic.get("/joint_states"));
last.delete("/joint_states");
missing = 1;
while (!last.has("/joint_states")) await event("message");

const states = last.get("/joint_states");
const levels = last.get("/diagnostics").status.map(({ name, level, message }) => ({ name, level, message }));
console.log(JSON.stringify({
  server: server.name,
  protocol: socket.protocol,
  channels: channels.map(({ topic, schemaName }) => `${topic} ${schemaName}`),
  joints: Object.fromEntries(states.name.map((name, i) => [name, states.position[i]])),
  fixed: last.get("/tf_static").transforms.map(({ header, child_frame_id }) => `${header.frame_id} ${child_frame_id}`),
  moving: last.get("/tf").transforms.map(({ header, child_frame_id }) => `${header.frame_id} ${child_frame_id}`),
  robot: last.get("/robot_description").data,
  obstacles: last.get("/hecaton/obstacles").markers.map(({ ns, action }) => `${action} ${ns}`),
  goals: last.get("/hecaton/goals").markers.map(({ ns, action }) => `${action} ${ns}`),
  diagnostics: levels,
  parameters: Object.fromEntries(all.map(({ name, value }) => [name, value])),
}));
clearTimeout(guard);

// A message that is none of the protocol ends the connection with a status and a close frame, and only this one.
const closed = event("close");
const told = event("status", "the last status");
socket.send("{");
assert.match((await told).message, /no JSON object/);
const { code } = await closed;
assert.equal(code, 1008);
const other = new WebSocket(url, [protocol]);
await new Promise((resolve, reject) => { other.onmessage = resolve; other.onerror = reject; });
other.close();
