// The page of the recording of drawn_recording_test.cpp in a browser: the meshes of `north`, the pair that binds it, its
// rollout, its way, the plots, and the scene from each side.
//
// usage: node drawn.mjs URL BROWSER URDF [PICTURE.png]
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { jointsOf, linkPoses, moved, poseOf } from "./kinematics.mjs";
import { huesOf, isHue, LAUNCH, open, shootFresh } from "./pixels.mjs";

const [url, executablePath, urdf, picture] = process.argv.slice(2);
const joints = jointsOf(urdf);
const NAMES = [1, 2, 3, 4, 5, 6].map((i) => `joint${i}`);
const apart = (a, b) => Math.hypot(...a.slice(0, 3).map((x, i) => x - b[i]));
const posesOf = ({ q, base }) => linkPoses(joints, poseOf(base), NAMES, q);

/** The point of the picture [px] where a point in W is. */
function onScreen({ view, projection, width, height }, p) {
  const times = (m, [x, y, z]) => [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
  const clip = times(projection, times(view, p));
  return [Math.round(((clip[0] / clip[3] + 1) / 2) * width), Math.round(((1 - clip[1] / clip[3]) / 2) * height)];
}

const browser = await chromium.launch({ executablePath, ...LAUNCH });
try {
  const { page, errors } = await open(browser, url, { width: 1200, height: 800 });
  const track = page.getByRole("slider", { name: "Time of the recording" });
  await track.waitFor();
  const length = Number(await track.getAttribute("aria-valuemax"));
  /** Pauses at that share of the recording. */
  const seek = async (share) => {
    const box = await track.boundingBox();
    await page.mouse.click(box.x + share * box.width, box.y + box.height / 2);
    await page.waitForFunction(([low, high]) => {
      const now = Number(document.querySelector("#replay .track").getAttribute("aria-valuenow"));
      return now >= low && now <= high;
    }, [(share - 0.02) * length, (share + 0.02) * length]);
    // Joint 1 of north is −1.5 + 0.5 t.
    await page.waitForFunction(([low, high]) => {
      const q = window.hecaton.scene.drawn("north")?.q[0];
      return q >= low && q <= high;
    }, [-1.5 + 0.5 * (share - 0.03) * length, -1.5 + 0.5 * (share + 0.03) * length]);
  };

  await seek(0.25);
  await page.evaluate(() => window.hecaton.scene.loading);

  // What cannot be read as a mesh leaves the collision shapes of its link.
  const byShapes = await page.evaluate(() => window.hecaton.scene.linksByShapes("north"));
  assert.deepEqual(byShapes.sort(), ["forearm", "shoulder"]);
  assert.equal((await page.evaluate(() => window.hecaton.scene.linksByShapes("west"))).length, 7);

  // Where the links and the meshes are, at two times.
  for (const key of ["g", "b", "n", "w", "2"]) await page.keyboard.press(key); // bodies only, from above
  const places = { // by link, in its frame: points within the meshes and the shapes
    upper_arm: [[0.1, 0, 0.19], [0.2159, 0, 0.19], [0.33, 0, 0.19]],
    base_link: [[0.17, 0.17, 0.1], [-0.17, 0.17, 0.1], [-0.17, -0.17, 0.1], [0.17, -0.17, 0.1]],
    forearm: [[-0.0203, -0.04, 0], [-0.0203, -0.12, 0], [-0.0203, -0.2, 0]],
  };
  const isNear = (hue, wanted) => hue >= 0 && Math.abs(((hue - wanted + 540) % 360) - 180) < 25;
  const kinds = { upper_arm: (hue) => isNear(hue, 300), base_link: (hue) => isNear(hue, 120), forearm: (hue) => isHue(hue, 0) };
  const shots = [];
  for (const share of [0.25, 0.75]) {
    await seek(share);
    const shot = await shootFresh(page, ["north", "west"]);
    shots.push({ ...shot, hues: await huesOf(page), poses: posesOf(shot.arms.north) });
    if (picture) await page.screenshot({ path: picture.replace(".png", `-${share}.png`) });
  }
  let worst = 0;
  for (const { arms, poses } of shots) {
    for (const [link, columns] of Object.entries(arms.north.links)) {
      const pose = poses.get(link);
      for (let row = 0; row < 3; ++row) worst = Math.max(worst, Math.abs(columns[12 + row] - pose[row][3]));
    }
  }
  assert.ok(worst < 1e-4, `a link is ${worst} m from where it should be`);
  const share = (shot, poses, link) => {
    const points = places[link].map((place) => onScreen(shot, moved(poses.get(link), place)));
    return points.filter(([x, y]) => kinds[link](shot.hues[y * shot.width + x])).length / points.length;
  };
  for (const [link, least] of [["upper_arm", 0.6], ["base_link", 0.5], ["forearm", 0.6]]) {
    for (const [i, shot] of shots.entries()) {
      const found = share(shot, shot.poses, link);
      console.log(`${link}: ${(found * 100).toFixed(0)} % of its points have its colour`);
      assert.ok(found >= least, `${link} is not where it should be`);
      const elsewhere = share(shot, shots[1 - i].poses, link);
      if (link !== "base_link") assert.ok(elsewhere < 0.5, `${link} is also where it was`);
    }
  }

  // The pair that binds the motion, with the distance that the planner has said; between the two bodies.
  await page.keyboard.press("b");
  const pair = await (await page.waitForFunction(() => window.hecaton.scene.pairOf("north"))).jsonValue();
  const drawn = await page.evaluate(() => ["north", "west"].map((arm) => window.hecaton.scene.drawn(arm)));
  assert.equal(pair.text, "137 mm");
  [pair.own, pair.other].forEach((point, i) => {
    const forearm = posesOf(drawn[i]).get("forearm");
    const axis = Array.from({ length: 25 }, (_, k) => moved(forearm, [-0.0203, -0.01 * k, 0]));
    const distance = Math.min(...axis.map((p) => apart(p, point)));
    assert.ok(Math.abs(distance - 0.06) < 0.01, `an end of the pair is ${distance} m from the axis of its body`);
  });
  await page.keyboard.press("b");
  await page.waitForFunction(() => window.hecaton.scene.pairOf("north") === null);

  // The rollout leads from the tool to where this test's kinematics has the tool at the end of it; so does the way.
  await page.keyboard.press("w");
  await page.waitForFunction(() => window.hecaton.scene.motionOf("north").foreseen.length > 2);
  const { motion, q, base } = await page.evaluate(() => ({
    motion: window.hecaton.scene.motionOf("north"), ...window.hecaton.scene.drawn("north") }));
  const toolAt = (at) => moved(posesOf({ q: at, base }).get("tool0"), [0, 0, 0]);
  const time = (q[0] + 1.5) / 0.5;
  const end = [-1.5 + 0.5 * (time + 1), -1 - 0.2, 2.6, 0, 0.6, 0];
  assert.ok(apart(motion.foreseen[0], toolAt(q)) < 0.02, "the rollout does not begin at the tool");
  assert.ok(apart(motion.foreseen.at(-1), toolAt(end)) < 0.06, "the rollout does not end where it should");
  assert.ok(apart(motion.way.at(-1), toolAt([-1.5 + 0.5 * length, -1, 2.6, 0, 0.6, 0])) < 0.02, "nor does the way");
  if (picture) await page.screenshot({ path: picture });

  // From each side.
  for (const [key, axis, least] of [["2", [0, 0, -1], 0.99], ["3", [-1, 0, 0], 0.95], ["4", [0, 1, 0], 0.95], ["1", [-0.55, 0.68, -0.48], 0.95]]) {
    await page.keyboard.press(key);
    await page.waitForFunction(([wanted, cosine]) => {
      const { view } = window.hecaton.scene.cameraMatrices;
      const forward = [-view[2], -view[6], -view[10]];
      return forward.reduce((sum, x, i) => sum + x * wanted[i], 0) > cosine;
    }, [axis, least]);
  }

  // The plots: a line for each value that the recording has, and they go with the time.
  const plots = () => page.evaluate(() => [...document.querySelectorAll("#plots figure")].map((figure) => {
    const canvas = figure.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let coloured = 0;
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b, a] = data.slice(i, i + 4);
      if (a > 128 && Math.max(r, g, b) - Math.min(r, g, b) > 12) { ++coloured; sum = (sum + i * 31) % 1e9; }
    }
    return { caption: figure.querySelector("figcaption").textContent, coloured, sum };
  }));
  await seek(0.5);
  await page.keyboard.press(" "); // a plot has the values that were shown
  await page.waitForFunction((end) => Number(document.querySelector("#replay .track").getAttribute("aria-valuenow")) >= end, length * 0.8);
  const first = await plots();
  assert.equal(first.length, 4);
  for (const plot of first) assert.ok(plot.coloured > 5, `${plot.caption} is empty`);
  await page.waitForFunction((end) => Number(document.querySelector("#replay .track").getAttribute("aria-valuenow")) >= end - 1e-3, length);
  const later = await plots();
  first.forEach((plot, i) => assert.notEqual(plot.sum, later[i].sum, `${plot.caption} stands`));

  assert.deepEqual(errors, []);
  console.log(`largest error of a link ${(worst * 1e3).toFixed(4)} mm`);
} finally {
  await browser.close();
}
