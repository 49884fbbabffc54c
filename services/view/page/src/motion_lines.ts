/// Where an arm is going: the planned way of its tool as a line, and its newest rollout as dots.
import * as THREE from "three";
import type { Motion, Vector } from "./protocol";

const MOST_POINTS = 128; // of a line; the server sends fewer

export class MotionLines {
  readonly way: THREE.Line;
  readonly foreseen: THREE.Points;
  private motion: Motion = { way: [], foreseen: [] };

  /** `armColour`: the lines have a stronger one, to be seen on light and dark. */
  constructor(armColour: THREE.Color) {
    const colour = armColour.clone().offsetHSL(0, 0.35, -0.15);
    this.way = new THREE.Line(MotionLines.geometry(), new THREE.LineBasicMaterial({ color: colour }));
    this.foreseen = new THREE.Points(MotionLines.geometry(), new THREE.PointsMaterial({
      color: colour, size: 5, sizeAttenuation: false, transparent: true, opacity: 0.9,
    }));
    for (const drawn of [this.way, this.foreseen]) {
      drawn.frustumCulled = false;
      drawn.visible = false;
    }
  }

  set(motion: Motion): void {
    this.motion = motion;
    MotionLines.write(this.way.geometry, motion.way);
    MotionLines.write(this.foreseen.geometry, motion.foreseen);
  }
  show(shown: boolean): void {
    this.way.visible = shown && this.motion.way.length > 1;
    this.foreseen.visible = shown && this.motion.foreseen.length > 1;
  }
  /** The points that are drawn. For tests. */
  get drawn(): Motion {
    return { way: this.way.visible ? this.motion.way : [], foreseen: this.foreseen.visible ? this.motion.foreseen : [] };
  }

  private static geometry(): THREE.BufferGeometry {
    return new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(MOST_POINTS * 3, 3));
  }
  private static write(geometry: THREE.BufferGeometry, points: readonly Vector[]): void {
    const count = Math.min(points.length, MOST_POINTS);
    const positions = geometry.getAttribute("position") as THREE.BufferAttribute;
    for (let i = 0; i < count; ++i) positions.setXYZ(i, points[i][0], points[i][1], points[i][2]);
    positions.needsUpdate = true;
    geometry.setDrawRange(0, count);
  }
}
