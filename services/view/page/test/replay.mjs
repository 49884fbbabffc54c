// The page of a recording in a browser: its time line, its controls, and the state at a time.
//
// usage: node replay.mjs URL BROWSER [PICTURE.png]
import assert from "node:assert/strict";
import { chromium } from "playwright-core";

const [url, executablePath, picture] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 } });
  page.setDefaultTimeout(60_000);  // software rendering is slow
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(url);
  const track = page.getByRole("slider", { name: "Time of the recording" });
  await track.waitFor();
  const length = Number(await track.getAttribute("aria-valuemax"));  // [s]
  const time = async () => Number(await track.getAttribute("aria-valuenow"));
  const until = (least, most) => page.waitForFunction(([low, high]) => {
    const now = Number(document.querySelector("#replay .track").getAttribute("aria-valuenow"));
    return now >= low && now <= high;
  }, [least, most]);
  const shown = () => page.evaluate(() => window.hecaton.scene.drawn("north")?.q);
  assert.ok(length > 3, `the recording has ${length} s`);
  assert.ok((await page.locator('#replay span[data-begun="true"]').count()) > 0, "no goal is marked");
  assert.ok((await page.locator("#replay span[data-mode]").count()) > 0, "no mode is marked");

  // Dragging seeks: to the middle, then to the end, and the arm is elsewhere.
  const box = await track.boundingBox();
  const [x, y] = [(share) => box.x + share * box.width, box.y + box.height / 2];
  await page.mouse.move(x(0.1), y);
  await page.mouse.down();
  for (let i = 1; i <= 8; ++i) await page.mouse.move(x(0.1 + 0.05 * i), y);
  await page.mouse.up();
  await until(length * 0.48, length * 0.52);
  await page.waitForFunction(() => Boolean(window.hecaton.scene.drawn("north")));
  await page.waitForFunction(() => document.querySelector("#mode").textContent === "RUN");
  await page.keyboard.press("ArrowDown");
  await page.waitForFunction(() => document.querySelector("#right").dataset.arm === "north");
  const middle = await shown();

  // A step is one tick of the arm's planner; two steps back and forth lead to the same time.
  const before = await time();
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press(".");
  await until(before + 1e-6, before + 1);
  const stepped = await time();
  await page.keyboard.press(".");
  await until(stepped + 1e-6, stepped + 1);
  await page.keyboard.press(",");
  await until(stepped - 2e-6, stepped + 2e-6);

  // The arrow keys on the time line do not move the section, too.
  await page.keyboard.press("x");
  const section = page.getByRole("slider", { name: "Place of the section" });
  const cutAt = await section.inputValue();
  const here = await time();
  await track.focus();
  await page.keyboard.press("ArrowLeft");
  await until(0, here - 0.9);
  assert.equal(await section.inputValue(), cutAt);
  await page.keyboard.press("ArrowRight");
  await until(here - 1e-3, here + 1e-3);
  await page.evaluate(() => document.activeElement?.blur());
  for (const key of ["x", "x", "x"]) await page.keyboard.press(key); // y, z, none

  // It plays, faster, and stands when it is paused.
  await page.keyboard.press("]");
  await page.waitForFunction(() => document.querySelector("#replay select").value === "2");
  await page.keyboard.press(" ");
  await until(stepped + 0.3, length + 1e-3);
  await page.keyboard.press(" ");
  await page.waitForFunction(() => document.querySelectorAll("#replay button")[1].textContent === "▶");

  await track.focus();
  // The arm has moved: at the begin or at the end it is elsewhere than in the middle.
  const elsewhere = () => page.waitForFunction(
    (q) => window.hecaton.scene.drawn("north")?.q.some((value, k) => Math.abs(value - q[k]) > 1e-3), middle,
    { timeout: 10_000 }).then(() => true, () => false);
  await page.keyboard.press("Home");
  await until(0, 0);
  await page.mouse.click(x(0.05), y);  // at the very begin no state has arrived
  await until(length * 0.04, length * 0.06);
  const moved = await elsewhere();
  await page.keyboard.press("End");
  await until(length - 1e-3, length + 1e-3);
  assert.ok(moved || await elsewhere(), "the arm does not move");
  await page.mouse.click(x(0.5), y);
  await until(length * 0.48, length * 0.52);
  await page.waitForFunction((q) => window.hecaton.scene.drawn("north")?.q.every((value, k) => Math.abs(value - q[k]) < 0.2),
                             middle);
  if (picture) await page.screenshot({ path: picture });
  assert.deepEqual(errors, []);
  console.log(`recording of ${length} s shown`);
} finally {
  await browser.close();
}
