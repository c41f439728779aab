// @ts-check
// The arena from above: world, paths, robots with their rays, and what the shown robot believes.
import { View } from "./cursor.js";
import { color, el, face, prepare, seconds, upto, widthOf } from "./dom.js";
import { OwnMap, believed, motion, rays, ways } from "./scene.js";

const PAD = 14, TOP = 38, HIGH = 0.4; // [px], at the top below the buttons; [m] from which on a height is written
const NEAR = 2.5; // zoom with which the robot is followed
const FINE = 2; // [px] between the points of a way that are drawn
const STEEP = 0.5; // cosine of the elevation below which a beam is not drawn
const LINE = 14, SIDE = 8, CORE = 7; // [px] height of a label, its distance, half of what it leaves free

/** Point of a body in the world. */
const placed = (pose, /** @type {number[]} */ [x, y]) => {
  const c = Math.cos(pose.yaw), s = Math.sin(pose.yaw);
  return [pose.x + c * x - s * y, pose.y + s * x + c * y];
};

/** Left and baseline of a label of a width at a point, inside the picture and beside what has a box; adds its box. Undefined without room. */
export const beside = (boxes, /** @type {number[]} */ [x, y], wide, /** @type {number[]} */ [edge, bottom]) => {
  const right = x + SIDE, left = x - SIDE - wide, middle = x - wide / 2;
  const sides = [[right, -SIDE], [left, -SIDE], [right, LINE + 2], [left, LINE + 2], [middle, -2 * LINE], [middle, 2 * LINE]];
  const places = [0, 1, 2].flatMap((far) => sides.map(([at, up]) => [at, y + up + Math.sign(up) * far * LINE]));
  const inside = (/** @type {number[]} */ [at, base]) => at >= 2 && at + wide <= edge - 2 && base >= LINE && base <= bottom - 4;
  const free = (/** @type {number[]} */ [at, base]) => !boxes.some((box) => at < box[2] && box[0] < at + wide && base - LINE < box[3] && box[1] < base);
  const found = places.find((place) => inside(place) && free(place));
  if (found) boxes.push([found[0], found[1] - LINE, found[0] + wide, found[1]]);
  return found;
};

const put = (g, text, /** @type {number[]} */ [left, base]) => {
  g.strokeStyle = color("paper");
  g.lineWidth = 3;
  g.strokeText(text, left, base);
  g.fillText(text, left, base);
};

/** Writes the first of some texts for which there is room beside a point; `least` is written if there is none. */
export const write = (g, boxes, texts, point, size, least = "") => {
  for (const text of texts) {
    const place = beside(boxes, point, widthOf(g, text), size);
    if (place) return put(g, text, place);
  }
  return least && put(g, least, [Math.max(2, Math.min(point[0] + SIDE, size[0] - widthOf(g, least) - 2)), point[1] - SIDE]);
};

const isDoor = ({ states = {} }) => Object.keys(states).length > 0;

/** Writes the names of bodies at a time, first that of an agent; `at` tells where the pose of a body is in the picture. */
export const names = (g, boxes, run, agent, t, at, size) => {
  const first = ({ name }) => Number(name === agent), bodies = [...run.header.bodies].sort((a, b) => first(b) - first(a));
  const points = new Map(bodies.map(({ name }) => [name, run.pose(name, t)]).filter(([, pose]) => pose).map(([name, pose]) => [name, at(pose)]));
  for (const [x, y] of points.values()) boxes.push([x - CORE, y - CORE, x + CORE, y + CORE]);
  for (const body of bodies.filter(({ name }) => points.has(name))) {
    const { name } = body, point = points.get(name), pose = run.pose(name, t), track = isDoor(body) && run.get(name, "actor"), state = track && track.at(t);
    g.fillStyle = color(run.agents.includes(name) ? "ink" : "actor");
    face(g, 12, name === agent ? 600 : 400);
    const dead = run.of(name, "sensor").filter((sensor) => sensor.at(t)).map((sensor) => `, no data of ${sensor.name}`).join("");
    const high = `${name}${pose.z > HIGH ? `, ${pose.z.toFixed(2)} m high` : ""}${dead}`;
    write(g, boxes, [state ? `${name}: ${state} since ${seconds(track.since(t))}` : high, name], point, size, name === agent || dead ? name : "");
  }
};

export class Arena extends View {
  constructor(run, cursor, layers) {
    super(run, cursor, el("canvas", { "aria-label": "arena from above" }));
    this.layers = layers;
    this.zoom = 1;
    this.shift = [0, 0];
    this.scale = 1;
    this.map = new OwnMap(run);
    this.canvas = this.box;
    this.still = el("canvas");
    this.area = this.bounds();
    this.canvas.addEventListener("click", (event) => this.pick(event));
    this.canvas.addEventListener("dblclick", () => { this.zoom = 1; this.shift = [0, 0]; this.fit(); });
    this.canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.magnify(event); }, { passive: false });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 1) return;
      this.shift = [this.shift[0] + event.movementX, this.shift[1] + event.movementY];
      this.fit();
    });
    layers.addEventListener("change", () => {
      if (layers.follow && this.zoom === 1) this.zoom = NEAR;
      if (!layers.follow && this.zoom === NEAR) this.zoom = 1;
      this.fit();
    });
  }

  /** Takes what is new in a run that goes on: a robot may leave the bounds of an unknown world. */
  grow() {
    const area = this.bounds();
    if (area.some((edge, i) => Math.abs(edge - this.area[i]) > 0.5)) { this.area = area; this.fit(); }
  }

  /** Bounds of everything that is drawn [m]: left, bottom, right, top. */
  bounds() {
    const { outlines = [], grounds = [], places = [], bodies = [] } = this.run.header, box = [Infinity, Infinity, -Infinity, -Infinity];
    const add = (x, y, r = 0) => {
      if (!Number.isFinite(x + y)) return;
      box[0] = Math.min(box[0], x - r); box[1] = Math.min(box[1], y - r);
      box[2] = Math.max(box[2], x + r); box[3] = Math.max(box[3], y + r);
    };
    for (const { points, radius = 0 } of [...outlines, ...grounds]) for (const [x, y] of points) add(x, y, radius);
    for (const { x, y, radius = 0 } of places) add(x, y, radius);
    for (const { name } of bodies) {
      const track = this.run.get(name, "pose");
      for (let i = 0; track && i < track.t.length; i++) add(track.v[i * track.width], track.v[i * track.width + 1]);
    }
    return box[0] < box[2] ? box : [-1, -1, 1, 1];
  }

  fit() {
    const { clientWidth: wide, clientHeight: high } = this.canvas.parentElement ?? this.canvas;
    if (!wide || !high) return;
    this.wide = wide;
    this.high = high;
    const [x0, y0, x1, y1] = this.area, fits = Math.min((wide - 2 * PAD) / (x1 - x0), (high - TOP - PAD) / (y1 - y0));
    this.scale = Math.max(1e-3, fits) * this.zoom;
    this.left = wide / 2 - (this.scale * (x0 + x1)) / 2 + this.shift[0];
    this.top = (high + TOP - PAD) / 2 + (this.scale * (y0 + y1)) / 2 + this.shift[1];
    this.g = prepare(this.canvas, wide, high);
    this.world(prepare(this.still, wide, high));
    this.update();
  }

  x(x) { return this.left + x * this.scale; }

  y(y) { return this.top - y * this.scale; }

  /** Point of the world under a pointer [m]. */
  under(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left - this.left) / this.scale, (this.top - (event.clientY - box.top)) / this.scale];
  }

  magnify(event) {
    const [x, y] = this.under(event), box = this.canvas.getBoundingClientRect();
    this.zoom = Math.min(40, Math.max(0.5, this.zoom * Math.exp(-event.deltaY * 0.0015)));
    this.fit();
    this.shift[0] += event.clientX - box.left - this.x(x);
    this.shift[1] += event.clientY - box.top - this.y(y);
    this.fit();
  }

  line(g, points, closed = true) {
    g.beginPath();
    points.forEach(([x, y], i) => (i ? g.lineTo(this.x(x), this.y(y)) : g.moveTo(this.x(x), this.y(y))));
    if (closed) g.closePath();
  }

  circle(g, x, y, r) {
    g.beginPath();
    g.arc(this.x(x), this.y(y), r, 0, 2 * Math.PI);
  }

  /** Draws what does not move; once for each size and zoom. */
  world(g) {
    const { outlines = [], grounds = [], places = [], bodies = [] } = this.run.header;
    g.fillStyle = color("wall");
    g.strokeStyle = color("muted");
    g.globalAlpha = 0.3;
    for (const { points } of grounds) { this.line(g, points); g.fill(); }
    g.globalAlpha = 1;
    for (const { points, radius = 0 } of outlines) {
      if (radius) this.circle(g, points[0][0], points[0][1], radius * this.scale); else this.line(g, points);
      g.fill();
      g.stroke();
    }
    g.fillStyle = color("good");
    face(g, 12);
    this.fixed = [];
    this.signs = [];
    for (const { x, y, name, radius = 0, known = true } of places) {
      const r = Math.max(radius * this.scale, 4);
      g.strokeStyle = color("good");
      g.lineWidth = 1.4;
      this.circle(g, x, y, r);
      g.stroke();
      const point = [this.x(x) + r - 3, this.y(y) + 8], place = known && beside(this.fixed, point, widthOf(g, name), [this.wide, this.high]);
      if (place) this.signs.push([name, place]);
    }
    g.lineWidth = 1;
    g.globalAlpha = 0.35;
    g.strokeStyle = color("muted");
    for (const { name } of bodies) this.way(g, name, -Infinity, Infinity);
    g.globalAlpha = 1;
  }

  way(g, body, from, to) {
    const track = this.run.get(body, "pose");
    if (!track) return;
    let at = [NaN, NaN];
    g.beginPath();
    for (let i = Math.max(0, upto(track.t, from) - 1), last = upto(track.t, to); i < last; i++) {
      const x = this.x(track.v[i * track.width]), y = this.y(track.v[i * track.width + 1]);
      if (Math.abs(x - at[0]) + Math.abs(y - at[1]) < FINE && i < last - 1) continue;
      g.lineTo(x, y);
      at = [x, y];
    }
    g.stroke();
  }

  update() {
    const { g, run, cursor: { t, agent } } = this;
    if (!g) return;
    const { layers } = this, eye = layers.follow && run.pose(agent, t);
    if (eye) {
      this.left = this.wide / 2 - this.scale * eye.x;
      this.top = this.high / 2 + this.scale * eye.y;
      this.world(prepare(this.still, this.wide, this.high));
    }
    g.clearRect(0, 0, this.wide, this.high);
    g.drawImage(this.still, 0, 0, this.wide, this.high);
    if (layers.map) this.mapped(g, agent, t);
    g.lineJoin = "round";
    g.lineWidth = 2;
    for (const { name } of layers.way ? run.header.bodies : []) {
      for (const { from, to, tint } of ways(run, name, t)) {
        g.strokeStyle = color(tint);
        this.way(g, name, from, to);
      }
    }
    if (layers.plan) this.planned(g, run.get(agent, "path")?.at(t));
    for (const info of run.header.bodies) {
      const pose = run.pose(info.name, t);
      if (!pose) continue;
      if (info.name === agent && layers.rays) this.rays(g, info, t);
      this.body(g, info, pose);
    }
    const boxes = [...this.fixed];
    face(g, 12);
    g.fillStyle = color("good");
    for (const [name, place] of this.signs) put(g, name, place);
    names(g, boxes, run, agent, t, ({ x, y }) => [this.x(x), this.y(y)], [this.wide, this.high]);
    if (layers.beliefs) this.believed(g, boxes, t);
  }

  /** Draws the occupied cells of a robot's own map. */
  mapped(g, agent, t) {
    const { cell, cells } = this.map.at(agent, t), side = Math.max(2, cell * this.scale);
    g.fillStyle = color("belief");
    g.globalAlpha = 0.45;
    for (const [x, y] of cells) g.fillRect(this.x(x * cell), this.y((y + 1) * cell), side, side);
    g.globalAlpha = 1;
  }

  planned(g, points) {
    if (!points?.length) return;
    g.strokeStyle = color("deliberative");
    g.setLineDash([2, 4]);
    this.line(g, points, false);
    g.stroke();
    g.setLineDash([]);
  }

  rays(g, info, t) {
    /** @type {any[][]} */
    const scans = [];
    g.fillStyle = g.strokeStyle = color("belief");
    for (const ray of rays(this.run, info, t)) {
      if (!ray.scan && Math.cos(ray.elevation) >= STEEP) this.beam(g, ray);
      if (ray.scan && ray.scan !== scans.at(-1)?.[0].scan) scans.push([ray]); else if (ray.scan) scans.at(-1)?.push(ray);
    }
    for (const scan of scans) this.fan(g, scan);
    g.globalAlpha = 1;
  }

  beam(g, { eye: [x, y], end: [to, up], heard, cone }) {
    const angle = Math.atan2(up - y, to - x), r = Math.hypot(to - x, up - y) * this.scale;
    g.globalAlpha = heard ? 0.35 : 0.07;
    g.beginPath();
    g.moveTo(this.x(x), this.y(y));
    if (cone > 0) {
      g.arc(this.x(x), this.y(y), r, -angle - cone / 2, -angle + cone / 2);
      g.fill();
    } else {
      g.lineTo(this.x(to), this.y(up));
      g.stroke();
    }
  }

  fan(g, scan) {
    g.globalAlpha = 0.08;
    this.line(g, [scan[0].eye, ...scan.map(({ end }) => end)]);
    g.fill();
    g.globalAlpha = 0.9;
    for (const { end: [x, y], heard } of scan) if (heard) g.fillRect(this.x(x) - 1.2, this.y(y) - 1.2, 2.4, 2.4);
  }

  body(g, info, pose) {
    const { run, cursor: { t, agent } } = this, { name, hull = [] } = info, shown = name === agent, door = isDoor(info);
    const tint = color(run.agents.includes(name) ? run.get(name, "route")?.at(t) ?? "idle" : "actor");
    if (hull.length) {
      this.line(g, hull.map((point) => placed(pose, point)));
      g.fillStyle = door ? tint : color("paper");
      g.fill();
      g.strokeStyle = tint;
      g.lineWidth = shown ? 3 : 1.6;
      g.stroke();
    }
    if (door) return;
    const nose = 0.85 * Math.max(0.15, ...hull.map(([x]) => x)), half = 0.25 * nose;
    this.line(g, [[nose, 0], [nose - half, half * 0.8], [nose - half, -half * 0.8]].map((point) => placed(pose, point)));
    g.fillStyle = tint;
    g.fill();
  }

  /** Draws a believed mover: its outline, two standard deviations around it, and its way in the next second. */
  moving(g, [x, y, yaw], { radius, speed, spread }) {
    this.circle(g, x, y, radius * this.scale);
    g.stroke();
    g.setLineDash([2, 3]);
    this.circle(g, x, y, (radius + 2 * spread) * this.scale);
    g.stroke();
    g.setLineDash([]);
    const tip = { x: x + speed * Math.cos(yaw), y: y + speed * Math.sin(yaw), yaw };
    this.line(g, [[x, y], placed(tip, [0, 0]), placed(tip, [-0.12, 0.08]), placed(tip, [0, 0]), placed(tip, [-0.12, -0.08])], false);
    g.stroke();
  }

  /** Draws objects with a position in the knowledge of the shown robot, as diamonds. */
  believed(g, boxes, t) {
    g.fillStyle = color("belief");
    face(g, 11);
    for (const [node, at] of believed(this.run, this.cursor.agent, t)) {
      const x = this.x(at[0]), y = this.y(at[1]);
      g.beginPath();
      for (const [dx, dy] of [[0, -6], [6, 0], [0, 6], [-6, 0]]) g.lineTo(x + dx, y + dy);
      g.closePath();
      g.strokeStyle = color("belief");
      g.lineWidth = 1.5;
      g.stroke();
      const moves = motion(this.run, this.cursor.agent, node, t);
      if (moves) this.moving(g, at, moves);
      write(g, boxes, [node], [x, y + 6], [this.wide, this.high]);
    }
  }

  /** Selects the robot or actor under the pointer. */
  pick(event) {
    const [x, y] = this.under(event), { run, cursor } = this;
    const near = run.header.bodies.map(({ name }) => ({ name, pose: run.pose(name, cursor.t) })).filter(({ pose }) => pose)
      .map(({ name, pose }) => ({ name, far: Math.hypot(pose.x - x, pose.y - y) })).sort((a, b) => a.far - b.far)[0];
    if (near && near.far < Math.max(0.4, 18 / this.scale)) cursor.select(`${near.name}|${run.agents.includes(near.name) ? "pose" : "actor"}|`);
  }
}
