// Bundles the page and packs it into a C++ source.
//
// usage: node build.mjs [--pack FILE.cpp] [--tests]     --tests: bundles test/*.test.ts into dist/tests instead
import { build } from "esbuild";
import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const words = process.argv.slice(2);
const common = { bundle: true, logLevel: "warning", target: "es2021" };

if (words.includes("--tests")) {
  const tests = readdirSync("test").filter((name) => name.endsWith(".test.ts"));
  await build({
    ...common,
    entryPoints: tests.map((name) => `test/${name}`),
    outdir: "dist/tests",
    outExtension: { ".js": ".mjs" },
    format: "esm",
    platform: "node",
    external: ["playwright-core"],
  });
  process.exit();
}

// What only `hecaton render` needs is a file of its own.
const script = { ...common, format: "esm", minify: true, legalComments: "none" };
await build({ ...script, entryPoints: ["src/main.ts"], outfile: "dist/page.js", external: ["./picture.js"] });
await build({ ...script, entryPoints: ["src/picture.ts"], outfile: "dist/picture.js" });
await build({ ...common, entryPoints: ["src/page.css"], outfile: "dist/page.css", minify: true });

// What the bundle contains of others, with their licenses: their authors ask for it.
const licenses = ["three", "urdf-loader", "uplot", "mediabunny"].map((name) => {
  const { version, license } = JSON.parse(readFileSync(`node_modules/${name}/package.json`, "utf8"));
  const text = `node_modules/${name}/LICENSE`; // urdf-loader has none: its license is that of Hecaton
  return `${name} ${version} (${license})\n\n${existsSync(text) ? readFileSync(text, "utf8") : ""}`;
});
const files = [
  ["/index.html", "text/html; charset=utf-8", readFileSync("src/index.html")],
  ["/page.js", "text/javascript; charset=utf-8", readFileSync("dist/page.js")],
  ["/picture.js", "text/javascript; charset=utf-8", readFileSync("dist/picture.js")],
  ["/page.css", "text/css; charset=utf-8", readFileSync("dist/page.css")],
  ["/licenses.txt", "text/plain; charset=utf-8", Buffer.from(licenses.join("\n\n"))],
];

const bytes = (buffer) => {
  const lines = [];
  for (let i = 0; i < buffer.length; i += 4096) lines.push([...buffer.subarray(i, i + 4096)].join(","));
  return lines.join(",\n");
};
const arrays = files.map(([, , content], i) =>
  `constexpr unsigned char kFile${i}[] = {\n${bytes(gzipSync(content, { level: 9 }))}};\n`);
const rows = files.map(([path, type], i) => `    {"${path}", "${type}", kFile${i}},\n`);
const source = `// Written by build.mjs.
#include "services/view/page.hpp"
namespace hecaton::services::view {
namespace {
${arrays.join("")}constexpr PackedFile kFiles[] = {
${rows.join("")}};
}  // namespace
std::span<const PackedFile> packed_files() { return kFiles; }
}  // namespace hecaton::services::view
`;
const at = words.indexOf("--pack");
mkdirSync("dist", { recursive: true });
writeFileSync(at < 0 ? "dist/packed_page.cpp" : words[at + 1], source);
