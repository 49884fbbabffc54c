// Forward kinematics of a URDF, written for tests and apart from the page's: 4 × 4 matrices in rows.
import { readFileSync } from "node:fs";

export const product = (a, b) => a.map((row) => b[0].map((_, j) => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
export const shift = ([x, y, z]) => [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]];
const turn = ([x, y, z], angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const t = 1 - c;
  return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0], [t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0],
          [t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0], [0, 0, 0, 1]];
};
const posed = (xyz, [r, p, y]) =>
  [shift(xyz), turn([0, 0, 1], y), turn([0, 1, 0], p), turn([1, 0, 0], r)].reduce(product);
/** [x, y, z, qx, qy, qz, qw] */
export const poseOf = ([px, py, pz, x, y, z, w]) => product(shift([px, py, pz]),
  [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0],
   [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0],
   [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0], [0, 0, 0, 1]]);
export const moved = (matrix, [x, y, z]) => matrix.slice(0, 3).map((row) => row[0] * x + row[1] * y + row[2] * z + row[3]);

const numbers = (text, tag, attribute, otherwise) => {
  const found = new RegExp(`<${tag}[^>]*\\b${attribute}="([^"]*)"`).exec(text);
  return found ? found[1].trim().split(/\s+/).map(Number) : otherwise;
};

/** The joints of a URDF, parents before children. */
export function jointsOf(file) {
  const text = readFileSync(file, "utf8").replace(/<!--[\s\S]*?-->/g, "");
  const left = [...text.matchAll(/<joint\s[^>]*name="([^"]+)"[\s\S]*?<\/joint>/g)].map(([joint, name]) => ({
    name,
    type: /<joint[^>]*\btype="(\w+)"/.exec(joint)[1],
    parent: /<parent\s+link="([^"]+)"/.exec(joint)[1],
    child: /<child\s+link="([^"]+)"/.exec(joint)[1],
    origin: posed(numbers(joint, "origin", "xyz", [0, 0, 0]), numbers(joint, "origin", "rpy", [0, 0, 0])),
    axis: numbers(joint, "axis", "xyz", [1, 0, 0]),
  }));
  const children = new Set(left.map(({ child }) => child));
  const known = new Set(left.map(({ parent }) => parent).filter((link) => !children.has(link)));
  const sorted = [];
  while (left.length) {
    const next = left.findIndex(({ parent }) => known.has(parent));
    known.add(left[next].child);
    sorted.push(...left.splice(next, 1));
  }
  return sorted;
}

/** The pose of each link that is fixed to the base or moved by the joints `names`. */
export function linkPoses(joints, base, names, q) {
  const poses = new Map([[joints[0].parent, base]]);
  for (const { name, type, parent, child, origin, axis } of joints) {
    const from = poses.get(parent);
    const value = q[names.indexOf(name)];
    if (!from || (type !== "fixed" && value === undefined)) continue; // a finger
    const motion = type === "fixed" ? shift([0, 0, 0]) :
      type === "prismatic" ? shift(axis.map((x) => x * value)) : turn(axis, value);
    poses.set(child, [from, origin, motion].reduce(product));
  }
  return poses;
}
