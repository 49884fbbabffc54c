// A goal that is dragged by the gizmo at the tool of an arm, on the page of a live cell of three PUMA 560.
//
// usage: node goal_drag.mjs URL#token=… BROWSER [FOLDER]      FOLDER: gets pictures of the page
//
// The mouse drags the tool to a free place P and on to a place Q. With a crate at Q the ghost is red there. Nothing has
// moved until the order; after it, the tool is at P.
import assert from "node:assert/strict";
import { chromium } from "playwright-core";

const [address, executablePath, folder] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
});
const errors = [];
const step = (text) => console.log(text);

try {
  step("open the page");
  const page = await browser.newPage({ viewport: { width: 900, height: 620 } });
  page.setDefaultTimeout(110_000);  // of a step; the waiting program waits 120 s for each line
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(address);
  await page.waitForFunction(() => window.hecaton?.orders.controls && window.hecaton.scene.drawn("north") !== null);
  await page.waitForFunction(() => document.querySelector("#mode").textContent === "RUN");

  const picture = async (name) => folder && page.screenshot({ path: `${folder}/${name}.png` });
  const drawn = () => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  const joints = () => page.evaluate(() => window.hecaton.scene.drawn("north").q);
  const orders = () => page.evaluate(() => window.hecaton.orders.entries.filter(
    (entry) => entry.op === "goal" && !entry.text.startsWith("Not sent")).length);
  const answered = () => page.waitForFunction(() => window.hecaton.draft.settled);
  const sentence = () => page.locator("#drafttext").textContent();
  const looks = (wanted) => page.waitForFunction((one) => window.hecaton.scene.draftColour === one, wanted);
  const [FREE, BLOCKED] = ["7fa8d9", "e5605e"];
  const says = (pattern) => page.waitForFunction((source) => new RegExp(source).test(window.hecaton.draft.sentence), pattern.source);
  const colour = () => page.evaluate(() => window.hecaton.scene.draftColour);
  const wanted = () => page.evaluate(() => window.hecaton.scene.wantedTool);
  const apart = (a, b) => Math.hypot(...[0, 1, 2].map((i) => a[i] - b[i]));
  const press = (name) => page.locator(name).dispatchEvent("click");

  step("begin the drag");
  await page.evaluate(() => window.hecaton.select("north"));
  await press("#draggoal");
  await page.waitForFunction(() => window.hecaton.draft.arm === "north");
  await page.bringToFront();
  await drawn();
  const at = await joints();
  const box = await page.locator("#scene").boundingBox();
  const grip = async () => {
    const [x, y] = await page.evaluate(() => window.hecaton.scene.gizmoOnScreen());
    return [box.x + x, box.y + y];
  };
  const start = await wanted();
  let [x, y] = await grip();
  assert.equal(await page.evaluate(([a, b]) => document.elementFromPoint(a, b).tagName, [x, y]), "CANVAS");
  await page.mouse.move(x, y);
  await drawn();
  await page.mouse.down();
  const dragBy = async (dx, dy) => {
    for (let i = 1; i <= 4; ++i) await page.mouse.move(x + (dx * i) / 4, y + (dy * i) / 4);
    [x, y] = [x + dx, y + dy];
    await answered();
    await drawn();
  };

  step("to P");
  await dragBy(-12, 10);
  const P = await wanted();
  assert.ok(apart(P, start) > 0.03, `the gizmo moved by ${apart(P, start)} m`);
  step(`P: ${await sentence()} ${await colour()}`);
  await looks(FREE);
  await says(/^The arm can be there\.$/);
  const ghost = () => page.evaluate(() => window.hecaton.draft.q);
  const atP = await ghost();
  await picture("goal-free");

  step("to Q");
  await dragBy(-24, 0);
  const Q = await wanted();
  step(`Q: ${await sentence()} ${await colour()}`);
  await looks(FREE);

  step("out of reach");
  await dragBy(-1000, 0);
  step(await sentence());
  await says(/^out of reach: the nearest pose found is [\d.]+ m and /);
  await looks(BLOCKED);
  assert.equal(await page.locator("#gothere").isDisabled(), true);
  await picture("goal-out-of-reach");
  await page.keyboard.press("Enter");

  step("drop it at P");
  await dragBy(1024, 0);
  await page.mouse.up();
  await answered();
  assert.ok(apart(await wanted(), P) < 1e-3);
  const again = await ghost();
  assert.ok(again.every((value, i) => Math.abs(value - atP[i]) < 0.05), `the ghost is in another posture: ${again}, not ${atP}`);

  step("a crate at Q");
  await page.evaluate((place) => window.hecaton.orders.give({ op: "obstacle_add", name: "crate",
    shape: { kind: "box", size: [0.2, 0.2, 0.2] }, pose: [...place, 0, 0, 0, 1] }, "add crate"), Q.slice(0, 3));
  await page.waitForFunction(() => window.hecaton.scene.obstacleAt("crate") !== null);
  [x, y] = await grip();
  await page.mouse.move(x, y);
  await drawn();
  await page.mouse.down();
  await dragBy(-24, 0);
  step(await sentence());
  await says(/^north\/\w+ and crate overlap by [\d.]+ mm$/);
  await looks(BLOCKED);
  assert.equal(await page.locator("#gothere").isDisabled(), true);
  await picture("goal-blocked");

  step("back to P");
  await dragBy(24, 0);
  await page.mouse.up();
  await answered();
  await looks(FREE);
  assert.deepEqual(await joints(), at, "only the ghost moves");
  assert.equal(await orders(), 0);

  step("help closes without a stop");
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("?");
  await page.waitForFunction(() => document.querySelector("#keys").open);
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => !document.querySelector("#keys").open);
  assert.equal(await page.evaluate(() => window.hecaton.orders.entries.some((entry) => entry.op === "stop")), false);
  assert.equal(await page.evaluate(() => window.hecaton.draft.arm), "north");

  step("go there");
  const goal = await wanted();
  // A browser that is too busy to hear its server sends no goal. The drag goes on.
  do {
    await answered();
    await page.keyboard.press("Enter");
    await drawn();
  } while (await page.evaluate(() => window.hecaton.draft.arm !== null));
  await page.waitForFunction(() => window.hecaton.orders.entries.some(
    (entry) => entry.op === "goal" && entry.state === "done" && entry.text.includes("reached")));
  assert.equal(await orders(), 1);
  assert.equal(await page.evaluate(() => window.hecaton.draft.arm), null);
  // The tool of the drawn arm, which is some milliseconds behind the measured one.
  await page.waitForFunction((place) => {
    const tool = window.hecaton.scene.toolOf("north");
    const turn = Math.abs(tool[3] * place[3] + tool[4] * place[4] + tool[5] * place[5] + tool[6] * place[6]);
    return Math.hypot(tool[0] - place[0], tool[1] - place[1], tool[2] - place[2]) < 2e-3 && turn > Math.cos(0.5 * 0.01);
  }, goal);
  await picture("goal-reached");

  step("a drag ends with the control");
  await press("#draggoal");
  await page.waitForFunction(() => window.hecaton.draft.arm === "north");
  await press("#takecontrol");
  await page.waitForFunction(() => !window.hecaton.orders.controls && window.hecaton.draft.arm === null);
  assert.equal(await colour(), null);
  await page.close();

  step("a drag ends with the connection");
  const second = await browser.newPage({ viewport: { width: 480, height: 320 } });
  second.setDefaultTimeout(110_000);
  let link = null;
  const sent = [];
  await second.routeWebSocket(/\/live$/, (socket) => {
    link = socket;
    const server = socket.connectToServer();
    socket.onMessage((message) => {
      sent.push(JSON.parse(message).op);
      server.send(message);
    });
  });
  await second.goto(address);
  await second.waitForFunction(() => window.hecaton?.orders.controls && window.hecaton.scene.drawn("north") !== null);
  await second.evaluate(() => window.hecaton.select("north"));
  await second.locator("#draggoal").dispatchEvent("click");
  await second.evaluate(() => window.hecaton.draft.move(window.hecaton.scene.toolOf("north")));
  await second.waitForFunction(() => window.hecaton.draft.mayGo);
  step("close it");
  await link.close();
  await second.waitForFunction(() => window.hecaton.draft.arm === null);
  await second.keyboard.press("Enter");
  await second.waitForFunction(() => document.querySelector("#offline").hidden);
  assert.equal(await second.evaluate(() => window.hecaton.orders.controls), false);
  assert.ok(sent.includes("preview"));
  assert.equal(sent.includes("goal"), false);
  assert.deepEqual(errors, []);
} finally {
  await browser.close();
}
