import assert from "node:assert/strict";
import { test } from "node:test";
import * as THREE from "three";
import { fitting } from "../src/framing";

const MARGIN = 0.1;
/** Half the size of the picture is 1. */
function inPicture(camera: THREE.PerspectiveCamera, points: THREE.Vector3[]): THREE.Vector3[] {
  camera.updateMatrixWorld();
  return points.map((point) => point.clone().project(camera));
}
const most = (places: THREE.Vector3[]): number => Math.max(...places.map(({ x, y }) => Math.max(Math.abs(x), Math.abs(y))));

test("Points fill the picture up to its margin, from any direction", () => {
  let seed = 7;
  const random = (): number => (seed = (seed * 48271) % 2147483647) / 2147483647;
  for (let round = 0; round < 200; ++round) {
    const camera = new THREE.PerspectiveCamera(45, 0.3 + 3 * random(), 0.02, 200);
    camera.up.set(0, 0, 1);
    const points = Array.from({ length: 12 }, () => new THREE.Vector3(5 * random(), 3 * random() - 1, 2 * random()));
    const direction = new THREE.Vector3(random() - 0.5, random() - 0.5, random()).normalize();
    const place = fitting(camera, direction, points, MARGIN);
    assert.ok(place);
    camera.position.copy(place.position);
    camera.lookAt(place.target);
    const places = inPicture(camera, points);
    assert.ok(places.every(({ z }) => z > -1 && z < 1));
    // Unless the nearest point is at the camera.
    const near = Math.min(...points.map((point) => place.position.clone().sub(point).dot(direction)));
    const [filled, wanted] = [most(places), 1 - MARGIN];
    assert.ok(near < 1.01 * camera.near ? filled < wanted : Math.abs(filled - wanted) < 1e-6, `round ${round}: ${filled}`);
    assert.ok(place.position.clone().sub(place.target).normalize().dot(direction) > 1 - 1e-9);
  }
});

test("Points on the axis of the view are in front of the camera", () => {
  const camera = new THREE.PerspectiveCamera(45, 1, 0.02, 200);
  camera.up.set(0, 0, 1);
  const place = fitting(camera, new THREE.Vector3(1, 0, 0), [new THREE.Vector3(0, 0, 0), new THREE.Vector3(2, 0, 0)], MARGIN);
  assert.ok(place && place.position.x > 2);
  assert.equal(fitting(camera, new THREE.Vector3(1, 0, 0), [], MARGIN), null);
});
