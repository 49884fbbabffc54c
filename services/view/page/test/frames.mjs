// The page of a recording that plays: what the scripts of a frame take.
//
// usage: node frames.mjs URL BROWSER ARMS [PICTURE.png]
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { LAUNCH, open } from "./pixels.mjs";

const [url, executablePath, arms, picture] = process.argv.slice(2);
const MOST = 8; // of the median frame [ms]
const browser = await chromium.launch({ executablePath, ...LAUNCH });
try {
  const { page, errors } = await open(browser, url, { width: 1000, height: 700 });
  await page.waitForFunction((count) => document.querySelectorAll("#arms li").length === Number(count), arms);
  await page.evaluate(() => window.hecaton.scene.loading);
  for (let i = 0; i < 4; ++i) await page.keyboard.press("["); // slowly, so that it does not end meanwhile
  await page.keyboard.press(" ");
  const arm = await page.evaluate(() => document.querySelector("#arms li .name").textContent.trim());
  const q = () => page.evaluate((name) => window.hecaton.scene.drawn(name)?.q, arm);
  await page.waitForFunction((name) => Boolean(window.hecaton.scene.drawn(name)), arm);
  const before = await q();
  await page.evaluate(() => window.hecaton.scene.forgetStatistics());
  await page.waitForFunction(() => window.hecaton.scene.statistics.frames >= 120);
  if (picture) await page.screenshot({ path: picture });
  const { framesPerSecond, scriptMean, scriptMedian, scriptMost } = await page.evaluate(() => window.hecaton.scene.statistics);
  console.log(`${arms} arms: scripts ${scriptMedian.toFixed(2)} ms a frame (median), ${scriptMean.toFixed(2)} (mean), ` +
              `${scriptMost.toFixed(2)} (most); ${framesPerSecond.toFixed(1)} frames/s, rendered by software`);
  assert.ok((await q()).some((value, k) => Math.abs(value - before[k]) > 1e-3), `${arm} stands`);
  assert.ok(framesPerSecond < 11, `${framesPerSecond} frames/s take the processor from the planners`);
  assert.ok(scriptMedian <= MOST, `the scripts of a frame take ${scriptMedian} ms`);
  assert.deepEqual(errors, []);
} finally {
  await browser.close();
}
