/// The scene: cameras, bodies, and what is drawn between them.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { ArmFigure, armColour, cornersOf, Label, ObstacleFigure, PairLine, place } from "./figures";
import { fitting } from "./framing";
import { GhostDrag } from "./ghost_drag";
import { Gizmo } from "./gizmo";
import { PoseTrack, ServerClock, SHOWN_DELAY, StateNumbers, Track } from "./motion";
import { MotionLines } from "./motion_lines";
import { nearestOf, type Segment } from "./nearest";
import type { ArmStatus, CellMessage, FrameMessage, Motion, MotionsMessage, ObstaclesMessage, Pose, StatusMessage } from "./protocol";
import { type Axis, Section } from "./section";
import { loadVisuals } from "./visuals";
import { distanceText, MARKS, stateOf } from "./words";

export interface Toggles {
  goals: boolean;
  ways: boolean; // planned ways and rollouts
  halos: boolean;
  planning: boolean;
  binding: boolean;
  names: boolean;
  trails: boolean;
}

export type Preset = "free" | "left" | "top" | "front" | "side";

const PRESETS: Record<Preset, THREE.Vector3> = {
  free: new THREE.Vector3(0.9, -1.1, 0.75),
  left: new THREE.Vector3(0.9, 1.1, 0.75),
  top: new THREE.Vector3(0, -0.001, 1),
  front: new THREE.Vector3(1, 0, 0.12),
  side: new THREE.Vector3(0, -1, 0.12),
};
const TRAIL_POINTS = 90; // three seconds
const PICTURE_MARGIN = 0.06; // of half the size of a picture
const LARGEST = 2.5; // an obstacle that is larger than so many times all arms together is no part of a picture

/** How the ghost of a dragged goal looks. */
export type DraftLook = "free" | "near" | "blocked";
const DRAFT_COLOURS: Record<DraftLook, number> = { free: 0x7fa8d9, near: 0xe8b04a, blocked: 0xe5605e };

interface ArmEntry {
  figure: ArmFigure;
  track: Track;
  age: number; // of the newest state in the last frame
  status: ArmStatus | null;
  pair: PairLine;
  pairLabel: Label;
  name: Label;
  trail: THREE.Line;
  trailCount: number;
  motion: MotionLines;
  numbers: StateNumbers;
  visible: boolean; // by the filter
}

/** What a frame took in the scripts of the page, without the graphics processor [ms]. */
export interface FrameStatistics {
  framesPerSecond: number;
  scriptMean: number;
  scriptMedian: number;
  scriptMost: number;
  frames: number;
}

/** Between two frames that are drawn by software [ms]: planners of the same host need the processor more. */
const SOFTWARE_PERIOD = 100;

/** False where the browser draws by software (a virtual machine, a remote desktop): smooth edges would take four times as long. */
function hasGraphicsProcessor(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (context === null) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name = String(context.getParameter(names === null ? context.RENDERER : names.UNMASKED_RENDERER_WEBGL));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|basic render/i.test(name);
}

export class CellScene {
  readonly clock = new ServerClock();
  onSelect: (arm: string | null) => void = () => {};
  onObstacle: (obstacle: string) => void = () => {};
  readonly ghost: GhostDrag;
  /** The tool of the arm whose goal is dragged has moved. */
  onTool: (pose: Pose) => void = () => {};
  private readonly tool: Gizmo; // at the tool of that arm
  private dragged: string | null = null; // that arm
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly overlay = new THREE.Group(); // names and lines, placed after the bodies
  private readonly camera = new THREE.PerspectiveCamera(45, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private grid = new THREE.GridHelper(1, 1);
  private readonly arms = new Map<string, ArmEntry>();
  private readonly obstacles = new Map<string, { figure: ObstacleFigure; track: PoseTrack }>();
  private toggles: Toggles = {
    goals: true, ways: true, halos: false, planning: false, binding: true, names: true, trails: false,
  };
  readonly section = new Section();
  private selected: string | null = null;
  private followed: string | null = null;
  private floor = 0;
  private dark = true;
  private readonly script: number[] = [];
  private readonly times: number[] = [];
  private readonly scratch: number[] = [];
  private readonly vector = new THREE.Vector3();
  private readonly vector2 = new THREE.Vector3();
  private lastTrail = 0;
  private rate = 1; // of the time that the frames show
  private leaps = 0; // of that time
  private obstacleAge = Number.POSITIVE_INFINITY; // in the last frame
  /** The meshes of all arms are there, or cannot be loaded. */
  loading: Promise<unknown> = Promise.resolve();

  constructor(private readonly host: HTMLElement, private readonly forPictures = false) {
    // A picture is taken from the canvas some time after it was drawn. Pictures are smooth wherever they are drawn.
    const fast = hasGraphicsProcessor();
    this.renderer = new THREE.WebGLRenderer({ antialias: fast || forPictures, preserveDrawingBuffer: forPictures });
    this.renderer.localClippingEnabled = true; // of the section
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, fast || forPictures ? 2 : 1));
    host.append(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.15;
    const gizmo = (): Gizmo => new Gizmo(this.camera, this.renderer.domElement, this.controls, this.scene);
    this.ghost = new GhostDrag(gizmo());
    this.tool = gizmo();
    this.tool.onMove = () => this.onTool(this.tool.pose);
    this.scene.matrixWorldAutoUpdate = false; // once a frame, before the lines between bodies are drawn
    const sky = new THREE.HemisphereLight(0xffffff, 0x555a60, 1.9);
    sky.position.set(0, 0, 1);
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(2, -3, 5);
    this.scene.add(sky, sun, this.grid, this.overlay);
    new ResizeObserver(() => this.resize()).observe(host);
    this.listenForSelection();
    this.resize();
    const period = fast ? 0 : SOFTWARE_PERIOD;
    let next = 0;
    this.renderer.setAnimationLoop((now: number) => {
      if (now < next) return;
      next = now + period;
      this.draw();
    });
  }

  // --- messages

  setCell(cell: CellMessage): void {
    for (const entry of this.arms.values()) {
      entry.figure.remove();
      this.overlay.remove(entry.pair.line, entry.pairLabel.sprite, entry.name.sprite, entry.trail, entry.motion.way,
                          entry.motion.foreseen);
    }
    this.dragGoal(null);
    this.arms.clear();
    this.clock.reset();
    this.floor = cell.floor;
    const loading: Promise<void>[] = [];
    cell.arms.forEach((arm, index) => {
      const figure = new ArmFigure(arm, index, this.scene, this.section.planes);
      const trail = new THREE.Line(
        new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(TRAIL_POINTS * 3, 3)),
        new THREE.LineBasicMaterial({ color: armColour(index), transparent: true, opacity: 0.8 }));
      trail.frustumCulled = false;
      const entry: ArmEntry = {
        figure, track: new Track(), age: Number.POSITIVE_INFINITY, status: null, pair: new PairLine(0xe8b04a), pairLabel: new Label(),
        name: new Label(), trail, trailCount: 0, motion: new MotionLines(armColour(index)), numbers: new StateNumbers(), visible: true,
      };
      entry.pair.line.visible = entry.pairLabel.sprite.visible = trail.visible = false;
      this.overlay.add(entry.pair.line, entry.pairLabel.sprite, entry.name.sprite, trail, entry.motion.way, entry.motion.foreseen);
      figure.showLayers(this.toggles);
      this.arms.set(arm.name, entry);
      if (arm.urdf !== null) {
        loading.push(loadVisuals(arm.urdf).then((visuals) => figure.addVisuals(visuals),
          (error) => console.warn(`arm ${arm.name} is drawn by its collision shapes: ${String(error)}`)));
      }
    });
    this.loading = Promise.all(loading);
    this.layGrid();
    this.look("free");
  }

  /** A new connection to the same cell: the server's clock may be another one. */
  restart(): void {
    this.clock.reset();
    this.forgetMotion();
  }

  /** Nothing moves from where it was to where it is next. */
  private forgetMotion(): void {
    for (const entry of this.arms.values()) {
      entry.track = new Track();
      entry.motion.set({ way: [], foreseen: [] });
      if (!this.forPictures) entry.trailCount = 0;
      entry.figure.move(entry.figure.arm.start);
    }
    for (const entry of this.obstacles.values()) entry.track = new PoseTrack();
  }

  setObstacles(message: ObstaclesMessage): void {
    for (const { figure } of this.obstacles.values()) this.scene.remove(figure.group);
    const before = new Map(this.obstacles);
    this.obstacles.clear();
    for (const obstacle of message.obstacles) {
      const figure = new ObstacleFigure(obstacle, this.section.planes);
      this.scene.add(figure.group);
      this.obstacles.set(obstacle.name, { figure, track: before.get(obstacle.name)?.track ?? new PoseTrack() });
    }
  }

  setFrame(frame: FrameMessage, now: number): void {
    if (frame.leaps !== this.leaps) this.forgetMotion();
    this.leaps = frame.leaps;
    this.rate = frame.rate;
    this.clock.received(frame.t, now);
    // When a sample of this age was shown, or would have been.
    const timeOf = (age: number): number => frame.t - (frame.rate > 0 ? age / frame.rate : 0);
    let index = 0;
    for (const entry of this.arms.values()) {
      const [age, q, number] = frame.arms[index++] ?? [null, [], 0];
      if (entry.numbers.beginsAnew(number)) {
        entry.track = new Track();
        entry.trailCount = 0; // no line to where the arm begins
      }
      // A state that is no number (null) is not drawn, and so the arm becomes stale.
      entry.age = age ?? Number.POSITIVE_INFINITY;
      if (age !== null && q.length && q.every(Number.isFinite)) entry.track.add(timeOf(age), q);
    }
    this.obstacleAge = frame.obstacle_age ?? Number.POSITIVE_INFINITY;
    if (frame.obstacle_age === null) return;
    for (const [name, pose] of Object.entries(frame.obstacles)) {
      this.obstacles.get(name)?.track.add(timeOf(frame.obstacle_age), pose);
    }
  }

  setStatus(status: StatusMessage): void {
    for (const arm of status.arms) {
      const entry = this.arms.get(arm.name);
      if (entry) entry.status = arm;
    }
    this.showGoals();
  }

  setMotions(message: MotionsMessage): void {
    let index = 0;
    for (const entry of this.arms.values()) {
      entry.motion.set(message.arms[index++] ?? { way: [], foreseen: [] });
      entry.motion.show(this.toggles.ways);
    }
  }

  // --- what is shown

  setToggles(toggles: Toggles): void {
    this.toggles = { ...toggles };
    for (const entry of this.arms.values()) {
      entry.figure.showLayers(toggles);
      entry.trail.visible = toggles.trails;
      entry.motion.show(toggles.ways);
    }
    this.showGoals();
  }

  setTheme(dark: boolean): void {
    this.dark = dark;
    this.scene.background = new THREE.Color(dark ? 0x15181c : 0xeef0f2);
    this.layGrid();
  }

  /** Arms that are not among them are drawn, but without name and pair. */
  setFilter(names: ReadonlySet<string>): void {
    for (const [name, entry] of this.arms) entry.visible = names.has(name);
  }

  select(arm: string | null): void {
    this.selected = arm;
  }

  /** Shows the gizmo at an obstacle that may be dragged; null, or a name that is none: no gizmo. */
  chooseObstacle(name: string | null): void {
    this.ghost.choose(name === null ? null : this.obstacles.get(name)?.figure.obstacle ?? null);
  }
  /** Shows a gizmo at the tool of an arm, and the ghost of its goal; null: neither, and a drag under way ends. */
  dragGoal(arm: string | null): void {
    if (this.dragged !== null) this.arms.get(this.dragged)?.figure.showDraft(null, 0);
    this.tool.hide();
    const entry = arm === null ? undefined : this.arms.get(arm);
    this.dragged = entry && arm !== null ? arm : null;
    if (!entry) return;
    this.tool.setMatrix(entry.figure.toolMatrix());
    this.tool.show();
  }
  showDraft(q: readonly number[], look: DraftLook): void {
    if (this.dragged !== null) this.arms.get(this.dragged)?.figure.showDraft(q, DRAFT_COLOURS[look]);
  }
  /** Of both gizmos. */
  setRotation(rotates: boolean): void {
    this.ghost.gizmo.setRotation(rotates);
    this.tool.setRotation(rotates);
  }
  /** How an arm is drawn; empty: never. */
  jointsOf(arm: string): readonly number[] {
    return this.arms.get(arm)?.figure.q ?? [];
  }
  /** Colour of the ghost of the dragged goal; null: none. For tests. */
  get draftColour(): string | null {
    return (this.dragged === null ? null : this.arms.get(this.dragged)?.figure.draftColour) ?? null;
  }
  /** The tool of an arm as it is drawn, in W. For tests. */
  toolOf(arm: string): Pose | null {
    const matrix = this.arms.get(arm)?.figure.toolMatrix();
    if (!matrix) return null;
    const [p, q] = [new THREE.Vector3(), new THREE.Quaternion()];
    matrix.decompose(p, q, new THREE.Vector3());
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
  }
  /** Where the tool is wanted. For tests. */
  get wantedTool(): Pose {
    return this.tool.pose;
  }
  /** The point that the camera looks at. */
  get centre(): [number, number, number] {
    return this.controls.target.toArray();
  }
  /** Where the gizmo of the dragged goal or of the chosen obstacle is on the screen [px]. For tests. */
  gizmoOnScreen(): [number, number] {
    const point = (this.dragged === null ? this.ghost.gizmo : this.tool).place(this.camera);
    return [((point.x + 1) / 2) * this.host.clientWidth, ((1 - point.y) / 2) * this.host.clientHeight];
  }
  /** Where an obstacle is drawn [m]. For tests. */
  obstacleAt(name: string): number[] | null {
    return this.obstacles.get(name)?.figure.group.matrix.elements.slice(12, 15) ?? null;
  }

  /** The camera keeps its distance to the tool of that arm. */
  follow(arm: string | null): void {
    this.followed = arm;
  }
  get follows(): string | null {
    return this.followed;
  }

  look(preset: Preset): void {
    this.followed = null;
    const box = this.bounds();
    const centre = box.getCenter(new THREE.Vector3());
    const radius = Math.max(0.5, box.getSize(new THREE.Vector3()).length() / 2);
    const half = (this.camera.fov * Math.PI) / 360;
    const narrow = Math.min(1, this.camera.aspect);
    const distance = radius / Math.sin(Math.atan(Math.tan(half) * narrow));
    this.controls.target.copy(centre);
    this.camera.position.copy(PRESETS[preset]).normalize().multiplyScalar(distance).add(centre);
    this.controls.update();
  }

  /** Looks from there so that the bodies fill the picture as they stand now, with goals that are shown. */
  frame(preset: Preset): void {
    this.look(preset); // for a cell without bodies
    const place = fitting(this.camera, PRESETS[preset].clone().normalize(), this.corners(), PICTURE_MARGIN);
    if (place === null) return;
    this.controls.target.copy(place.target);
    this.camera.position.copy(place.position);
    this.controls.update();
  }

  /** Cuts the bodies across an axis in the middle of the arms, and leaves out the side of the camera. Null: no section. */
  cut(axis: Axis | null): void {
    if (axis === null) return this.section.set(null, 0, 1);
    const [low, high] = this.extent(axis);
    const viewer = this.camera.position[axis] - this.controls.target[axis];
    this.section.set(axis, (low + high) / 2, viewer < 0 ? -1 : 1);
  }
  /** Of the arms along an axis [m]. */
  extent(axis: Axis): [number, number] {
    const box = this.bounds();
    return [box.min[axis] - 0.1, box.max[axis] + 0.1];
  }

  /** Age of the newest state of an arm at local time `now` [ms]. */
  ageOf(arm: string, now: number): number {
    const entry = this.arms.get(arm);
    return entry ? this.ageAt(entry, this.clock.at(now)) : Number.POSITIVE_INFINITY;
  }
  /** Live, ages grow between frames and after the last one. The time of a recording may stand. */
  private ageAt(entry: ArmEntry, server: number): number {
    return this.rate === 1 ? server - entry.track.newestTime : entry.age;
  }

  get statistics(): FrameStatistics {
    const span = this.times.length > 1 ? this.times[this.times.length - 1] - this.times[0] : 0;
    return {
      framesPerSecond: span > 0 ? ((this.times.length - 1) * 1000) / span : 0,
      scriptMean: this.script.reduce((sum, t) => sum + t, 0) / Math.max(1, this.script.length),
      scriptMedian: [...this.script].sort((a, b) => a - b)[Math.floor(this.script.length / 2)] ?? 0,
      scriptMost: Math.max(0, ...this.script),
      frames: this.script.length,
    };
  }

  /** The next statistics are those of frames from now on. For tests. */
  forgetStatistics(): void {
    this.times.length = this.script.length = 0;
  }

  /** An arm as it is drawn: joint positions, and the poses of all links in W (column-major). Null before its first
   * state. For tests. */
  drawn(arm: string): { q: number[]; base: number[]; links: Record<string, number[]> } | null {
    const entry = this.arms.get(arm);
    if (!entry || entry.track.newest === undefined) return null;
    const links = entry.figure.tree.links.map((group) => [group.name, Array.from(group.matrixWorld.elements)] as const);
    return { q: [...entry.figure.q], base: [...entry.figure.arm.base], links: Object.fromEntries(links) };
  }
  motionOf(arm: string): Motion | null {
    return this.arms.get(arm)?.motion.drawn ?? null;
  }
  /** The pair that is drawn at an arm, with its label; null: none is. For tests. */
  pairOf(arm: string): { own: number[]; other: number[]; text: string } | null {
    const entry = this.arms.get(arm);
    if (!entry?.pair.line.visible) return null;
    const [own, other] = entry.pair.ends;
    return { own, other, text: entry.pairLabel.shown };
  }
  opacityOf(arm: string): number {
    return this.arms.get(arm)?.figure.shownOpacity ?? 0;
  }
  /** The links of an arm that are drawn by their collision shapes. For tests. */
  linksByShapes(arm: string): string[] {
    return this.arms.get(arm)?.figure.linksByShapes ?? [];
  }
  /** Where the tool of an arm is on the screen [px]. For tests. */
  toolOnScreen(arm: string): [number, number] | null {
    const entry = this.arms.get(arm);
    if (!entry) return null;
    const point = entry.figure.toolPosition(this.vector).project(this.camera);
    return [((point.x + 1) / 2) * this.host.clientWidth, ((1 - point.y) / 2) * this.host.clientHeight];
  }

  /** Of the newest frame, column-major. For tests. */
  get cameraMatrices(): { view: number[]; projection: number[] } {
    return { view: this.camera.matrixWorldInverse.toArray(), projection: this.camera.projectionMatrix.toArray() };
  }

  // --- pictures

  /** From now on it draws only on request. */
  beginPictures(): void {
    this.renderer.setAnimationLoop(null);
    this.resize();
  }
  drawPicture(): HTMLCanvasElement {
    this.draw();
    return this.renderer.domElement;
  }

  // --- one frame

  private draw(): void {
    const began = performance.now();
    const server = this.clock.at(began);
    const shown = server - SHOWN_DELAY;
    for (const entry of this.arms.values()) {
      if (entry.track.sample(shown, this.scratch)) entry.figure.move(this.scratch);
      entry.figure.show(this.ageAt(entry, server), entry.status?.lost ?? false);
    }
    for (const { figure, track } of this.obstacles.values()) {
      if (track.sample(shown, this.scratch)) place(figure.group, this.scratch);
      figure.show(this.rate === 1 ? server - track.newestTime : this.obstacleAge);
    }
    if (this.ghost.chosen !== null) this.ghost.follow(this.obstacles.get(this.ghost.chosen)?.figure.group);
    this.scene.updateMatrixWorld();
    this.annotate(server);
    this.overlay.updateMatrixWorld();
    this.moveCamera();
    this.renderer.render(this.scene, this.camera);
    this.times.push(began);
    this.script.push(performance.now() - began);
    if (this.times.length > 240) {
      this.times.shift();
      this.script.shift();
    }
  }

  private annotate(server: number): void {
    const text = this.dark ? "#e6e8ea" : "#1b1e22";
    const background = this.dark ? "rgba(30,34,39,0.75)" : "rgba(255,255,255,0.8)";
    const addTrail = this.forPictures || (server - this.lastTrail > 33 && this.rate > 0);
    if (addTrail) this.lastTrail = server;
    for (const [name, entry] of this.arms) {
      entry.name.sprite.visible = this.toggles.names && (entry.visible || name === this.selected);
      if (entry.name.sprite.visible) {
        const state = entry.status ? stateOf(entry.status, this.ageAt(entry, server)) : "stale";
        const chosen = name === this.selected;
        const [ink, paper] = chosen ? (this.dark ? ["#15181c", "#e6e8ea"] : ["#ffffff", "#1b1e22"]) : [text, background];
        entry.name.set(`${MARKS[state]} ${name}`, ink, paper);
        entry.name.sprite.position.copy(entry.figure.toolPosition(this.vector));
      }
      this.drawPair(name, entry);
      if (this.toggles.trails && addTrail) this.extendTrail(entry);
    }
  }

  private extendTrail(entry: ArmEntry): void {
    const positions = entry.trail.geometry.getAttribute("position") as THREE.BufferAttribute;
    const array = positions.array as Float32Array;
    if (entry.trailCount === TRAIL_POINTS) array.copyWithin(0, 3);
    else ++entry.trailCount;
    entry.figure.toolPosition(this.vector).toArray(array, (entry.trailCount - 1) * 3);
    positions.needsUpdate = true;
    entry.trail.geometry.setDrawRange(0, entry.trailCount);
  }

  /** The line between the two bodies that bound the motion of an arm, with the distance that its planner reports. */
  private drawPair(name: string, entry: ArmEntry): void {
    const goal = entry.status?.goal;
    const binding = goal && !goal.final ? goal.binding : null;
    const wanted = this.toggles.binding && binding !== null && (entry.visible || name === this.selected);
    const pair = wanted ? nearestOf(this.segmentsOf(binding.own), this.segmentsOf(binding.other)) : undefined;
    entry.pair.line.visible = entry.pairLabel.sprite.visible = pair !== undefined;
    if (!pair || !binding) return;
    entry.pair.set(pair.own, pair.other);
    entry.pairLabel.set(distanceText(binding.distance), "#15181c", "rgba(232,176,74,0.92)");
    entry.pairLabel.sprite.position.set((pair.own[0] + pair.other[0]) / 2, (pair.own[1] + pair.other[1]) / 2,
                                        (pair.own[2] + pair.other[2]) / 2);
  }

  /** Of a body by its name in a report: "north/forearm", or an obstacle. */
  private segmentsOf(body: string): Segment[] {
    const slash = body.indexOf("/");
    const arm = slash > 0 ? this.arms.get(body.slice(0, slash)) : undefined;
    if (arm) return arm.figure.segments(body.slice(slash + 1));
    return this.obstacles.get(body)?.figure.segments() ?? [];
  }

  private moveCamera(): void {
    const followed = this.followed !== null ? this.arms.get(this.followed) : undefined;
    if (followed) {
      const tool = followed.figure.toolPosition(this.vector);
      const step = this.vector2.copy(tool).sub(this.controls.target).multiplyScalar(0.15);
      this.controls.target.add(step);
      this.camera.position.add(step);
    }
    this.controls.update();
    this.camera.updateMatrixWorld();
  }

  // --- helpers

  private showGoals(): void {
    for (const { figure, status } of this.arms.values()) {
      const goal = status?.goal;
      figure.showGoal(this.toggles.goals && goal && !goal.final && goal.q.length ? goal.q : null);
    }
  }

  private bounds(): THREE.Box3 {
    const box = new THREE.Box3();
    this.scene.updateMatrixWorld();
    for (const { figure } of this.arms.values()) box.expandByObject(figure.tree.root);
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, 0), new THREE.Vector3(1, 1, 1));
    return box;
  }

  /** Of boxes around the links of all arms and their shown goals, and around obstacles: without a hall, and without what
   * the arms stand on. */
  private corners(): THREE.Vector3[] {
    this.scene.updateMatrixWorld();
    const corners = [...this.arms.values()].flatMap(({ figure }) => figure.corners());
    const arms = new THREE.Box3().setFromPoints(corners);
    const largest = LARGEST * Math.max(1, arms.getSize(this.vector).length());
    for (const { figure } of this.obstacles.values()) {
      const box = new THREE.Box3().setFromObject(figure.group);
      const below = box.max.z <= arms.min.z + 0.02;
      if (!box.isEmpty() && !below && box.getSize(this.vector).length() <= largest) corners.push(...cornersOf(figure.group));
    }
    return corners;
  }

  private layGrid(): void {
    this.scene.remove(this.grid);
    this.grid.dispose();
    const box = this.bounds();
    const reach = Math.max(Math.abs(box.min.x), Math.abs(box.max.x), Math.abs(box.min.y), Math.abs(box.max.y), 1);
    const size = 2 * Math.ceil(1.4 * reach);
    const [line, axis] = this.dark ? [0x2a2f35, 0x3d444c] : [0xd5d9dd, 0xb4bac0];
    this.grid = new THREE.GridHelper(size, size * 2, axis, line);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = this.floor - 0.001;
    this.scene.add(this.grid);
  }

  private resize(): void {
    const width = Math.max(1, this.host.clientWidth);
    const height = Math.max(1, this.host.clientHeight);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(width, height);
  }

  private listenForSelection(): void {
    const canvas = this.renderer.domElement;
    let pressed: [number, number] = [0, 0];
    let onGizmo = false;
    canvas.addEventListener("pointerdown", (event) => {
      pressed = [event.clientX, event.clientY];
      onGizmo = this.ghost.gizmo.touched || this.tool.touched;
    });
    canvas.addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 5) return; // the camera was turned
      if (onGizmo) return;
      const place = canvas.getBoundingClientRect();
      const point = new THREE.Vector2(((event.clientX - place.left) / place.width) * 2 - 1,
                                      1 - ((event.clientY - place.top) / place.height) * 2);
      const ray = new THREE.Raycaster();
      ray.setFromCamera(point, this.camera);
      let best: { arm: string; distance: number } | null = null;
      for (const [name, { figure }] of this.arms) {
        const hit = ray.intersectObjects(figure.parts, true).find(({ point }) => !this.section.hides(point));
        if (hit && (!best || hit.distance < best.distance)) best = { arm: name, distance: hit.distance };
      }
      let nearest: { name: string; distance: number } | null = null;
      for (const [name, { figure }] of this.obstacles) {
        const hit = ray.intersectObject(figure.group, true).find(({ point }) => !this.section.hides(point));
        if (hit && (!nearest || hit.distance < nearest.distance)) nearest = { name, distance: hit.distance };
      }
      if (nearest && (!best || nearest.distance < best.distance)) this.onObstacle(nearest.name);
      else this.onSelect(best ? best.arm : null);
    });
  }
}
