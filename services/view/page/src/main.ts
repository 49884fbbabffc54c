/// Connects the stream with the scene and the panels, and handles keys.
import { Connection } from "./connection";
import { DraftBar } from "./draft_bar";
import { GoalDraft } from "./goal_draft";
import { MOST_SILENCE, OrderBook, tokenIn } from "./orders";
import { OrdersPanel } from "./orders_panel";
import { byId, Panel } from "./panel";
import { Plots } from "./plots";
import type { FrameMessage, Message, ObstaclesMessage, StatusMessage } from "./protocol";
import { CellScene, type Preset, type Toggles } from "./scene";
import { SectionBar } from "./section_bar";
import { Timeline } from "./timeline";

// `hecaton render` opens the page for a picture of the scene alone.
const query = new URLSearchParams(location.search);
const forPictures = query.has("picture");
if (forPictures) {
  document.documentElement.classList.add("picture");
  // The window of a browser is smaller than it was asked to be.
  byId("scene").style.width = `${query.get("width")}px`;
  byId("scene").style.height = `${query.get("height")}px`;
}

const scene = new CellScene(byId("scene"), forPictures);
const panel = new Panel();
const plots = new Plots(byId("plots"));
const timeline = new Timeline(byId("replay"));
const search = byId("search") as HTMLInputElement;
const toggles: Toggles = {
  goals: true, ways: true, halos: false, planning: false, binding: true, names: true, trails: false,
};

let status: StatusMessage | null = null;
let obstacles: ObstaclesMessage | null = null;
let order: string[] = []; // of the arms
let cellText = "";
let selected: string | null = null;

const ageOf = (arm: string): number => scene.ageOf(arm, performance.now());

// --- layers, views, theme

const TOGGLES: [keyof Toggles, string, string][] = [
  ["goals", "Goals", "g"], ["ways", "Planned ways", "w"], ["binding", "Binding pairs", "b"], ["halos", "Safety distance", "s"],
  ["planning", "Planner's shapes", "p"], ["trails", "Trails", "l"], ["names", "Names", "n"],
];
const VIEWS: [Preset, string, string][] = [
  ["free", "Overview", "1"], ["top", "Top", "2"], ["front", "Front", "3"], ["side", "Side", "4"],
];

function button(host: HTMLElement, text: string, key: string, press: () => void): HTMLButtonElement {
  const made = document.createElement("button");
  made.textContent = text;
  made.title = `${text} (${key.toUpperCase()})`;
  made.onclick = press;
  host.append(made);
  return made;
}

const actions = new Map<string, () => void>();
for (const [name, text, key] of TOGGLES) {
  const made = button(byId("toggles"), text, key, () => actions.get(key)?.());
  actions.set(key, () => {
    toggles[name] = !toggles[name];
    made.setAttribute("aria-pressed", String(toggles[name]));
    scene.setToggles(toggles);
  });
  made.setAttribute("aria-pressed", String(toggles[name]));
}
for (const [preset, text, key] of VIEWS) {
  button(byId("views"), text, key, () => actions.get(key)?.());
  actions.set(key, () => {
    scene.look(preset);
    showFollow();
  });
}
const followButton = button(byId("views"), "Follow", "f", () => actions.get("f")?.());
function showFollow(): void {
  followButton.setAttribute("aria-pressed", String(scene.follows !== null));
}
actions.set("f", () => {
  scene.follow(scene.follows === null ? selected ?? order[0] ?? null : null);
  showFollow();
});

const section = new SectionBar(byId("section"), scene);
actions.set("x", () => section.turn());
actions.set("arrowright", () => section.step(1));
actions.set("arrowleft", () => section.step(-1));

// The theme of the system, also when it changes, until a person chooses one here.
const prefersLight = window.matchMedia("(prefers-color-scheme: light)");
let dark = (localStorage.getItem("theme") ?? (prefersLight.matches ? "light" : "dark")) !== "light";
prefersLight.addEventListener("change", () => {
  if (localStorage.getItem("theme") !== null) return;
  dark = !prefersLight.matches;
  showTheme();
});
function showTheme(): void {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  scene.setTheme(dark);
  plots.setTheme(dark);
}
actions.set("t", () => {
  dark = !dark;
  localStorage.setItem("theme", dark ? "dark" : "light");
  showTheme();
});
byId("theme").onclick = () => actions.get("t")?.();

const keys = byId("keys") as HTMLDialogElement;
actions.set("?", () => (keys.open ? keys.close() : keys.showModal()));
byId("help").onclick = () => actions.get("?")?.();
keys.innerHTML = "<table>" + [
  ...VIEWS.map(([, text, key]) => [key, text]), ["f", "Follow the selected arm"],
  ...TOGGLES.map(([, text, key]) => [key, text]), ["x", "Section across x, y, z, or none"], ["← →", "Move the section"], ["t", "Dark or light"], ["/", "Search"], ["↑ ↓", "Select an arm"],
  ["d", "Drag a goal of the selected arm; Enter: go there"],
  ["r", "The gizmo rotates or moves"], ["?", "This table"],
  ["Esc", "Stop the cell, from anywhere on the page (no safety function). While this table is open: only close it"],
].map(([key, text]) => `<tr><td><kbd>${key.length > 1 ? key : key.toUpperCase()}</kbd></td><td>${text}</td></tr>`).join("") +
  '</table><p class="dim">Search for words, or for a state: is:waiting, is:held.</p>' +
  '<form method="dialog"><button>Close</button> <a href="licenses.txt">Licenses</a></form>';

// --- selection and search

function select(arm: string | null): void {
  if (draft.arm !== null && draft.arm !== arm) draft.cancel();
  selected = arm;
  scene.select(arm);
  panel.select(arm);
  ordersPanel.select(arm);
  if (scene.follows !== null && arm !== null) scene.follow(arm);
  refresh();
}
scene.onSelect = select;
panel.onSelect = select;

function step(by: number): void {
  const visible = panel.visibleArms(status, ageOf);
  if (!visible.length) return;
  const at = selected === null ? -1 : visible.indexOf(selected);
  select(visible[(Math.max(at, by > 0 ? -1 : 0) + by + visible.length) % visible.length]);
}

search.oninput = () => {
  panel.setQuery(search.value.trim());
  refresh();
};

function refresh(): void {
  scene.setFilter(new Set(panel.visibleArms(status, ageOf)));
  if (status) panel.setStatus(status, ageOf);
  if (obstacles) panel.setObstacles(obstacles);
  if (status) ordersPanel.setStatus(status);
}

const SLIDER_KEYS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown"]);
/** The element that has the focus needs the key itself. */
function usesKey(element: EventTarget | null, key: string): boolean {
  if (element instanceof HTMLInputElement && element.type === "range") return SLIDER_KEYS.has(key);
  return element instanceof HTMLInputElement || element instanceof HTMLSelectElement;
}

/** In the capture phase and with any modifier: no other handler comes first. */
document.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || event.repeat) return;
  if (keys.open) {
    keys.close();
    event.preventDefault();
    return;
  }
  orders.stop();
  scene.ghost.cancel();
  draft.cancel();
  if (event.target !== search) return;
  search.value = "";
  search.dispatchEvent(new Event("input"));
  search.blur();
}, { capture: true });

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.key === "Escape") return;
  if (usesKey(event.target, event.key)) return;
  if (event.key === "/") search.focus();
  else if (event.key === "ArrowDown") step(1);
  else if (event.key === "ArrowUp") step(-1);
  else if (event.key === "Enter" && draft.arm !== null && !keys.open && !(event.target instanceof HTMLButtonElement)) {
    if (!event.repeat) goThere();
  } else {
    const action = actions.get(event.key.toLowerCase());
    // Space presses the button that has the focus.
    if (!action || (event.key === " " && event.target instanceof HTMLButtonElement)) return;
    action();
  }
  event.preventDefault();
});

// --- messages

const connection = new Connection(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
timeline.onCommand = (command) => connection.send(command);
timeline.arm = () => selected;

// The token is in the part of the address that browsers do not send. It shall not stay in the history either.
const token = tokenIn(location.hash) ?? sessionStorage.getItem("token");
if (token !== null) sessionStorage.setItem("token", token);
if (tokenIn(location.hash) !== null) history.replaceState(null, "", location.pathname);
const orders = new OrderBook((message) => connection.send(message), token, () => connection.silence,
                              () => connection.seen);
// Where this page is open already, the address with the token changes the fragment only.
window.addEventListener("hashchange", () => {
  const given = tokenIn(location.hash);
  if (given === null) return;
  sessionStorage.setItem("token", given);
  history.replaceState(null, "", location.pathname);
  location.reload();
});
const ordersPanel = new OrdersPanel(byId("orders"), byId("stop") as HTMLButtonElement, orders);
setInterval(() => orders.keepControl(), 2000);
orders.onChange = () => {
  if (!orders.controls) draft.cancel(); // it was released or lost, or there is no connection
  ordersPanel.show();
  showObstacle();
  // The ghost is where it was dropped until the cell has answered.
  if (!orders.waits("obstacle_move")) scene.ghost.settle();
};

// --- the obstacle that may be dragged

let obstacle: string | null = null;
function showObstacle(): void {
  if (obstacle !== null && !obstacles?.obstacles.some((one) => one.name === obstacle)) obstacle = null;
  scene.chooseObstacle(orders.controls ? obstacle : null);
  panel.chooseObstacle(orders.controls ? obstacle : null);
  ordersPanel.chooseObstacle(obstacle);
}
function chooseObstacle(name: string): void {
  draft.cancel();
  obstacle = obstacle === name ? null : name;
  showObstacle();
}
scene.onObstacle = panel.onObstacle = chooseObstacle;
scene.ghost.onDrop = (name, pose) => {
  if (!orders.give({ op: "obstacle_move", name, pose }, `move ${name}`)) scene.ghost.cancel();
};
ordersPanel.placeForObstacle = () => scene.centre;

// --- the goal that is dragged

const draft = new GoalDraft((message) => connection.send(message), () => performance.now());
const draftBar = new DraftBar(byId("draft"), draft);
setInterval(() => draft.ask(), 50);
let drafted: string | null = null; // the arm that the scene shows a gizmo for
draft.onChange = () => {
  if (draft.arm !== drafted) {
    drafted = draft.arm;
    scene.dragGoal(drafted);
  }
  if (drafted !== null) scene.showDraft(draft.q, draft.blocked ? "blocked" : draft.near ? "near" : "free");
  ordersPanel.setDrag(drafted !== null);
  draftBar.show();
};
scene.onTool = (pose) => draft.move(pose);

function toggleDraft(): void {
  if (draft.arm !== null) draft.cancel();
  else if (orders.controls && selected !== null && scene.drawn(selected) !== null) {
    if (obstacle !== null) chooseObstacle(obstacle); // one gizmo at a time
    if (document.activeElement instanceof HTMLElement) document.activeElement.blur(); // Enter shall press no button
    draft.begin(selected, scene.jointsOf(selected));
  }
}
/** The one order of a drag, which ends once it is sent. */
function goThere(): void {
  const order = draft.order;
  if (order !== null && orders.give(order, `${draft.arm} to the dragged goal`)) draft.cancel();
}
actions.set("d", toggleDraft);
ordersPanel.onDrag = toggleDraft;
draftBar.onGo = goThere;

let rotates = false; // the gizmo
function rotate(): void {
  rotates = !rotates;
  scene.setRotation(rotates);
  ordersPanel.setRotation(rotates);
  draftBar.setRotation(rotates);
}
actions.set("r", rotate);
draftBar.onRotate = ordersPanel.onRotate = rotate;

/** The keys of a recording. */
function addReplayKeys(): void {
  if (actions.has(" ")) return;
  const more: [string, string, string, () => void][] = [
    [" ", "Space", "Play or pause", () => timeline.toggle()],
    [".", ".", "The next tick of the planner of the selected arm; its next state where no tick is recorded", () => timeline.step(1)],
    [",", ",", "The tick, or the state, before", () => timeline.step(-1)],
    ["]", "]", "Faster", () => timeline.faster(1)],
    ["[", "[", "Slower", () => timeline.faster(-1)],
  ];
  for (const [key, name, text, press] of more) {
    actions.set(key, press);
    const row = keys.querySelector("table")!.insertRow();
    row.innerHTML = `<td><kbd>${name}</kbd></td><td>${text}</td>`;
  }
}

const OFFLINE = "The page has lost its connection to its server. What it shows is old. It tries again.";
const SILENT = "The page hears nothing from its server. What it shows is old, and orders may arrive late.";
let connected = true; // no message before the first attempt
function showOffline(): void {
  const offline = byId("offline");
  offline.hidden = connected && !(connection.silence > MOST_SILENCE && Number.isFinite(connection.silence));
  offline.textContent = connected ? SILENT : OFFLINE;
}
connection.onState = (now) => {
  connected = now;
  showOffline();
  if (!connected) orders.disconnected();
};
connection.onMessage = (message: Message, now: number) => {
  switch (message.type) {
    case "cell":
      if (JSON.stringify(message) === cellText) {
        scene.restart(); // the camera stays
        break;
      }
      cellText = JSON.stringify(message);
      order = message.arms.map((arm) => arm.name);
      if (selected !== null && !order.includes(selected)) selected = null;
      draft.cancel();
      scene.setCell(message);
      scene.setToggles(toggles);
      panel.setCell(message);
      plots.setCell(message);
      ordersPanel.setCell(message);
      break;
    case "control":
      orders.setControl(message);
      break;
    case "reply":
      if (message.op === "preview") draft.refused(message.id, message.text);
      else orders.setReply(message);
      break;
    case "preview":
      draft.setAnswer(message);
      break;
    case "obstacles":
      obstacles = message;
      scene.setObstacles(message);
      panel.setObstacles(message);
      showObstacle();
      break;
    case "status":
      status = message;
      scene.setStatus(message);
      plots.add(message, ageOf);
      refresh();
      break;
    case "motions":
      scene.setMotions(message);
      break;
    case "recording":
      timeline.setRecording(message);
      addReplayKeys();
      break;
    case "playback":
      timeline.setPlayback(message);
      break;
    case "frame":
      scene.setFrame(message, now);
      showJoints(message);
      break;
  }
};

let jointsAt = 0;
function showJoints(frame: FrameMessage): void {
  if (selected === null || Math.abs(frame.t - jointsAt) < 100) return;
  jointsAt = frame.t;
  const q = frame.arms[order.indexOf(selected)]?.[1];
  if (q) panel.setJoints(q);
}

setInterval(() => {
  const { framesPerSecond, scriptMean } = scene.statistics;
  showOffline();
  byId("rate").textContent = `${framesPerSecond.toFixed(0)} fps  ${scriptMean.toFixed(1)} ms`;
  if (!status) return;
  panel.setStatus(status, ageOf); // ages grow also while nothing arrives
  scene.setFilter(new Set(panel.visibleArms(status, ageOf)));
}, 1000);

showTheme();
connection.open();
if (forPictures) {
  void import("./picture.js").then(({ takePicture }) => takePicture({
    scene, connection, show(wanted, preset, isDark) {
      Object.assign(toggles, wanted);
      scene.setToggles(toggles);
      scene.look(preset);
      dark = isDark;
      showTheme();
    },
  }));
}

// For tests: what the page shows, in numbers.
Object.assign(window, { hecaton: { scene, select, timeline, orders, draft } });
