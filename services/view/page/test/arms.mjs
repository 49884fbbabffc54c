// The moving arms of a live cell in a browser: each link is where a forward kinematics of this test has it, and the
// picture has the colour of the arm where the camera projects its links to, and nowhere else.
//
// usage: node arms.mjs URL BROWSER PICTURE.png ARM=URDF...     every ARM moves meanwhile
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import WebSocket from "ws";
import { jointsOf, linkPoses, moved, poseOf, product } from "./kinematics.mjs";
import { huesOf, isHue, LAUNCH, open, pixelsOf, shootFresh } from "./pixels.mjs";

const [url, executablePath, picture, ...words] = process.argv.slice(2);
const joints = new Map(words.map((word) => word.split("=")).map(([arm, urdf]) => [arm, jointsOf(urdf)]));

const cell = await new Promise((resolve, reject) => {
  const socket = new WebSocket(`${url.replace("http", "ws")}live`);
  socket.on("error", reject);
  socket.on("message", (data) => {
    const message = JSON.parse(String(data));
    if (message.type !== "cell") return;
    socket.close();
    resolve(message);
  });
});

/** Points within the bodies of an arm in W, by the kinematics of this test. */
function pointsOf(arm, { q, base }) {
  const poses = linkPoses(joints.get(arm.name), poseOf(base), arm.joints, q);
  return arm.shapes.flatMap(({ link, capsule }) => {
    const body = poses.get(arm.links[link].name);
    if (!body) return [];
    const placed = product(body, poseOf(capsule.pose));
    return [-0.5, -0.25, 0, 0.25, 0.5].map((share) => ({ p: moved(placed, [0, 0, share * capsule.length]), radius: capsule.radius }));
  });
}

/** On the picture [px], with the radius of the body there. */
function onScreen({ view, projection, width, height }, { p, radius }) {
  const transformed = (m, [x, y, z]) => [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
  const seen = transformed(view, p);
  const clip = transformed(projection, seen);
  return { x: ((clip[0] / clip[3] + 1) / 2) * width, y: ((1 - clip[1] / clip[3]) / 2) * height,
           radius: (radius * projection[5] * height) / (2 * clip[3]) };
}

const browser = await chromium.launch({ executablePath, ...LAUNCH });
try {
  const { page, errors } = await open(browser, url, { width: 840, height: 480 });
  const names = [...joints.keys()];
  await page.waitForFunction((all) => all.every((name) => window.hecaton?.scene.drawn(name)), names);
  for (const key of ["g", "b", "n", "w"]) await page.keyboard.press(key); // bodies only
  await page.evaluate(() => window.hecaton.scene.loading);

  const indexOf = (name) => cell.arms.findIndex((arm) => arm.name === name);
  const placedIn = (shot, name) => pointsOf(cell.arms[indexOf(name)], shot.arms[name]).map((point) => onScreen(shot, point));
  const isApart = ({ x, y }, bodies) => bodies.every((body) => Math.hypot(body.x - x, body.y - y) > 2 * body.radius);
  /** Where bodies of an arm were in a former shot, and none is now. */
  const leftBy = (name, now, former) => placedIn(former, name).filter((point) => isApart(point, placedIn(now, name)));

  // Six frames, and between each and the next an arm has left a place. A joint that turns far may move no body (the spindle of a SCARA).
  const shots = [];
  while (shots.length < 6) {
    const before = shots.at(-1);
    await page.waitForFunction((arms) => Object.entries(arms).every(([arm, { q }]) =>
      window.hecaton.scene.drawn(arm).q.some((value, k) => Math.abs(value - q[k]) > 0.1)), before?.arms ?? {});
    const shot = await shootFresh(page, names);
    if (before && !names.some((name) => leftBy(name, shot, before).length > 0)) continue;
    shots.push({ ...shot, hues: await huesOf(page) });
    console.log(`frame ${shots.length}`); // the test that started this waits for output
  }
  if (picture) await page.screenshot({ path: picture });

  // Where the links are.
  let worst = 0;
  for (const { arms } of shots) {
    for (const [name, { q, base, links }] of Object.entries(arms)) {
      const expected = linkPoses(joints.get(name), poseOf(base), cell.arms.find((arm) => arm.name === name).joints, q);
      let compared = 0;
      for (const [link, columns] of Object.entries(links)) {
        const pose = expected.get(link);
        if (!pose) continue;
        ++compared;
        for (let row = 0; row < 3; ++row) worst = Math.max(worst, Math.abs(columns[12 + row] - pose[row][3]));
      }
      assert.ok(compared > q.length, `${name}: ${compared} links were compared`);
    }
  }
  assert.ok(worst < 1e-4, `a link is ${worst} m from where it should be`);

  // What the picture has. Another body may hide a point; so most of the points must have the colour of their arm.
  const hueAt = (shot, { x, y }) => {
    const [column, row] = [Math.round(x), Math.round(y)];
    return column < 0 || row < 0 || column >= shot.width || row >= shot.height ? -1 : shot.hues[row * shot.width + column];
  };
  const share = (shot, points, index) => points.filter((point) => isHue(hueAt(shot, point), index)).length / points.length;
  let [leastThere, there, mostElsewhere, elsewhere, stray] = [1, 0, 0, 0, 0];
  for (const name of names) {
    const index = indexOf(name);
    const placed = shots.map((shot) => placedIn(shot, name));
    shots.forEach((shot, i) => {
      leastThere = Math.min(leastThere, share(shot, placed[i], index));
      there += share(shot, placed[i], index) / shots.length / names.length;
      // The same points of the other frames: were the arm drawn there, this picture would not have its colour here.
      shots.forEach((_, k) => {
        const former = placed[k].filter((point) => isApart(point, placed[i]));
        if (former.length === 0) return;
        mostElsewhere = Math.max(mostElsewhere, share(shot, former, index));
        elsewhere += former.length;
      });
      // No pixel of this colour is far from all its bodies.
      for (const pixel of pixelsOf(shot.hues, index)) {
        const [x, y] = [pixel % shot.width, Math.floor(pixel / shot.width)];
        if (placed[i].every((own) => Math.hypot(own.x - x, own.y - y) > 3 * own.radius + 20)) ++stray;
      }
    });
  }
  console.log(`${names.length} arms: largest error ${(worst * 1e3).toFixed(4)} mm; at the places of their bodies ` +
              `${(there * 100).toFixed(0)} % have their colour (at least ${(leastThere * 100).toFixed(0)} %), at ${elsewhere} former places at most ` +
              `${(mostElsewhere * 100).toFixed(0)} %; ${stray} stray pixels`);
  assert.ok(there > 0.75 && leastThere > 0.4, `only ${there} of the arms, and ${leastThere} of one, have their colour`);
  assert.ok(elsewhere > 4, "no arm has left its place");
  assert.ok(mostElsewhere < 0.3, `${mostElsewhere} of the places that an arm has left have its colour`);
  assert.equal(stray, 0, "pixels of an arm where it is not");
  assert.deepEqual(errors, []);
} finally {
  await browser.close();
}
