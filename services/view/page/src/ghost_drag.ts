/// Drags the ghost of an obstacle with a gizmo. The obstacle stays where the cell says that it is.
import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import { ObstacleFigure } from "./figures";
import type { Obstacle, Pose } from "./protocol";

const LEAST_MOVE = 1e-4; // [m | rad] a drop nearer than this is no order

export class GhostDrag {
  /** Once for each drop. */
  onDrop: (obstacle: string, pose: Pose) => void = () => {};
  private readonly gizmo: TransformControls;
  private readonly anchor = new THREE.Object3D();
  private figure: ObstacleFigure | null = null;
  private name: string | null = null;
  private free = false; // the ghost is away from its obstacle: it is dragged, or its order waits for the answer

  constructor(camera: THREE.Camera, canvas: HTMLElement, private readonly orbit: OrbitControls, scene: THREE.Scene) {
    this.gizmo = new TransformControls(camera, canvas);
    this.gizmo.setSize(0.7);
    this.gizmo.addEventListener("dragging-changed", (event) => {
      this.orbit.enabled = !event.value;
      if (event.value) this.begin();
    });
    this.gizmo.addEventListener("mouseUp", () => this.drop());
    scene.add(this.anchor, this.gizmo.getHelper());
  }

  /** Null: no gizmo. A drag under way ends without an order. */
  choose(obstacle: Obstacle | null): void {
    if (this.name === (obstacle?.name ?? null) && obstacle !== null) return;
    this.cancel();
    this.name = obstacle?.name ?? null;
    this.gizmo.detach();
    if (this.figure) this.anchor.remove(this.figure.group);
    this.figure = obstacle ? new ObstacleFigure({ ...obstacle, pose: [0, 0, 0, 0, 0, 0, 1] }) : null;
    if (!this.figure) return;
    this.figure.showAsGhost();
    this.figure.group.visible = false;
    this.anchor.add(this.figure.group);
    this.gizmo.attach(this.anchor);
  }
  get chosen(): string | null {
    return this.name;
  }
  /** The pointer is on the gizmo. */
  get busy(): boolean {
    return this.name !== null && (this.gizmo.dragging || this.gizmo.axis !== null);
  }
  setRotation(rotates: boolean): void {
    this.gizmo.setMode(rotates ? "rotate" : "translate");
  }

  /** Once a frame: the gizmo is at its obstacle unless the ghost is away. */
  follow(obstacle: THREE.Object3D | undefined): void {
    if (this.free || !obstacle) return;
    obstacle.matrix.decompose(this.anchor.position, this.anchor.quaternion, this.anchor.scale);
  }

  /** No order waits: the ghost returns, unless it is dragged. */
  settle(): void {
    if (!this.gizmo.dragging) this.cancel();
  }
  /** The ghost returns without an order. */
  cancel(): void {
    if (this.gizmo.dragging) this.gizmo.reset();
    this.gizmo.dragging = false;
    this.orbit.enabled = true;
    this.free = false;
    if (this.figure) this.figure.group.visible = false;
  }

  /** Where the gizmo is on the screen, within ±1. For tests. */
  place(camera: THREE.Camera): THREE.Vector3 {
    return this.anchor.getWorldPosition(new THREE.Vector3()).project(camera);
  }

  private readonly start = { position: new THREE.Vector3(), quaternion: new THREE.Quaternion() };
  private begin(): void {
    this.free = true;
    this.start.position.copy(this.anchor.position);
    this.start.quaternion.copy(this.anchor.quaternion);
    if (this.figure) this.figure.group.visible = true;
  }
  private drop(): void {
    if (!this.free || this.name === null) return; // it was cancelled meanwhile
    const { position: p, quaternion: q } = this.anchor;
    if (p.distanceTo(this.start.position) < LEAST_MOVE && q.angleTo(this.start.quaternion) < LEAST_MOVE) {
      this.cancel();
      return;
    }
    this.onDrop(this.name, [p.x, p.y, p.z, q.x, q.y, q.z, q.w]);
  }
}
