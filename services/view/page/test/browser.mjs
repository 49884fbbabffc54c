// The page of a live cell of three PUMA 560 in a browser, while an arm moves.
//
// usage: node browser.mjs URL BROWSER URDF
//
// It compares the poses of all links on the page with a forward kinematics of its own, which reads the URDF; looks that
// the arm moves and that names of states appear; and presses keys. It prints frames per second and the time of scripts.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const [url, executablePath, urdf] = process.argv.slice(2);

// --- forward kinematics from the URDF: 4 × 4 matrices in rows

const product = (a, b) => a.map((row) => b[0].map((_, j) => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
const turn = (axis, angle) => {
  const [x, y, z] = axis;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const t = 1 - c;
  return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0], [t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0],
          [t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0], [0, 0, 0, 1]];
};
const shift = ([x, y, z]) => [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]];
const posed = (xyz, [r, p, y]) =>
  [shift(xyz), turn([0, 0, 1], y), turn([0, 1, 0], p), turn([1, 0, 0], r)].reduce(product);
const numbers = (text, tag, attribute, otherwise) => {
  const found = new RegExp(`<${tag}[^>]*\\b${attribute}="([^"]*)"`).exec(text);
  return found ? found[1].trim().split(/\s+/).map(Number) : otherwise;
};

const joints = [...readFileSync(urdf, "utf8").matchAll(/<joint\s[^>]*type="(\w+)"[\s\S]*?<\/joint>/g)].map(([text, type]) => ({
  type,
  parent: /<parent\s+link="([^"]+)"/.exec(text)[1],
  child: /<child\s+link="([^"]+)"/.exec(text)[1],
  origin: posed(numbers(text, "origin", "xyz", [0, 0, 0]), numbers(text, "origin", "rpy", [0, 0, 0])),
  axis: numbers(text, "axis", "xyz", [1, 0, 0]),
}));

function linkPoses(base, q) {
  const children = new Set(joints.map((joint) => joint.child));
  const poses = new Map([[joints.find((joint) => !children.has(joint.parent)).parent, base]]);
  let next = 0;
  for (const joint of joints) {
    const motion = joint.type === "fixed" ? shift([0, 0, 0]) : turn(joint.axis, q[next++]);
    poses.set(joint.child, [poses.get(joint.parent), joint.origin, motion].reduce(product));
  }
  return poses;
}

// --- the page

const browser = await chromium.launch({
  executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
});
try {
  const page = await browser.newPage({ viewport: { width: 800, height: 500 } });
  page.setDefaultTimeout(240_000);  // software rendering beside other tests takes minutes
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(url);
  await page.waitForFunction(() => Boolean(window.hecaton?.scene.drawn("north")));

  // The arm moves: several configurations.
  const seen = [];
  for (let i = 0; i < 5; ++i) {
    const before = seen.length ? seen[seen.length - 1].north.q : null;
    if (i < 3) {
      await page.waitForFunction((last) => last === null ||
        window.hecaton.scene.drawn("north").q.some((value, k) => Math.abs(value - last[k]) > 0.02), before);
    }
    seen.push(await page.evaluate(() => Object.fromEntries(["north", "west", "east"].map(
      (arm) => [arm, window.hecaton.scene.drawn(arm)]))));
  }
  let worst = 0;
  for (const shown of seen) {
    for (const { q, base, links } of Object.values(shown)) {
      const expected = linkPoses(product(shift(base.slice(0, 3)), quaternion(base.slice(3))), q);
      for (const [link, columns] of Object.entries(links)) {
        const pose = expected.get(link);
        if (!pose) continue;
        for (let row = 0; row < 3; ++row) worst = Math.max(worst, Math.abs(columns[12 + row] - pose[row][3]));
      }
    }
  }
  assert.ok(worst < 1e-4, `a link is ${worst} m from where it should be`);

  // States in words, keys, search.
  await page.waitForFunction(() => document.querySelector("#mode").textContent === "RUN");
  assert.equal(await page.locator("#arms li").count(), 3);
  await page.keyboard.press("ArrowDown");
  await page.waitForFunction(() => document.querySelector("#right").dataset.arm === "north");
  await page.keyboard.press("/");
  await page.keyboard.type("west");
  await page.waitForFunction(() => document.querySelectorAll("#arms li").length === 1);
  await page.locator("#search").fill("");
  await page.waitForFunction(() => document.querySelectorAll("#arms li").length === 3);
  await page.evaluate(() => document.activeElement.blur());
  for (const key of ["s", "p", "l", "g", "b", "n", "2", "3", "4", "f", "t", "1"]) await page.keyboard.press(key);

  // Not an empty picture: the middle of the scene has many colours.
  const colours = await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => {
    const source = document.querySelector("#scene canvas");
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [200, 150];
    requestAnimationFrame(() => {
      copy.getContext("2d").drawImage(source, 0, 0, 200, 150);
      const { data } = copy.getContext("2d").getImageData(0, 0, 200, 150);
      const found = new Set();
      for (let i = 0; i < data.length; i += 4) found.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
      resolve(found.size);
    });
  })));
  assert.ok(colours > 20, `the scene has ${colours} colours`);
  assert.deepEqual(errors, []);
  const statistics = await page.evaluate(() => window.hecaton.scene.statistics);
  console.log(`largest error ${(worst * 1e3).toFixed(4)} mm; ${statistics.framesPerSecond.toFixed(1)} frames/s, ` +
              `scripts ${statistics.scriptMean.toFixed(2)} ms a frame`);
} finally {
  await browser.close();
}

function quaternion([x, y, z, w]) {
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0],
          [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0],
          [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0], [0, 0, 0, 1]];
}
