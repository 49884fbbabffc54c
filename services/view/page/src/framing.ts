/// Where a camera stands so that points fill its picture.
import * as THREE from "three";

/**
 * The nearest place of a perspective camera from which all points are in the picture, at least the part `margin` of its
 * half size away from each edge. `direction`: from the points to the camera. `target`: in the middle of the picture, at
 * the mean depth of the points. Null: there are no points.
 */
export function fitting(camera: THREE.PerspectiveCamera, direction: THREE.Vector3, points: readonly THREE.Vector3[],
                        margin: number): { position: THREE.Vector3; target: THREE.Vector3 } | null {
  if (points.length === 0) return null;
  const [right, up, back] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  new THREE.Matrix4().lookAt(direction, new THREE.Vector3(), camera.up).extractBasis(right, up, back);
  const high = Math.tan((camera.fov * Math.PI) / 360) * (1 - margin);
  const [across, along] = [span(points, right, back, high * camera.aspect), span(points, up, back, high)];
  const depths = points.map((point) => point.dot(back));
  const depth = Math.max(across.depth, along.depth, Math.max(...depths) + camera.near);
  const at = (z: number): THREE.Vector3 =>
    right.clone().multiplyScalar(across.middle).addScaledVector(up, along.middle).addScaledVector(back, z);
  return { position: at(depth), target: at(depths.reduce((sum, z) => sum + z, 0) / points.length) };
}

/**
 * Along one axis of the picture. A point at x, in the depth z, is in the picture of a camera at c, in the depth d, if
 * |x - c| <= slope * (d - z). So c is between max(x + slope * z) - slope * d and min(x - slope * z) + slope * d.
 */
function span(points: readonly THREE.Vector3[], axis: THREE.Vector3, back: THREE.Vector3,
              slope: number): { depth: number; middle: number } {
  let [low, high] = [Infinity, -Infinity];
  for (const point of points) {
    const [x, z] = [point.dot(axis), slope * point.dot(back)];
    low = Math.min(low, x - z);
    high = Math.max(high, x + z);
  }
  return { depth: (high - low) / (2 * slope), middle: (high + low) / 2 };
}
