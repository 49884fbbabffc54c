/// Drags the ghost of an obstacle with a gizmo. The obstacle stays where the cell says that it is.
import * as THREE from "three";
import { ObstacleFigure } from "./figures";
import type { Gizmo } from "./gizmo";
import type { Obstacle, Pose } from "./protocol";

export class GhostDrag {
  /** Once for each drop. */
  onDrop: (obstacle: string, pose: Pose) => void = () => {};
  private figure: ObstacleFigure | null = null;
  private name: string | null = null;
  private free = false; // the ghost is away from its obstacle: it is dragged, or its order waits for the answer

  constructor(readonly gizmo: Gizmo) {
    gizmo.onBegin = () => {
      this.free = true;
      if (this.figure) this.figure.group.visible = true;
    };
    gizmo.onDrop = (moved) => {
      if (!this.free || this.name === null) return; // it was cancelled meanwhile
      if (moved) this.onDrop(this.name, gizmo.pose);
      else this.cancel();
    };
  }

  /** Null: no gizmo. A drag under way ends without an order. */
  choose(obstacle: Obstacle | null): void {
    if (this.name === (obstacle?.name ?? null) && obstacle !== null) return;
    this.cancel();
    this.name = obstacle?.name ?? null;
    this.gizmo.hide();
    if (this.figure) this.gizmo.anchor.remove(this.figure.group);
    this.figure = obstacle ? new ObstacleFigure({ ...obstacle, pose: [0, 0, 0, 0, 0, 0, 1] }) : null;
    if (!this.figure) return;
    this.figure.showAsGhost();
    this.figure.group.visible = false;
    this.gizmo.anchor.add(this.figure.group);
    this.gizmo.show();
  }
  get chosen(): string | null {
    return this.name;
  }

  /** Once a frame: the gizmo is at its obstacle unless the ghost is away. */
  follow(obstacle: THREE.Object3D | undefined): void {
    if (!this.free && obstacle) this.gizmo.setMatrix(obstacle.matrix);
  }

  /** No order waits: the ghost returns, unless it is dragged. */
  settle(): void {
    if (!this.gizmo.dragging) this.cancel();
  }
  /** The ghost returns without an order. */
  cancel(): void {
    this.gizmo.cancel();
    this.free = false;
    if (this.figure) this.figure.group.visible = false;
  }
}
