// Decodes samples once more with the IDL parser of npm, and compares the values with those of a first decoder.
//
// usage: node decode.mjs SAMPLES IDL…
//
// A line of SAMPLES is {"topic", "type", "cdr", "value"}, with the bytes in hex. The IDL files have the types; a preprocessor
// line in them is ignored, so that a file comes after those that it includes. It prints {"messages": {TOPIC: COUNT},
// "differences": COUNT, "first": TEXT}.
import { createReadStream } from "node:fs";
import { readFile } from "node:fs/promises";
import { createInterface } from "node:readline";
import { isDeepStrictEqual } from "node:util";
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";

const [samples, ...idl] = process.argv.slice(2);
const texts = await Promise.all(idl.map((file) => readFile(file, "utf8")));
const definitions = parseIDL(texts.join("\n").replace(/^\s*#.*$/gm, ""));
const readers = new Map();

// As JSON has it: lists for typed arrays, and texts for 64-bit integers.
const plain = (value) => JSON.parse(JSON.stringify(value, (_, item) =>
  typeof item === "bigint" ? item.toString() : ArrayBuffer.isView(item) ? [...item] : item));

const result = { messages: {}, differences: 0, first: "" };
let lines = 0;
for await (const line of createInterface({ input: createReadStream(samples) })) {
  if (++lines % 10000 === 0) console.error(`${lines} samples`);  // a test waits for a sign
  const { topic, type, cdr, value } = JSON.parse(line);
  if (!readers.has(type)) readers.set(type, new MessageReader(type, definitions));
  const other = plain(readers.get(type).readMessage(Buffer.from(cdr, "hex")));
  result.messages[topic] = (result.messages[topic] ?? 0) + 1;
  if (isDeepStrictEqual(other, value)) continue;
  if (result.differences++ === 0) result.first = `${topic}: ${JSON.stringify(value)} and ${JSON.stringify(other)}`;
}
console.log(JSON.stringify(result));
