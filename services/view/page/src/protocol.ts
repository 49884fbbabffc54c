/// What hecaton-view and `hecaton replay` send (services/view: cell_json.cpp, state_json.cpp; services/replay: replay.cpp).
/// Lengths in metres, angles in radians, times in
/// milliseconds unless a comment says otherwise.

/** [x, y, z, qx, qy, qz, qw] */
export type Pose = [number, number, number, number, number, number, number];
export type Vector = [number, number, number];

export interface Capsule {
  pose: Pose; // in the frame of the body
  radius: number;
  length: number; // of the axis, without the caps
}

export type ShapeForm =
  | { kind: "box"; size: Vector }
  | { kind: "sphere"; radius: number }
  | { kind: "capsule" | "cylinder"; radius: number; length: number }
  | { kind: "convex"; vertices: Vector[]; faces: number[][] }
  // x, y, z of at most 20,000 of its `count` points, one after the other; balls of `radius` about them.
  | { kind: "points"; radius: number; count: number; points: number[] };

export type Shape = ShapeForm & {
  pose: Pose; // in the frame of the body
  capsule: Capsule; // encloses the shape
};

export type LinkShape = Shape & {
  link: number;
  planning: Capsule | null; // planners measure distances with it; null: with the shape
};

export interface Link {
  name: string;
  parent: number; // −1: the base
  pose: Pose; // of the joint in the parent's frame
  axis: Vector;
  kind: "fixed" | "revolute" | "prismatic";
  joint: number; // index into q; −1: does not move
  multiplier: number; // its joint is at multiplier · q[joint] + offset
  offset: number;
}

export interface Arm {
  name: string;
  robot: string;
  base: Pose; // in W
  links: Link[]; // parents before children
  shapes: LinkShape[];
  joints: string[];
  lower: number[];
  upper: number[];
  velocity: number[];
  start: number[];
  poses: string[]; // names, for goals
  tool_link: number;
  tool: Pose; // in the frame of the tool link
  security_distance: number;
  influence_distance: number;
  method: string;
  urdf: string | null; // where its visual elements are; null: it has none
  note: string; // why it is drawn by its shapes; empty: nothing to say
}

export interface CellMessage {
  type: "cell";
  name: string;
  version: string;
  floor: number;
  arms: Arm[];
  hosts: string[];
}

export interface Obstacle {
  name: string;
  shapes: Shape[];
  pose: Pose;
  motion: string;
  attached_to: string; // an arm; empty: none
}

export interface ObstaclesMessage {
  type: "obstacles";
  obstacles: Obstacle[];
}

export interface FrameMessage {
  type: "frame";
  t: number; // clock of the server, which runs evenly
  rate: number; // of the time that is shown: 1 live, 0 paused
  leaps: number; // grows when that time leaps
  arms: [number | null, number[], number][]; // age (null: never received), joint positions, number of the state
  obstacle_age: number | null;
  obstacles: Record<string, Pose>;
}

export interface Cause {
  kind: string;
  subject: string;
  text: string;
}

export interface Binding {
  own: string; // "north/forearm"
  other: string; // "west/wrist", or an obstacle
  distance: number;
}

export interface Goal {
  id: string;
  state: string;
  final: boolean;
  cause: Cause | null;
  action: string;
  blocked: number; // [s]
  distance: number;
  elapsed: number; // [s]
  note: string;
  q: number[];
  binding: Binding | null;
}

/** The gripper of an arm. */
export interface Tool {
  moving: boolean;
  width: number | null; // of its opening [m]; null: not known
  holding: string; // obstacle; empty: none
}

export interface ArmStatus {
  name: string;
  mode: "run" | "hold" | "stop" | "unknown";
  speed_override: number; // ordered share of its velocity limits
  waiting: Cause | null; // null: it moves
  planner: string;
  drive: string | null; // null: no state was received
  goal: Goal | null;
  tool: Tool | null; // null: it has no gripper, or its driver does not run
  lost: boolean;
  moving?: boolean;
  speed?: number; // of the fastest joint [rad/s | m/s]
  carried?: string;
  command_age?: number; // [s]
}

export interface NodeStatus {
  name: string;
  kind: string;
  host: string;
  pid: number;
  state: string;
  alive: boolean;
  age: number;
  cause: Cause | null;
  tick: [number, number]; // p50, p99 [µs]
  late: number; // of its timer, at most [µs]
  input: string; // its oldest
  input_age: number; // [s]; negative: never received
  memory: number; // [byte]
}

export interface Fault {
  id: string;
  severity: "info" | "warning" | "error" | "critical";
  kind: string;
  subject: string;
  text: string;
  since: number; // Unix time
  duration: number | null; // [s]; null: open
}

export interface StatusMessage {
  type: "status";
  t: number;
  wall: number; // Unix time of the server
  mode: "run" | "hold" | "stop" | null;
  mode_age: number | null; // since the newest cell mode [ms]; null: none
  cause: Cause | null;
  speed_override: number | null; // of the cell; null: no supervisor
  term: number;
  supervisor: string;
  contacts: { count: number; smallest: { a: string; b: string; distance: number } | null } | null;
  faults: Fault[];
  arms: ArmStatus[];
  nodes: NodeStatus[];
}

/** Where a planner wants to move its arm: the tool in W, from its measured place on. Empty: nowhere, or unknown. */
export interface Motion {
  way: Vector[]; // through the points of its coupled plan, route or trajectory to its target
  foreseen: Vector[]; // what is left of its newest rollout
}

export interface MotionsMessage {
  type: "motions";
  arms: Motion[];
}

// --- a recording: times are since its begin

export interface Mark {
  kind: "fault" | "goal" | "mode";
  at: number;
  until: number | null; // of a fault that was cleared
  subject: string; // an arm; empty: the cell
  text: string;
  severity: string; // of a fault
}

export interface RecordingMessage {
  type: "recording";
  files: string[];
  begin: number; // Unix time
  length: number;
  notes: string[]; // what is damaged, cut or left out
  marks: Mark[]; // by time
}

export interface PlaybackMessage {
  type: "playback";
  at: number;
  plays: boolean;
  speed: number;
}

// --- orders (services/view: orders.cpp)

export interface ControlMessage {
  type: "control";
  stop: boolean; // every page may stop the cell
  control: boolean; // a page with the token may control
  refusal: string; // why this view gives no orders; empty: it does
  controller: { number: number; address: string } | null;
}

export interface ReplyMessage {
  type: "reply";
  id: number; // of the order
  op: string;
  done: boolean;
  final: boolean; // false: another reply follows
  text: string;
  number?: number; // of this page, when it took control
}

/** The answer to a `preview`: joint positions for a pose of the tool. */
export interface PreviewMessage {
  type: "preview";
  id: number; // of the question
  arm: string;
  q: number[]; // for the pose, or for the nearest one; empty: none
  verdict: "free" | "near" | "occupied" | "collision" | "unreachable" | "unknown";
  accepted: boolean; // q may be a goal
  text: string; // why not, in a sentence; empty: nothing to say
  pair: { own: string; other: string; distance: number } | null; // the nearest bodies, when they are near
}

/** Without arms: for the cell. */
export type Order =
  | { op: "stop" | "hold" | "resume"; arms?: string[] }
  | { op: "take"; token: string }
  | { op: "release" }
  | { op: "save" } // what the recorders of the cell keep
  | { op: "goal"; arm: string; named: string }
  | { op: "goal"; arm: string; q: number[] }
  | { op: "cancel"; arm: string; goal: string }
  | { op: "obstacle_add"; name: string; shape: { kind: "box" | "sphere" | "cylinder"; size: number[] }; pose: Pose }
  | { op: "obstacle_move"; name: string; pose: Pose }
  | { op: "obstacle_remove"; name: string };

/** What a page sends. `alive` keeps the control of a page that gives no order. `preview` asks for joint positions that
 * bring the tool to a pose, from those of `start`; only the newest question has an answer. The server refuses an order
 * that arrives long after it sent the state `seen`, unless it makes arms stand. */
export type Sent =
  | Command
  | { op: "alive" }
  | { op: "preview"; id: number; arm: string; pose: Pose; start: number[] }
  | (Order & { id: number; seen?: number }); // `seen`: the `t` of the newest frame or status

export type Message =
  CellMessage | ObstaclesMessage | FrameMessage | StatusMessage | MotionsMessage | RecordingMessage | PlaybackMessage | ControlMessage |
  ReplyMessage | PreviewMessage;

/** What a page of a recording sends. A step goes to the next or previous tick of the arm's planner; where
    no tick is recorded, to a state of the arm. An empty name: of any arm. */
export type Command =
  | { op: "play" | "pause" }
  | { op: "speed"; value: number } // 0.1 to 10
  | { op: "seek"; at: number }
  | { op: "step"; by: -1 | 1; arm: string };
