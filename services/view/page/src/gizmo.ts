/// An anchor in the scene that the pointer translates or rotates.
import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Pose } from "./protocol";

const LEAST_MOVE = 1e-4; // [m | rad] a drop nearer than this is none

export class Gizmo {
  readonly anchor = new THREE.Object3D();
  onBegin: () => void = () => {};
  /** The anchor moves under the pointer. */
  onMove: () => void = () => {};
  /** `moved`: the anchor is elsewhere than at the begin. */
  onDrop: (moved: boolean) => void = () => {};
  private readonly controls: TransformControls;
  private readonly start = { position: new THREE.Vector3(), quaternion: new THREE.Quaternion() };

  constructor(camera: THREE.Camera, canvas: HTMLElement, private readonly orbit: OrbitControls, scene: THREE.Scene) {
    this.controls = new TransformControls(camera, canvas);
    this.controls.setSize(0.7);
    this.controls.addEventListener("dragging-changed", (event) => {
      this.orbit.enabled = !event.value;
      if (!event.value) return;
      this.start.position.copy(this.anchor.position);
      this.start.quaternion.copy(this.anchor.quaternion);
      this.onBegin();
    });
    this.controls.addEventListener("objectChange", () => this.onMove());
    this.controls.addEventListener("mouseUp", () => {
      const { position, quaternion } = this.anchor;
      this.onDrop(position.distanceTo(this.start.position) >= LEAST_MOVE ||
                  quaternion.angleTo(this.start.quaternion) >= LEAST_MOVE);
    });
    scene.add(this.anchor, this.controls.getHelper());
  }

  show(): void {
    this.controls.attach(this.anchor);
  }
  hide(): void {
    this.cancel();
    this.controls.detach();
  }
  /** Ends a drag under way without a drop; the anchor returns. */
  cancel(): void {
    if (this.controls.dragging) this.controls.reset();
    this.controls.dragging = false;
    this.orbit.enabled = true;
  }
  get dragging(): boolean {
    return this.controls.dragging;
  }
  /** The pointer is on it. */
  get touched(): boolean {
    return this.controls.object !== undefined && (this.controls.dragging || this.controls.axis !== null);
  }
  setRotation(rotates: boolean): void {
    this.controls.setMode(rotates ? "rotate" : "translate");
  }

  get pose(): Pose {
    const { position: p, quaternion: q } = this.anchor;
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
  }
  setMatrix(matrix: THREE.Matrix4): void {
    matrix.decompose(this.anchor.position, this.anchor.quaternion, this.anchor.scale);
  }
  /** Where it is on the screen, within ±1. For tests. */
  place(camera: THREE.Camera): THREE.Vector3 {
    return this.anchor.getWorldPosition(new THREE.Vector3()).project(camera);
  }
}
