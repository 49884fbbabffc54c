/// Bodies of the scene: shapes as geometry, arms as trees of links, obstacles.
import * as THREE from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { freshness } from "./motion";
import type { Segment } from "./nearest";
import type { Arm, Capsule, LinkShape, Obstacle, Pose, Shape } from "./protocol";

const ROUND = 20; // segments of round shapes
const COARSE = 10; // of those that are shown as wires or halos

/** Poses a body; the matrices of bodies that do not move on their own are computed once. */
export function place(object: THREE.Object3D, pose: ArrayLike<number>): void {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
  object.updateMatrix();
}

function matrixOf(pose: Pose): THREE.Matrix4 {
  return new THREE.Matrix4().compose(
    new THREE.Vector3(pose[0], pose[1], pose[2]),
    new THREE.Quaternion(pose[3], pose[4], pose[5], pose[6]),
    new THREE.Vector3(1, 1, 1));
}

/** three's capsules and cylinders stand along y, those of the cell along z. */
function alongZ(geometry: THREE.BufferGeometry): THREE.BufferGeometry {
  return geometry.rotateX(Math.PI / 2);
}

function convexGeometry(vertices: readonly number[][], faces: readonly number[][]): THREE.BufferGeometry {
  const points: number[] = [];
  for (const face of faces) {
    for (let i = 2; i < face.length; ++i) {
      for (const corner of [face[0], face[i - 1], face[i]]) points.push(...vertices[corner]);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.computeVertexNormals();
  return geometry;
}

function formGeometry(shape: Shape): THREE.BufferGeometry {
  switch (shape.kind) {
    case "box": return new THREE.BoxGeometry(...shape.size);
    case "sphere": return new THREE.SphereGeometry(shape.radius, ROUND, ROUND / 2);
    case "capsule": return alongZ(new THREE.CapsuleGeometry(shape.radius, shape.length, ROUND / 4, ROUND));
    case "cylinder": return alongZ(new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, ROUND));
    case "convex": return convexGeometry(shape.vertices, shape.faces);
    case "points": return new THREE.BufferGeometry(); // no surface: ObstacleFigure draws points
  }
}

/** In the frame of the body, without index and texture coordinates, so that geometries can be merged. */
function plain(geometry: THREE.BufferGeometry, pose: Pose): THREE.BufferGeometry {
  const flat = geometry.index ? geometry.toNonIndexed() : geometry;
  for (const name of Object.keys(flat.attributes)) {
    if (name !== "position" && name !== "normal") flat.deleteAttribute(name);
  }
  return flat.applyMatrix4(matrixOf(pose));
}

export const shapeGeometry = (shape: Shape): THREE.BufferGeometry => plain(formGeometry(shape), shape.pose);

export function capsuleGeometry(capsule: Capsule, margin = 0): THREE.BufferGeometry {
  const geometry = new THREE.CapsuleGeometry(capsule.radius + margin, capsule.length, COARSE / 2, COARSE);
  return plain(alongZ(geometry), capsule.pose);
}

/** One geometry a body is one draw call. */
function merged(geometries: THREE.BufferGeometry[]): THREE.BufferGeometry | null {
  return geometries.length ? mergeGeometries(geometries) : null;
}

/** The axis of a capsule in W. `out` keeps its arrays. */
function segmentOf(capsule: Capsule, body: THREE.Matrix4): Segment {
  const pose = matrixOf(capsule.pose).premultiply(body);
  const end = (z: number): [number, number, number] => {
    const point = new THREE.Vector3(0, 0, z).applyMatrix4(pose);
    return [point.x, point.y, point.z];
  };
  return { a: end(-capsule.length / 2), b: end(capsule.length / 2), radius: capsule.radius };
}

/** A muted colour for each arm: they differ, and a state's colour still stands out. */
export function armColour(index: number): THREE.Color {
  return new THREE.Color().setHSL(((index * 0.381966) + 0.58) % 1, 0.32, 0.58);
}

/** It has points, lines or faces. What could not be loaded has none. */
function isDrawable(object: THREE.Object3D): boolean {
  let drawable = false;
  object.traverse((part) => {
    if (part instanceof THREE.Mesh || part instanceof THREE.Points || part instanceof THREE.Line) {
      drawable ||= (part.geometry as THREE.BufferGeometry).getAttribute("position")?.count > 0;
    }
  });
  return drawable;
}

/** Of a box around each drawn mesh or cloud of points, which has the axes of its body, in W. */
export function cornersOf(object: THREE.Object3D): THREE.Vector3[] {
  const corners: THREE.Vector3[] = [];
  object.traverseVisible((part) => {
    if (!(part instanceof THREE.Mesh || part instanceof THREE.Points)) return;
    const geometry = part.geometry as THREE.BufferGeometry;
    if (geometry.boundingBox === null) geometry.computeBoundingBox();
    const box = geometry.boundingBox;
    if (box === null || box.isEmpty()) return;
    for (const x of [box.min.x, box.max.x]) {
      for (const y of [box.min.y, box.max.y]) {
        for (const z of [box.min.z, box.max.z]) corners.push(new THREE.Vector3(x, y, z).applyMatrix4(part.matrixWorld));
      }
    }
  });
  return corners;
}

/** The links of an arm as a tree of three's objects, in any configuration. */
class LinkTree {
  readonly root = new THREE.Group();
  readonly links: THREE.Group[] = [];
  private readonly zeros: THREE.Quaternion[] = [];
  private readonly origins: THREE.Vector3[] = [];
  private readonly axes: THREE.Vector3[] = [];
  private readonly turn = new THREE.Quaternion();

  constructor(private readonly arm: Arm) {
    this.root.matrixAutoUpdate = false;
    place(this.root, arm.base);
    for (const link of arm.links) {
      const group = new THREE.Group();
      group.name = link.name;
      group.matrixAutoUpdate = false;
      place(group, link.pose);
      this.zeros.push(group.quaternion.clone());
      this.origins.push(group.position.clone());
      this.axes.push(new THREE.Vector3(...link.axis));
      (link.parent < 0 ? this.root : this.links[link.parent]).add(group);
      this.links.push(group);
    }
  }

  move(q: readonly number[]): void {
    this.arm.links.forEach((link, i) => {
      const value = link.multiplier * q[link.joint] + link.offset;
      if (link.joint < 0 || !Number.isFinite(value)) return;
      const group = this.links[i];
      if (link.kind === "prismatic") {
        group.position.copy(this.axes[i]).multiplyScalar(value).applyQuaternion(this.zeros[i]).add(this.origins[i]);
      } else {
        group.quaternion.copy(this.zeros[i]).multiply(this.turn.setFromAxisAngle(this.axes[i], value));
      }
      group.updateMatrix();
    });
  }
}

/** What of an arm is shown. */
export interface Layers {
  goals: boolean;
  halos: boolean;
  planning: boolean;
}

export class ArmFigure {
  readonly tree: LinkTree;
  readonly colour: THREE.Color;
  readonly q: number[] = []; // as it is drawn
  private readonly material: THREE.MeshLambertMaterial;
  private readonly bodies = new Map<string, THREE.Mesh>(); // its collision shapes, by the names of their links
  private readonly visuals: THREE.Object3D[] = [];
  private readonly visualMaterials: { material: THREE.Material; opacity: number }[] = [];
  private readonly ghost: LinkTree;
  private draft: { tree: LinkTree; material: THREE.MeshLambertMaterial } | null = null;
  private halos: THREE.Mesh[] | null = null;
  private wires: THREE.Mesh[] | null = null;
  private readonly geometries = new Map<number, THREE.BufferGeometry>();
  private opacity = 1;

  /** `section`: planes beyond which nothing of its bodies is drawn; the list may change. */
  constructor(readonly arm: Arm, index: number, private readonly scene: THREE.Object3D,
              private readonly section: THREE.Plane[]) {
    this.colour = armColour(index);
    this.material = new THREE.MeshLambertMaterial({
      color: this.colour, side: THREE.DoubleSide, clippingPlanes: section, // both sides: a cut body is hollow
    });
    this.tree = new LinkTree(arm);
    this.ghost = new LinkTree(arm);
    const ghostMaterial = new THREE.MeshLambertMaterial({
      color: this.colour, transparent: true, opacity: 0.22, depthWrite: false, clippingPlanes: section,
    });
    for (const [link, shapes] of this.shapesByLink()) {
      const geometry = merged(shapes.map(shapeGeometry));
      if (!geometry) continue;
      this.geometries.set(link, geometry);
      this.bodies.set(arm.links[link].name, this.attach(this.tree, link, geometry, this.material));
      this.attach(this.ghost, link, geometry, ghostMaterial);
    }
    this.ghost.root.visible = false;
    scene.add(this.tree.root, this.ghost.root);
    this.move(arm.start);
  }

  private shapesByLink(): Map<number, LinkShape[]> {
    const byLink = new Map<number, LinkShape[]>();
    for (const shape of this.arm.shapes) byLink.set(shape.link, [...(byLink.get(shape.link) ?? []), shape]);
    return byLink;
  }

  private attach(tree: LinkTree, link: number, geometry: THREE.BufferGeometry, material: THREE.Material): THREE.Mesh {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.matrixAutoUpdate = false;
    tree.links[link].add(mesh);
    return mesh;
  }

  move(q: readonly number[]): void {
    this.q.splice(0, this.q.length, ...q);
    this.tree.move(q);
  }

  /** `age`: of the newest state [ms]; `lost`: no supervisor hears the arm. */
  show(age: number, lost: boolean): void {
    const opacity = lost ? 0.2 : freshness(age);
    this.material.wireframe = lost;
    if (Math.abs(opacity - this.opacity) < 0.01) return;
    this.opacity = opacity;
    this.fade(this.material, opacity, 1);
    for (const { material, opacity: full } of this.visualMaterials) this.fade(material, opacity, full);
  }
  get shownOpacity(): number {
    return this.opacity;
  }

  private fade(material: THREE.Material, opacity: number, full: number): void {
    material.opacity = opacity * full;
    const transparent = material.opacity < 1;
    if (material.transparent !== transparent) material.needsUpdate = true; // another program of the graphics processor
    material.transparent = transparent;
  }

  showGoal(q: readonly number[] | null): void {
    this.ghost.root.visible = q !== null;
    if (q) this.ghost.move(q);
  }

  /** The ghost of a goal that is dragged; null: none. */
  showDraft(q: readonly number[] | null, colour: THREE.ColorRepresentation): void {
    if (!this.draft) {
      if (q === null) return;
      this.draft = this.makeDraft();
    }
    this.draft.tree.root.visible = q !== null;
    this.draft.material.color.set(colour);
    if (q) this.draft.tree.move(q);
  }
  private makeDraft(): { tree: LinkTree; material: THREE.MeshLambertMaterial } {
    const tree = new LinkTree(this.arm);
    const material = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.55, depthWrite: false });
    for (const [link, geometry] of this.geometries) this.attach(tree, link, geometry, material);
    this.scene.add(tree.root);
    return { tree, material };
  }
  /** Colour of that ghost, "e5605e"; null: it is not shown. For tests. */
  get draftColour(): string | null {
    return this.draft?.tree.root.visible ? this.draft.material.color.getHexString() : null;
  }

  showLayers(layers: Layers): void {
    if (layers.halos && !this.halos) this.halos = this.makeHalos();
    if (layers.planning && !this.wires) this.wires = this.makeWires();
    this.halos?.forEach((mesh) => (mesh.visible = layers.halos));
    this.wires?.forEach((mesh) => (mesh.visible = layers.planning));
  }

  /** Shapes that are larger by the security distance. */
  private makeHalos(): THREE.Mesh[] {
    const material = new THREE.MeshBasicMaterial({
      color: 0xe8b04a, transparent: true, opacity: 0.1, depthWrite: false, side: THREE.FrontSide, clippingPlanes: this.section,
    });
    const meshes: THREE.Mesh[] = [];
    for (const [link, shapes] of this.shapesByLink()) {
      const geometry = merged(shapes.map((shape) =>
        capsuleGeometry(shape.planning ?? shape.capsule, this.arm.security_distance)));
      if (geometry) meshes.push(this.attach(this.tree, link, geometry, material));
    }
    return meshes;
  }

  /** The shapes with which planners measure distances. */
  private makeWires(): THREE.Mesh[] {
    const material = new THREE.MeshBasicMaterial({
      color: this.colour, wireframe: true, transparent: true, opacity: 0.45, depthWrite: false, clippingPlanes: this.section,
    });
    const meshes: THREE.Mesh[] = [];
    for (const [link, shapes] of this.shapesByLink()) {
      const geometry = merged(shapes.map((shape) =>
        shape.planning ? capsuleGeometry(shape.planning) : shapeGeometry(shape)));
      if (geometry) meshes.push(this.attach(this.tree, link, geometry, material));
    }
    return meshes;
  }

  /**
   * Draws the visual elements of links from the URDF. They replace the collision shapes, but for links whose mesh could not be
   * loaded. Shapes of links without visual elements would look like a part of the robot.
   */
  addVisuals(byLink: Map<string, THREE.Object3D[]>): void {
    const skinned = [...byLink.values()].some((visuals) => visuals.some(isDrawable));
    for (const group of this.tree.links) {
      const visuals = byLink.get(group.name) ?? [];
      const body = this.bodies.get(group.name);
      if (body && skinned) body.visible = visuals.length > 0 && !visuals.every(isDrawable);
      for (const visual of visuals) {
        group.add(visual);
        this.visuals.push(visual);
        visual.traverse((part) => {
          if (!(part instanceof THREE.Mesh)) return;
          const materials: THREE.Material[] = Array.isArray(part.material) ? part.material : [part.material];
          for (const material of materials) {
            material.side = THREE.DoubleSide;
            material.clippingPlanes = this.section;
            this.visualMaterials.push({ material, opacity: material.opacity });
          }
        });
      }
    }
  }
  /** The links that are drawn by their collision shapes. For tests. */
  get linksByShapes(): string[] {
    return [...this.bodies].filter(([, mesh]) => mesh.visible).map(([link]) => link);
  }

  /** Capsules of the links of this name, as they are in W now. */
  segments(name: string): Segment[] {
    const index = this.arm.links.findIndex((link) => link.name === name);
    return this.arm.shapes.filter((shape) => shape.link === index).map((shape) =>
      segmentOf(shape.planning ?? shape.capsule, this.tree.links[index].matrixWorld));
  }

  private readonly toolOffset = new THREE.Vector3();
  toolPosition(out: THREE.Vector3): THREE.Vector3 {
    const tool = this.toolOffset.set(this.arm.tool[0], this.arm.tool[1], this.arm.tool[2]);
    return out.copy(tool).applyMatrix4(this.tree.links[this.arm.tool_link].matrixWorld);
  }
  /** The frame of the tool in W. */
  toolMatrix(): THREE.Matrix4 {
    return matrixOf(this.arm.tool).premultiply(this.tree.links[this.arm.tool_link].matrixWorld);
  }
  /** Of all that is drawn of it, and of its goal. */
  corners(): THREE.Vector3[] {
    return [this.tree.root, this.ghost.root].flatMap(cornersOf);
  }
  /** For hits of the pointer. */
  get parts(): THREE.Object3D[] {
    return [...[...this.bodies.values()].filter((mesh) => mesh.visible), ...this.visuals];
  }
  remove(): void {
    this.scene.remove(this.tree.root, this.ghost.root);
    if (this.draft) this.scene.remove(this.draft.tree.root);
    this.geometries.forEach((geometry) => geometry.dispose());
  }
}

export class ObstacleFigure {
  readonly group = new THREE.Group();
  private readonly material: THREE.MeshLambertMaterial;
  private readonly clouds: THREE.PointsMaterial[] = [];

  constructor(readonly obstacle: Obstacle, section: THREE.Plane[] = []) {
    this.material = new THREE.MeshLambertMaterial({
      color: 0x9aa0a6, side: THREE.DoubleSide, clippingPlanes: section,
    });
    this.group.matrixAutoUpdate = false;
    place(this.group, obstacle.pose);
    for (const shape of obstacle.shapes) {
      if (shape.kind !== "points") continue;
      // A square for each ball, of its diameter.
      const material = new THREE.PointsMaterial({ color: 0x9aa0a6, size: 2 * shape.radius, clippingPlanes: section });
      const points = new THREE.BufferGeometry();
      points.setAttribute("position", new THREE.Float32BufferAttribute(shape.points, 3));
      const cloud = new THREE.Points(points.applyMatrix4(matrixOf(shape.pose)), material);
      cloud.matrixAutoUpdate = false;
      this.clouds.push(material);
      this.group.add(cloud);
    }
    const geometry = merged(obstacle.shapes.filter((shape) => shape.kind !== "points").map(shapeGeometry));
    if (!geometry) return;
    const mesh = new THREE.Mesh(geometry, this.material);
    mesh.matrixAutoUpdate = false;
    this.group.add(mesh);
  }

  show(age: number): void {
    const opacity = freshness(age);
    const transparent = opacity < 1;
    if (this.material.transparent !== transparent) this.material.needsUpdate = true;
    for (const material of [this.material, ...this.clouds]) {
      material.opacity = opacity;
      material.transparent = transparent;
    }
  }
  showAsGhost(): void {
    for (const material of [this.material, ...this.clouds]) {
      material.color.set(0x7fa8d9);
      material.opacity = 0.5;
      material.transparent = true;
      material.depthWrite = false;
    }
  }
  segments(): Segment[] {
    return this.obstacle.shapes.map((shape) => segmentOf(shape.capsule, this.group.matrixWorld));
  }
}

/** From a point to another, for the pair that bounds a motion. */
export class PairLine {
  readonly line: THREE.Line;
  private readonly positions: THREE.BufferAttribute;

  constructor(colour: THREE.ColorRepresentation) {
    const geometry = new THREE.BufferGeometry();
    this.positions = new THREE.Float32BufferAttribute(new Float32Array(6), 3);
    geometry.setAttribute("position", this.positions);
    this.line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour, depthTest: false }));
    this.line.frustumCulled = false;
    this.line.renderOrder = 10;
  }
  set(from: ArrayLike<number>, to: ArrayLike<number>): void {
    this.positions.setXYZ(0, from[0], from[1], from[2]);
    this.positions.setXYZ(1, to[0], to[1], to[2]);
    this.positions.needsUpdate = true;
  }
  /** For tests. */
  get ends(): number[][] {
    return [0, 1].map((i) => [this.positions.getX(i), this.positions.getY(i), this.positions.getZ(i)]);
  }
}

/** A text that faces the viewer and keeps its size on the screen. */
export class Label {
  readonly sprite: THREE.Sprite;
  private readonly canvas = document.createElement("canvas");
  private readonly texture = new THREE.CanvasTexture(this.canvas);
  private text = "";
  private style = "";

  /** What it says. For tests. */
  get shown(): string {
    return this.text;
  }

  constructor() {
    this.texture.minFilter = THREE.LinearFilter;
    this.texture.colorSpace = THREE.SRGBColorSpace;
    this.sprite = new THREE.Sprite(new THREE.SpriteMaterial({
      map: this.texture, depthTest: false, transparent: true, sizeAttenuation: false,
    }));
    this.sprite.renderOrder = 20;
    this.sprite.center.set(0.5, -0.25);
  }

  set(text: string, colour: string, background: string): void {
    const style = colour + background;
    if (text === this.text && style === this.style) return;
    this.text = text;
    this.style = style;
    const pixels = 26;
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const font = `600 ${pixels}px system-ui, sans-serif`;
    context.font = font;
    this.canvas.width = Math.ceil(context.measureText(text).width) + 20;
    this.canvas.height = pixels + 16;
    context.font = font;
    context.fillStyle = background;
    context.beginPath();
    context.roundRect(0, 0, this.canvas.width, this.canvas.height, 8);
    context.fill();
    context.fillStyle = colour;
    context.textBaseline = "middle";
    context.fillText(text, 10, this.canvas.height / 2 + 1);
    this.texture.dispose(); // its size may have changed
    this.texture.needsUpdate = true;
    const height = 0.032;
    this.sprite.scale.set(height * (this.canvas.width / this.canvas.height), height, 1);
  }
}

