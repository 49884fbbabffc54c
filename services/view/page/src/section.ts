/// A section through the bodies: nothing is drawn beyond a plane across x, y or z.
import * as THREE from "three";

export type Axis = "x" | "y" | "z";
const AXES: readonly Axis[] = ["x", "y", "z"];

export class Section {
  /** For the materials of all bodies; they keep this list, which is empty without a section. */
  readonly planes: THREE.Plane[] = [];
  private readonly plane = new THREE.Plane();
  axis: Axis | null = null;
  at = 0; // [m]
  private side: 1 | -1 = 1; // of the bodies that are not drawn

  /** `from`: the side of the viewer is not drawn. */
  set(axis: Axis | null, at: number, from: 1 | -1): void {
    this.axis = axis;
    this.side = from;
    this.planes.length = 0;
    if (axis !== null) this.planes.push(this.plane);
    this.move(at);
  }
  move(at: number): void {
    this.at = at;
    if (this.axis === null) return;
    this.plane.normal.set(0, 0, 0).setComponent(AXES.indexOf(this.axis), -this.side);
    this.plane.constant = this.side * at;
  }
  /** The point is beyond the plane. */
  hides(point: THREE.Vector3): boolean {
    return this.axis !== null && this.plane.distanceToPoint(point) < 0;
  }
}

/** The next one when the key is pressed again; after z none. */
export function nextAxis(axis: Axis | null): Axis | null {
  return axis === null ? "x" : AXES[AXES.indexOf(axis) + 1] ?? null;
}
