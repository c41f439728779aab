// @ts-check
// The arena in space: the same world, bodies and cursor, with the shapes of the bodies.
import { names, write } from "./arena.js";
import { View } from "./cursor.js";
import { color, dark, el, face, prepare, upto } from "./dom.js";
import { OwnMap, believed, rays, ways } from "./scene.js";
import { View3d, placed, times } from "./view3d.js";

const LIFT = 0.02, CLOSE = 3; // [m] height of lines over the ground; distance from which a robot is followed
const LOW = 0.3; // [m] height of what has none in the header

/** Red, green and blue of a colour of the style sheet. */
const rgb = (name) => {
  const text = color(name), full = text.length === 4 ? text.replace(/[0-9a-f]/g, "$&$&") : text;
  return [1, 3, 5].map((i) => parseInt(full.slice(i, i + 2), 16) / 255);
};

/** Quaternion of yaw, pitch and roll. */
const turned = (yaw, pitch = 0, roll = 0) => {
  const [[cy, sy], [cp, sp], [cr, sr]] = [yaw, pitch, roll].map((angle) => [Math.cos(angle / 2), Math.sin(angle / 2)]);
  return [cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr];
};

/** Matrix of a joint at a value: a turn about its axis, or a shift along it. */
const moved = ({ axis: [x, y, z], turns }, value) => {
  if (!turns) return placed([x * value, y * value, z * value]);
  const s = Math.sin(value / 2);
  return placed([0, 0, 0], [Math.cos(value / 2), x * s, y * s, z * s]);
};

/** Colour of a shape, nearly grey: strong colours have a meaning on this page. */
const pale = ([r, g, b]) => [r, g, b].map((part) => {
  const grey = 0.12 * part + 0.88 * (0.3 * r + 0.6 * g + 0.1 * b);
  return dark.matches ? 0.4 + 0.6 * grey : grey;
});

/** Point of a ray shortly before its end: of a scan only the echoes are drawn. */
const tip = (eye, end) => {
  const part = 1 - Math.min(1, 0.06 / Math.hypot(...end.map((value, i) => value - eye[i])));
  return eye.map((value, i) => value + part * (end[i] - value));
};

const circle = ([x, y], r) => Array.from({ length: 24 }, (_, i) => [x + r * Math.cos((i * Math.PI) / 12), y + r * Math.sin((i * Math.PI) / 12)]);

export class Space extends View {
  constructor(run, cursor, area, layers) {
    super(run, cursor, el("canvas", { hidden: true, "aria-label": "arena in space" }));
    this.area = area;
    this.layers = layers;
    this.map = new OwnMap(run);
    this.canvas = this.box;
    this.names = el("canvas", { class: "names", hidden: true });
    layers.addEventListener("change", () => this.aim());
    dark.addEventListener("change", () => setTimeout(() => { this.view = null; this.update(); }));
  }

  /** Shapes of the world, which is body 0, and of all bodies. */
  shapes() {
    const { outlines = [], grounds = [], bodies } = this.run.header, still = { position: [0, 0, 0], quaternion: [1, 0, 0, 0] };
    const world = [...outlines, ...grounds].map(({ points, radius = 0, height = 0 }) => (
      { kind: "prism", size: [radius > 0 ? circle(points[0], radius) : points, height || LOW], ...still, body: 0, tint: [...rgb("wall"), 1] }
    ));
    const acts = (name) => !this.run.agents.includes(name), own = (name) => [...rgb(acts(name) ? "actor" : "curve"), 1];
    let frame = 1; // of the body; then one for each of its links
    const robots = bodies.flatMap(({ name, hull = [], height = LOW, shapes = [], links = [] }) => {
      const first = frame;
      frame += 1 + links.length;
      const tinted = ({ tint }) => (acts(name) ? own(name) : [...pale(tint), 1]), seen = shapes.filter(({ tint }) => tint[3] > 0);
      if (shapes.length) return seen.map((shape) => ({ ...shape, tint: tinted(shape), body: first + shape.link }));
      return hull.length ? [{ kind: "prism", size: [hull, height], ...still, body: first, tint: own(name) }] : [];
    });
    return [...world, ...robots];
  }

  /** Matrices of a body and of its links at a time; without its pose they are not drawn. */
  frames({ name, base = 0, shapes = [], links = [] }, t) {
    const p = this.run.pose(name, t), angles = this.run.get(name, "joints")?.between(t) ?? [];
    if (!p) return Array(1 + links.length).fill(null);
    const found = [placed([p.x, p.y, p.z ?? (shapes.length ? base : 0)], turned(p.yaw, p.pitch, p.roll))];
    links.forEach((link, i) => {
      found.push(times(times(found[link.parent], placed(link.position, link.quaternion)), moved(link, angles[i] ?? 0)));
    });
    return found;
  }

  /** The view, made when it is first shown; null without WebGL. */
  get made() {
    if (!this.view && !this.broken) {
      const [x0, y0, x1, y1] = this.area;
      this.far = 0.95 * Math.hypot(x1 - x0, y1 - y0) * Math.max(1, (1.5 * this.canvas.clientHeight) / (this.canvas.clientWidth || 1));
      try {
        this.view = new View3d(this.canvas, this.shapes(), [(x0 + x1) / 2, (y0 + y1) / 2, LOW], this.far);
        this.view.drawn = () => this.named();
      } catch (error) {
        this.broken = error.message;
      }
    }
    return this.view;
  }

  update() {
    if (this.canvas.hidden || !this.made) return;
    const { run, cursor: { t, agent }, view } = this;
    view.sky = rgb("raised");
    const matrices = run.header.bodies.flatMap((body) => this.frames(body, t));
    const eye = this.layers.follow && run.pose(agent, t);
    if (eye) view.target = [eye.x, eye.y, eye.z ?? LOW];
    view.draw([placed([0, 0, 0]), ...matrices], this.lines(agent, t));
  }

  /** Writes names over the picture: of places and of bodies. */
  named() {
    const { run, cursor: { t, agent }, view, canvas: { clientWidth: wide, clientHeight: high } } = this, g = prepare(this.names, wide, high), boxes = [];
    face(g, 12);
    for (const { x, y, name, known = true } of run.header.places ?? []) {
      g.fillStyle = color("good");
      if (known) write(g, boxes, [name], view.seen([x, y, LIFT]), [wide, high]);
    }
    names(g, boxes, run, agent, t, ({ x, y, z = LOW }) => view.seen([x, y, z]), [wide, high]);
  }

  /** Points the camera at the robot that it follows, or at the world. */
  aim() {
    if (!this.view) return;
    const [x0, y0, x1, y1] = this.area, { follow } = this.layers;
    if (follow !== this.follows) Object.assign(this.view, { target: [(x0 + x1) / 2, (y0 + y1) / 2, LOW], distance: follow ? CLOSE : this.far });
    this.follows = follow;
    this.update();
  }

  /** Lines of the layers: the way driven, the planned path, places, rays, the robot's own map and what it believes. */
  lines(agent, t) {
    const { run, layers } = this, found = [], add = (name, points, pairs = false) => found.push({ points, pairs, tint: [...rgb(name), 1] });
    for (const { name } of layers.way ? run.header.bodies : []) {
      const track = run.get(name, "pose"), point = ([x, y, , z = 0]) => [x, y, z + LIFT];
      for (const { from, to, tint } of track ? ways(run, name, t) : []) {
        const first = Math.max(0, upto(track.t, from) - 1);
        add(tint, Array.from({ length: upto(track.t, to) - first }, (_, i) => point(track.row(first + i))));
      }
    }
    const plan = layers.plan && run.get(agent, "path")?.at(t), info = run.header.bodies.find(({ name }) => name === agent);
    if (plan) add("deliberative", plan.flatMap(([x, y], i) => (i ? [[plan[i - 1][0], plan[i - 1][1], LIFT], [x, y, LIFT]] : [])), true);
    for (const { x, y, radius = 0 } of run.header.places ?? []) {
      const ring = circle([x, y], Math.max(radius, 0.1));
      add("good", [...ring, ring[0]].map((point) => [...point, LIFT]));
    }
    if (layers.rays && info) add("belief", rays(run, info, t).flatMap(({ eye, end, heard, scan }) => (!heard ? [] : [scan ? tip(eye, end) : eye, end])), true);
    if (layers.map) {
      const { cell, cells } = this.map.at(agent, t);
      add("belief", [...cells].flatMap(([x, y]) => [[x * cell, y * cell, LIFT], [(x + 1) * cell, (y + 1) * cell, LIFT]]), true);
    }
    for (const [, [x, y]] of layers.beliefs ? believed(run, agent, t) : []) {
      add("belief", [[x - 0.15, y, LIFT], [x, y - 0.15, LIFT], [x + 0.15, y, LIFT], [x, y + 0.15, LIFT], [x - 0.15, y, LIFT]]);
    }
    return found;
  }
}
