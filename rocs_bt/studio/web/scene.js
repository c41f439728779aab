// @ts-check
// What arena and space show besides bodies: layers, the robot's own map, what it believes, and its rays.
import { el, upto } from "./dom.js";
import { swatch } from "./legend.js";

const NAMES = { way: "way driven", plan: "planned path", rays: "rays", map: "its own map", beliefs: "what it believes" };
const TINTS = { way: ["deliberative", "reactive", "actor"], plan: ["deliberative"], rays: ["belief"], map: ["belief"], beliefs: ["belief"] };

/** Layers that are shown, and whether the camera follows the robot; says `change`. */
export class Layers extends EventTarget {
  constructor() {
    super();
    this.way = true;
    this.plan = true;
    this.rays = true;
    this.map = true;
    this.beliefs = true;
    this.follow = false;
    const follow = el("button", { "aria-pressed": "false", title: "the camera follows the robot (c)", onclick: () => this.toggle("follow") }, "follow");
    const boxes = Object.entries(NAMES).map(([name, text]) => {
      const input = el("input", { type: "checkbox", checked: true, onchange: () => this.toggle(name) });
      this.addEventListener("change", () => { input.checked = this[name]; });
      return el("label", {}, input, text, ...TINTS[name].map(swatch));
    });
    this.addEventListener("change", () => follow.setAttribute("aria-pressed", String(this.follow)));
    this.box = el("div", { class: "layers" }, follow, el("details", {}, el("summary", {}, "layers"), el("div", {}, ...boxes)));
  }

  /** Names of the layers that are not as at the start. */
  get turned() { return [...Object.keys(NAMES), "follow"].filter((name) => this[name] !== (name !== "follow")); }

  set turned(names) { for (const name of [...Object.keys(NAMES), "follow"]) if (this.turned.includes(name) !== names.includes(name)) this.toggle(name); }

  toggle(name) {
    this[name] = !this[name];
    this.dispatchEvent(new Event("change"));
  }
}

const WINDOW = 20; // [s] of the way behind a body

/** Intervals of the last seconds before a time, each with the colour of what moved the body. */
export const ways = (run, name, t) => {
  const track = run.get(name, "route"), from = t - WINDOW;
  if (!track) return [{ from, to: t, tint: "actor" }];
  const found = [];
  for (let i = Math.max(0, upto(track.t, from) - 1); i < track.t.length && track.t[i] <= t; i++) {
    if (track.v[i]) found.push({ from: Math.max(track.t[i], from), to: Math.min(track.t[i + 1] ?? t, t), tint: track.v[i] });
  }
  return found;
};

/** Objects with a position in the knowledge of a robot: name and position. */
export const believed = (run, agent, t) => {
  const places = new Set((run.header.places ?? []).map((p) => p.name)), found = [];
  for (const track of run.of(agent, "fact")) {
    const [node, attribute] = track.name.split("\n"), at = track.at(t);
    if (["pose", "position", "centre"].includes(attribute) && Array.isArray(at) && !places.has(node)) found.push([node, at]);
  }
  return found;
};

/** Radius [m], speed [m/s] and uncertainty [m] of an object that a robot believes to move; undefined for others. */
export const motion = (run, agent, node, t) => {
  const of = (attribute) => run.get(agent, "fact", `${node}\n${attribute}`)?.at(t);
  const [east = 0, , , north = 0] = of("covariance") ?? [];
  return of("moves") ? { radius: of("radius") ?? 0, speed: of("speed") ?? 0, spread: Math.sqrt(Math.max(east, north)) } : undefined;
};

/** The map of a robot at a time: the sum of its changes. */
export class OwnMap {
  constructor(run) {
    this.run = run;
    this.agent = "";
    this.index = 0;
    this.cells = new Map();
    this.cell = 0;
  }

  /** Side of a cell [m], and numbers of the occupied cells along x and y. */
  at(agent, t) {
    const track = this.run.get(agent, "map"), to = track ? upto(track.t, t) : 0;
    if (agent !== this.agent || to < this.index) Object.assign(this, { agent, index: 0, cells: new Map() });
    for (; this.index < to; this.index++) {
      const { cell, occupied = [], cleared = [] } = track.v[this.index];
      this.cell = cell;
      for (const [x, y] of cleared) this.cells.delete(`${x},${y}`);
      for (const at of occupied) this.cells.set(at.join(), at);
    }
    return { cell: this.cell, cells: this.cells.values() };
  }
}

/** Rays of a robot at a time: both ends in the world, whether there is an echo, its cone, and the scan that it is of. */
export const rays = (run, { name, beams = {}, fans = {}, base = 0 }, t) => {
  const found = [], ray = (pose, { x, y, reach, cone = 0, elevation = 0 }, angle, echo, scan) => {
    const c = Math.cos(pose.yaw), s = Math.sin(pose.yaw), z = pose.z ?? base, far = Math.min(Number.isNaN(echo) ? 0 : echo, reach);
    const eye = [pose.x + c * x - s * y, pose.y + s * x + c * y, z], flat = far * Math.cos(elevation);
    const end = [eye[0] + flat * Math.cos(pose.yaw + angle), eye[1] + flat * Math.sin(pose.yaw + angle), z + far * Math.sin(elevation)];
    found.push({ eye, end, heard: echo < reach, cone, elevation, scan });
  };
  for (const [sensor, all] of Object.entries({ ...beams, ...fans })) {
    const track = run.get(name, "scan", sensor), echoes = track?.at(t), pose = track && run.pose(name, track.since(t));
    if (!echoes || !pose) continue;
    if (Array.isArray(all)) all.forEach((beam, k) => ray(pose, beam, beam.yaw, echoes[k], ""));
    else echoes.forEach((echo, k) => ray(pose, all, all.yaw + k * all.step * track.ray, echo, sensor));
  }
  return found;
};
