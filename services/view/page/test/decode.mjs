// Decodes samples once more with parsers of npm, and compares the values with those of a first decoder and of the publisher.
//
// usage: node decode.mjs SAMPLES TEXTS IDL…
//
// A line of SAMPLES is {"topic", "type", "cdr", "value", "own"}, with the bytes in hex and the values of the first decoder and,
// where they are known, of the publisher. TEXTS has {TYPE: text} of messages of ROS 2.
// The IDL files have the other types; a preprocessor line in them is ignored, so that a file comes after those that it
// includes. It prints {"messages": {TOPIC: COUNT}, "own": {TOPIC: COUNT}, "differences": COUNT, "first": TEXT}; `own` counts the
// messages that were compared with the values of their publisher.
import { createReadStream } from "node:fs";
import { readFile } from "node:fs/promises";
import { createInterface } from "node:readline";
import { isDeepStrictEqual } from "node:util";
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader as IdlReader } from "@foxglove/omgidl-serialization";
import { parse } from "@foxglove/rosmsg";
import { MessageReader as TextReader } from "@foxglove/rosmsg2-serialization";

const [samples, texts, ...idl] = process.argv.slice(2);
const ofRos = JSON.parse(await readFile(texts, "utf8"));
const files = await Promise.all(idl.map((file) => readFile(file, "utf8")));
const definitions = parseIDL(files.join("\n").replace(/^\s*#.*$/gm, ""));
const readers = new Map();
const makeReader = (type) =>
  type in ofRos ? new TextReader(parse(ofRos[type], { ros2: true })) : new IdlReader(type, definitions);

// As JSON has it: lists for typed arrays, and texts for 64-bit integers.
const plain = (value) => JSON.parse(JSON.stringify(value, (_, item) =>
  typeof item === "bigint" ? item.toString() : ArrayBuffer.isView(item) ? [...item] : item));

const result = { messages: {}, own: {}, differences: 0, first: "" };
const count = (counts, topic) => { counts[topic] = (counts[topic] ?? 0) + 1; };
let lines = 0;
for await (const line of createInterface({ input: createReadStream(samples) })) {
  if (++lines % 10000 === 0) console.error(`${lines} samples`);  // a test waits for a sign
  const { topic, type, cdr, value, own } = JSON.parse(line);
  if (!readers.has(type)) readers.set(type, makeReader(type));
  const other = plain(readers.get(type).readMessage(Buffer.from(cdr, "hex")));
  count(result.messages, topic);
  const all = { value, other };
  if (own !== undefined) {
    count(result.own, topic);
    all.own = own;
  }
  if (Object.values(all).every((one) => isDeepStrictEqual(one, value))) continue;
  if (result.differences++ === 0) result.first = `${topic}: ${JSON.stringify(all)}`;
}
console.log(JSON.stringify(result));
