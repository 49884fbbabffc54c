import assert from "node:assert/strict";
import { test } from "node:test";
import * as THREE from "three";
import { ArmFigure } from "../src/figures";
import type { Arm, Link, LinkShape, Pose } from "../src/protocol";

const HERE: Pose = [0, 0, 0, 0, 0, 0, 1];
const LINKS = ["base", "upper", "fore", "hand"];

function arm(): Arm {
  const link = (name: string, i: number): Link => ({
    name, parent: i - 1, pose: HERE, axis: [0, 0, 1], kind: "fixed", joint: -1, multiplier: 1, offset: 0,
  });
  const shape = (_: string, i: number): LinkShape => ({
    kind: "sphere", radius: 0.1, pose: HERE, capsule: { pose: HERE, radius: 0.1, length: 0 }, link: i, planning: null,
  });
  return {
    name: "north", robot: "test", base: HERE, links: LINKS.map(link), shapes: LINKS.map(shape), joints: [], lower: [], upper: [],
    velocity: [], start: [], poses: [], tool_link: 3, tool: HERE, security_distance: 0.03, influence_distance: 0.1, method: "apf",
    urdf: "arm.urdf", note: "",
  };
}
const mesh = (): THREE.Object3D => new THREE.Group().add(new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshPhongMaterial()));

test("a link whose visual cannot be drawn keeps its collision shapes, a link without one does not", () => {
  const figure = new ArmFigure(arm(), 0, new THREE.Scene(), []);
  assert.deepEqual(figure.linksByShapes, LINKS);
  figure.addVisuals(new Map([
    ["base", [mesh()]],
    ["upper", [new THREE.Group()]], // its mesh could not be loaded
    ["fore", [mesh(), new THREE.Group().add(new THREE.Mesh())]], // one of two is a mesh without a point
  ]));
  assert.deepEqual(figure.linksByShapes, ["upper", "fore"]);
  assert.equal(figure.parts.length, 2 + 4); // the pointer finds them
});

test("an arm whose links all have visuals is drawn by them alone", () => {
  const figure = new ArmFigure(arm(), 0, new THREE.Scene(), []);
  figure.addVisuals(new Map(LINKS.map((name) => [name, [mesh()]])));
  assert.deepEqual(figure.linksByShapes, []);
});

test("an arm of which no mesh could be loaded is drawn by all its collision shapes", () => {
  const figure = new ArmFigure(arm(), 0, new THREE.Scene(), []);
  figure.addVisuals(new Map([["base", [new THREE.Group()]]]));
  assert.deepEqual(figure.linksByShapes, LINKS);
});
