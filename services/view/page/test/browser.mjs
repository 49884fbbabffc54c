// The page of a live cell of three PUMA 560 in a browser, while the arm north moves: states in words, keys, search, planned
// ways and sections. Then it asks on stdout that the arm rests, that its driver stops, and that it goes on ("continue").
//
// usage: node browser.mjs URL BROWSER [PICTURE.png]
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { chroma, huesOf, LAUNCH, open, pixelsOf, shoot, shootFresh } from "./pixels.mjs";

const [url, executablePath, picture] = process.argv.slice(2);
const ARMS = ["north", "west", "east"];
const WINDOW = { width: 840, height: 480 }; // drawn by software
const step = (text) => console.log(text);

const browser = await chromium.launch({ executablePath, ...LAUNCH });
try {
  const { page, errors } = await open(browser, url, WINDOW);
  await page.waitForFunction((arms) => arms.every((arm) => window.hecaton?.scene.drawn(arm)), ARMS);

  step("states, keys, search");
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
  // The page follows the theme of the system, until a person chooses one.
  const theme = (wanted) => page.waitForFunction((name) => document.documentElement.dataset.theme === name, wanted);
  for (const system of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: system });
    await theme(system);
  }
  await page.keyboard.press("t");
  await theme("light");
  await page.emulateMedia({ colorScheme: "light" });
  await page.emulateMedia({ colorScheme: "dark" });
  await theme("light");
  await page.keyboard.press("t");
  for (const key of ["s", "p", "l", "2", "3", "4", "f", "t", "1"]) await page.keyboard.press(key);

  step("the stop button");
  // The button that stops the cell is within each window, whatever the cell and its mode are called.
  for (const viewport of [{ width: 768, height: 1024 }, { width: 360, height: 640 }, { width: 1200, height: 700 },
                          WINDOW]) {
    await page.setViewportSize(viewport);
    const stop = await page.evaluate(() => {
      const texts = [["#cell", "line 4 of the western hall, three PUMA 560"], ["#mode", "NO SUPERVISOR FOR 12.3 s, LAST RUN 30 %"]]
        .map(([id, text]) => [document.querySelector(id), text]);
      for (const entry of texts) {
        entry.push(entry[0].textContent);
        entry[0].textContent = entry[1];
      }
      const button = document.querySelector("#stop");
      const { left, right, top, bottom } = button.getBoundingClientRect();
      const hits = [left + 2, (left + right) / 2, right - 2].map((x) => {
        const found = document.elementFromPoint(x, (top + bottom) / 2);
        return found !== null && button.contains(found);
      });
      for (const [element, , former] of texts) element.textContent = former;
      return { left, right, width: window.innerWidth, hits };
    });
    assert.ok(stop.left >= 0 && stop.right <= stop.width && stop.hits.every(Boolean), JSON.stringify({ viewport, stop }));
  }

  step("the way");
  // The way of the tool begins at the tool, and ends elsewhere. W hides it.
  const way = await page.waitForFunction(() => {
    const { scene } = window.hecaton;
    const drawn = scene.motionOf("north").way;
    if (drawn.length < 3) return null;
    const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    return { begin: apart(drawn[0], scene.toolOf("north")), length: apart(drawn[0], drawn[drawn.length - 1]) };
  });
  const { begin, length } = await way.jsonValue();
  assert.ok(length > 0.05 && begin < length + 0.2, `the way begins ${begin} m from the tool, and leads ${length} m away`);
  if (picture) await page.screenshot({ path: picture });
  const drawnWay = () => page.evaluate(() => window.hecaton.scene.motionOf("north").way.length);
  await page.keyboard.press("w");
  assert.equal(await drawnWay(), 0);
  await page.keyboard.press("w");

  step("sections");
  // Bodies only, without the halos of above. A section across x takes all away at one end, and nothing at the other.
  for (const key of ["g", "b", "n", "w", "s", "p", "l", "t"]) await page.keyboard.press(key);
  const coloured = async () => {
    await shootFresh(page, ARMS);
    const all = await huesOf(page);
    return ARMS.reduce((sum, _, index) => sum + pixelsOf(all, index).length, 0);
  };
  const whole = await coloured();
  assert.ok(whole > 500, `the arms have ${whole} pixels`);
  await page.keyboard.press("x");
  const slider = page.getByRole("slider", { name: "Place of the section" });
  const half = await coloured();
  assert.ok(half < 0.9 * whole && half > 0.1 * whole, `${half} of ${whole} pixels are left`);
  if (picture) await page.screenshot({ path: picture.replace(".png", "-section.png") });
  const at = Number(await slider.inputValue());
  await page.keyboard.press("ArrowLeft");
  assert.ok(Number(await slider.inputValue()) < at, "the key moves the section");
  const low = await slider.getAttribute("min");
  await slider.press("Home");
  const ends = [await coloured()];
  await slider.press("End");
  ends.push(await coloured());
  ends.sort((a, b) => a - b);
  assert.equal(ends[0], 0, "a section before the first body leaves pixels");
  assert.ok(ends[1] > 0.8 * whole, "a section behind the last body hides something"); // north moves
  step("the keys of the slider");
  // The slider keeps its own keys, and leaves the others to the page.
  await slider.focus();
  await page.keyboard.press("Home");
  assert.equal(Number(await slider.inputValue()), Number(low));
  assert.equal(await page.evaluate(() => document.querySelector("#right").dataset.arm), "north");
  for (const key of ["x", "x", "x"]) await page.keyboard.press(key); // y, z, none
  assert.ok(await slider.isHidden());
  assert.ok(await coloured() > 0.8 * whole);

  // An arm without states fades, and only that one. Its agent restarts a driver that hangs for ten seconds.
  console.log("let the arms rest");
  const chromas = async (all) => Promise.all(ARMS.map((_, index) => page.evaluate(chroma, pixelsOf(all, index))));
  const shown = async () => (await page.evaluate(shoot, ARMS)).arms.north.q;
  const fresh = {};
  do {
    fresh.q = (await shootFresh(page, ARMS)).arms.north.q;
    fresh.all = await huesOf(page);
    fresh.chroma = await chromas(fresh.all);
  } while (String(await shown()) !== String(fresh.q));
  console.log("stop the driver");
  await page.waitForFunction(() => window.hecaton.scene.opacityOf("north") < 0.4);
  for (;;) {
    const { arms, opacities } = await page.evaluate(shoot, ARMS);
    assert.equal(String(arms.north.q), String(fresh.q));
    if (opacities[0] < 0.4 && opacities[1] === 1 && opacities[2] === 1) break;
  }
  const now = await chromas(fresh.all);
  ARMS.forEach((arm, index) => {
    const left = now[index] / fresh.chroma[index];
    console.log(`${arm}: ${pixelsOf(fresh.all, index).length} pixels have ${(left * 100).toFixed(0)} % of their colour`);
    assert.ok(arm === "north" ? left < 0.75 : left > 0.9, `${arm} has ${left} of its colour`);
  });
  if (picture) await page.screenshot({ path: picture.replace(".png", "-stale.png") });
  await page.locator("#search").fill("is:stale");
  await page.waitForFunction(() => String([...document.querySelectorAll("#arms li")].map((row) => row.id)) === "arm-north");
  console.log("continue");
  await page.waitForFunction(() => window.hecaton.scene.opacityOf("north") === 1);
  await page.waitForFunction(() => document.querySelectorAll("#arms li").length === 0);
  assert.deepEqual(errors, []);
} finally {
  await browser.close();
}
