// Orders of pages of a live cell of three PUMA 560, in a browser.
//
// usage: node orders.mjs URL#token=… BROWSER [FOLDER]      FOLDER: gets pictures of the page
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { chromium } from "playwright-core";

const [address, executablePath, folder] = process.argv.slice(2);
const [url] = address.split("#");

const browser = await chromium.launch({
  executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
});
const errors = [];
const step = (text) => console.log(text);

/** A page of its own session; small where nobody looks, for a software renderer draws all of them. */
async function open(where, viewport = { width: 480, height: 320 }) {
  const page = await browser.newPage({ viewport });
  page.setDefaultTimeout(110_000);  // of a step; who waits for this program waits 120 s for each line
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(where);
  await page.waitForFunction(() => document.querySelector("#orders .row span").textContent.length > 0 &&
    window.hecaton.orders.sentence !== "Not connected: orders cannot be sent.");
  return page;
}
const says = (page, text) => page.waitForFunction((wanted) => window.hecaton.orders.sentence.includes(wanted), text);
const mode = (page, text) => page.waitForFunction((wanted) => document.querySelector("#mode").textContent === wanted, text);
const answer = (page, state, text) => page.waitForFunction(([wanted, part]) => window.hecaton.orders.entries.some(
  (entry) => entry.state === wanted && entry.text.includes(part)), [state, text]);
// Without the pointer: a picture of a software renderer can take longer than a click waits.
const press = (page, name) => page.locator(name).dispatchEvent("click");

try {
  step("three pages");
  const watcher = await open(url);
  const driver = await open(address, folder ? { width: 1280, height: 760 } : { width: 900, height: 620 });
  const second = await open(address);

  step("one page controls");
  // One page controls; the token is neither in its address nor in its history.
  await says(driver, "This page controls the cell.");
  assert.equal(await driver.evaluate(() => location.href), url);
  await says(second, "controls the cell.");
  assert.match(await second.evaluate(() => window.hecaton.orders.sentence), /^The page at 127\.0\.0\.1:\d+ controls/);
  assert.equal(await second.locator("#controls").isVisible(), false);
  assert.equal(await watcher.locator("#controls").isVisible(), false);
  assert.equal(await watcher.locator("#stop").isVisible(), true);

  step("the address with the token where the page is open");
  const late = await open(url);
  const reloaded = late.waitForEvent("load", { timeout: 110_000 });
  await late.evaluate((fragment) => (location.hash = fragment), address.split("#")[1]);
  await reloaded;
  assert.equal(await late.evaluate(() => location.href), url);
  assert.equal(await late.evaluate(() => sessionStorage.getItem("token")), address.split("#token=")[1]);
  await late.close();

  step("a goal");
  // A goal, and its outcome.
  await mode(driver, "RUN");
  await driver.evaluate(() => window.hecaton.select("north"));
  await driver.locator("#pose").selectOption("ready");
  await press(driver, '#controls button:text-is("Go")');
  await answer(driver, "done", "north to ready: reached");

  step("orders");
  // Orders of the page that controls, for the cell and an arm.
  await press(driver, '#controls button:text-is("Hold") >> nth=0');
  await mode(watcher, "HOLD");
  await press(driver, '#controls button:text-is("Resume") >> nth=0');
  await mode(watcher, "RUN");
  await press(driver, `#controls button:text-is("Stop")`);
  await answer(driver, "done", "north is stopped");
  await press(driver, '#controls button:text-is("Resume") >> nth=1');
  await answer(driver, "done", "north may move");

  step("no recorder");
  await press(driver, "#saverecordings");
  await answer(driver, "failed", "the key record");

  step("a refused order");
  // What the cell refuses is shown.
  await driver.evaluate(() => window.hecaton.orders.give({ op: "obstacle_remove", name: "nothing" }, "remove nothing"));
  await answer(driver, "failed", "nothing");

  step("an obstacle");
  // An obstacle: added, dragged by its ghost with one order on drop, removed.
  await driver.evaluate(() => window.hecaton.orders.give({ op: "obstacle_add", name: "crate",
    shape: { kind: "box", size: [0.2, 0.2, 0.2] }, pose: [0.6, 1.6, 1.0, 0, 0, 0, 1] }, "add crate"));
  await answer(driver, "done", "crate is added");
  await driver.locator('#obstacles li:has-text("crate")').focus();
  await driver.keyboard.press("Enter");
  await driver.waitForFunction(() => window.hecaton.scene.ghost.chosen === "crate");
  assert.equal(await driver.getByRole("option", { name: /crate/, selected: true }).count(), 1);
  await driver.keyboard.press(" ");
  await driver.waitForFunction(() => window.hecaton.scene.ghost.chosen === null);
  await press(driver, '#obstacles li:has-text("crate")');
  await driver.waitForFunction(() => window.hecaton.scene.ghost.chosen === "crate");
  const at = (name) => driver.evaluate((wanted) => window.hecaton.scene.obstacleAt(wanted), name);
  const drawn = () => driver.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  await driver.bringToFront();
  const before = await at("crate");
  step("drag it");
  await drawn();
  const box = await driver.locator("#scene").boundingBox();
  const [x, y] = await driver.evaluate(() => window.hecaton.scene.gizmoOnScreen());
  assert.equal(await driver.evaluate(([a, b]) => document.elementFromPoint(a, b).tagName, [box.x + x, box.y + y]), "CANVAS");
  await driver.mouse.move(box.x + x, box.y + y);
  await drawn();
  await driver.mouse.down();
  for (let i = 1; i <= 4; ++i) await driver.mouse.move(box.x + x + 5 * i, box.y + y + 3 * i);
  await drawn();
  const moves = () => driver.evaluate(
    () => window.hecaton.orders.entries.filter((entry) => entry.op === "obstacle_move").length);
  assert.deepEqual(await at("crate"), before, "only the ghost moves");
  assert.equal(await moves(), 0);
  if (folder) await driver.screenshot({ path: `${folder}/drag.png` });
  await driver.mouse.up();
  await answer(driver, "done", "crate is moved");
  await driver.waitForFunction((old) => {
    const now = window.hecaton.scene.obstacleAt("crate");
    return now !== null && Math.hypot(...now.map((value, i) => value - old[i])) > 0.01;
  }, before);
  assert.equal(await moves(), 1);
  await press(driver, `#controls button:text-is("Remove")`);
  await answer(driver, "done", "crate is removed");

  step("stop by a key");
  // Every page stops the cell with one key, also from the search.
  await watcher.locator("#search").focus();
  await watcher.keyboard.press("Escape");
  await answer(watcher, "done", "the cell is stopped");
  await mode(driver, "STOP");
  if (folder) {
    for (const theme of ["dark", "light"]) {
      await driver.evaluate((wanted) => {
        if (document.documentElement.dataset.theme !== wanted) document.querySelector("#theme").click();
      }, theme);
      await driver.waitForTimeout(1500);
      await driver.screenshot({ path: `${folder}/control-${theme}.png` });
    }
    await watcher.screenshot({ path: `${folder}/watcher.png` });
  }
  await watcher.evaluate(() => window.hecaton.orders.give({ op: "resume" }, "resume"));
  await answer(watcher, "failed", "this page does not control the cell");
  await press(driver, '#controls button:text-is("Resume") >> nth=0');
  await mode(driver, "RUN");

  step("another site");
  // A page of another site reaches no cell through the browser of a user.
  const site = createServer((_, response) => response.end("<title>foreign</title>"));
  await new Promise((resolve) => site.listen(0, "127.0.0.1", resolve));
  const foreign = await browser.newPage();
  await foreign.goto(`http://127.0.0.1:${site.address().port}/`);
  const outcome = await foreign.evaluate((live) => new Promise((resolve) => {
    const socket = new WebSocket(live);
    socket.onopen = () => resolve("open");
    socket.onerror = () => resolve("refused");
  }), url.replace("http", "ws") + "live");
  assert.equal(outcome, "refused");
  site.close();

  step("the page is closed");
  // A page that is closed loses control; another takes it.
  await driver.close();
  await says(second, "No page controls");
  await press(second, "#takecontrol");
  await says(second, "This page controls the cell.");
  assert.deepEqual(errors, []);
} finally {
  await browser.close();
}
