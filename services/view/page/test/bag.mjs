// Reads a recording, or a bag of ROS 2, with the MCAP library and the parsers of npm, which share no code with Hecaton.
//
// usage: node bag.mjs FILE [TOPIC FIELD… [-- TOPIC FIELD…]…]
//
// It prints one JSON object a line: first {topics: {NAME: COUNT}, attachments: [NAME…], metadata: [NAME…]}, then for each
// message of a TOPIC {topic, log_time, publish_time, FIELD: VALUE…}. All CRCs are checked, and each message is decoded with the schema
// in the file. A file that breaks the format ends it with an error.
import assert from "node:assert/strict";
import { open } from "node:fs/promises";
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import { parse } from "@foxglove/rosmsg";
import { MessageReader as Ros2Reader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

const [path, ...words] = process.argv.slice(2);
const wanted = new Map();  // fields of each topic
for (let rest = words; rest.length > 0;) {
  const end = rest.indexOf("--") < 0 ? rest.length : rest.indexOf("--");
  wanted.set(rest[0], rest.slice(1, end));
  rest = rest.slice(end + 1);
}
const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };

const file = await open(path);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const { bytesRead, buffer } = await file.read(new Uint8Array(Number(size)), 0, Number(size), Number(offset));
    assert.equal(bytesRead, Number(size));
    return buffer;
  },
};

const text = (value) => JSON.stringify(value, (_, item) =>
  typeof item === "bigint" ? item.toString() : ArrayBuffer.isView(item) ? [...item] : item);

function decoder(schema) {
  const definition = new TextDecoder().decode(schema.data);
  if (schema.encoding === "ros2msg") return new Ros2Reader(parse(definition, { ros2: true }));
  assert.equal(schema.encoding, "omgidl");
  return new MessageReader(schema.name, parseIDL(definition));
}

// By the indexes at the end of the file.
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const decoders = new Map();
const counts = {};
const lines = [];
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  if (channel.messageEncoding !== "cdr") {
    JSON.parse(new TextDecoder().decode(message.data));
    continue;
  }
  const schema = reader.schemasById.get(channel.schemaId);
  if (!decoders.has(schema.id)) decoders.set(schema.id, decoder(schema));
  const value = decoders.get(schema.id).readMessage(message.data);
  if (!wanted.has(channel.topic)) continue;
  lines.push({ topic: channel.topic, log_time: message.logTime, publish_time: message.publishTime,
               ...Object.fromEntries(wanted.get(channel.topic).map((field) => [field, value[field]])) });
}

// And from the beginning, as a program that copies the stream.
const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
const streamed = {};
const topics = new Map();
const found = { attachments: [], metadata: [] };
for (let offset = 0n, size = await readable.size(); offset < size; offset += 1n << 20n) {
  stream.append(await readable.read(offset, size - offset < 1n << 20n ? size - offset : 1n << 20n));
  for (let record = stream.nextRecord(); record; record = stream.nextRecord()) {
    if (record.type === "Channel") topics.set(record.id, record.topic);
    if (record.type === "Message") {
      streamed[topics.get(record.channelId)] = (streamed[topics.get(record.channelId)] ?? 0) + 1;
    }
    if (record.type === "Attachment") found.attachments.push(record.name);
    if (record.type === "Metadata") found.metadata.push(record.name);
  }
}
assert.ok(stream.done());
assert.deepEqual(Object.entries(streamed).sort(), Object.entries(counts).sort());
assert.equal(reader.statistics.messageCount, BigInt(Object.values(counts).reduce((sum, count) => sum + count, 0)));

console.log(text({ topics: counts, ...found }));
for (const line of lines) console.log(text(line));
await file.close();
