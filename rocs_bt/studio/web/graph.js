// @ts-check
// The knowledge at the cursor as a graph: the robot in the middle, the other nodes on rings by their distance to it.
import { color, el, face, prepare, shown, upto } from "./dom.js";

const DOT = 6, CROWD = 60; // [px]; number of nodes above which only names near the pointer or selected are written

export class Graph {
  constructor(run, cursor) {
    this.run = run;
    this.cursor = cursor;
    this.canvas = el("canvas", { class: "graph", "aria-label": "knowledge as a graph" });
    this.canvas.addEventListener("click", (event) => this.pick(event));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.build();
  }

  /** Nodes and relations of the whole run, so that the places do not change with the time. */
  build() {
    const { run, cursor: { agent } } = this;
    this.nodes = new Map();
    this.edges = [];
    for (const track of run.of(agent, "fact")) {
      const [node, relation, target] = track.name.split("\n");
      if (relation === undefined) this.nodes.set(node, { name: node, track, kind: track.v.find((v) => v) ?? "", x: 0, y: 0 });
      else if (target !== undefined) this.edges.push({ track, from: node, to: target, relation });
    }
    this.edges = this.edges.filter(({ from, to }) => this.nodes.has(from) && this.nodes.has(to));
    this.place(agent);
  }

  /** Places the nodes on rings; the radius of the outermost is 1. */
  place(root) {
    const near = new Map([...this.nodes.keys()].map((name) => [name, []])), rings = [], seen = new Set();
    for (const { from, to } of this.edges) { near.get(from).push(to); near.get(to).push(from); }
    let ring = this.nodes.has(root) ? [root] : [...this.nodes.keys()];
    while (ring.length) {
      rings.push(ring);
      for (const name of ring) seen.add(name);
      ring = [...new Set(ring.flatMap((name) => near.get(name)))].filter((name) => !seen.has(name));
      if (!ring.length) ring = [...this.nodes.keys()].filter((name) => !seen.has(name));
    }
    rings.forEach((names, i) => names.forEach((name, k) => {
      const angle = (2 * Math.PI * k) / names.length - Math.PI / 2 + i * 0.4, r = rings.length > 1 ? i / (rings.length - 1) : 1;
      Object.assign(this.nodes.get(name), { x: names.length > 1 || i ? r * Math.cos(angle) : 0, y: names.length > 1 || i ? r * Math.sin(angle) : 0 });
    }));
  }

  draw() {
    const { clientWidth: wide, clientHeight: high } = this.canvas, { cursor: { t, selected, agent } } = this;
    if (!wide || !high) return;
    const g = prepare(this.canvas, wide, high), crowd = this.nodes.size > CROWD, [, , ...path] = selected.split("|"), chosen = path.join("|").split("\n")[0];
    const known = (track) => (track.at(t) ?? null) !== null, fresh = (track) => this.run.change(track, t);
    this.at = ({ x, y }) => [wide / 2 + x * (wide / 2 - 90), high / 2 + y * (high / 2 - 34)];
    face(g, 11);
    g.lineWidth = 1.2;
    for (const { track, from, to, relation } of this.edges) {
      if (!known(track)) continue;
      const [x0, y0] = this.at(this.nodes.get(from)), [x1, y1] = this.at(this.nodes.get(to)), mine = chosen === from || chosen === to;
      g.strokeStyle = color(mine ? "ink" : fresh(track) ? "belief" : "wall");
      g.beginPath();
      g.moveTo(x0, y0);
      g.lineTo(x1, y1);
      const angle = Math.atan2(y1 - y0, x1 - x0), [ax, ay] = [x1 - (DOT + 3) * Math.cos(angle), y1 - (DOT + 3) * Math.sin(angle)];
      for (const turn of [0.4, -0.4]) { g.moveTo(ax, ay); g.lineTo(ax - 7 * Math.cos(angle + turn), ay - 7 * Math.sin(angle + turn)); }
      g.stroke();
      if (mine || !crowd) this.write(g, relation, (x0 + x1) / 2, (y0 + y1) / 2 + 3, "muted", "center");
    }
    for (const node of this.nodes.values()) {
      if (!known(node.track)) continue;
      const [x, y] = this.at(node);
      g.fillStyle = color("belief");
      g.beginPath();
      g.arc(x, y, node.name === chosen ? DOT + 2 : DOT, 0, 2 * Math.PI);
      g.fill();
      if (fresh(node.track)) { g.strokeStyle = color("ink"); g.lineWidth = 3; g.stroke(); g.lineWidth = 1.2; }
      if (crowd && node.name !== chosen && node.name !== agent) continue;
      const left = node.x < -0.01, kind = crowd || !node.kind ? "" : ` (${node.kind})`;
      this.write(g, `${shown(node.name)}${kind}`, x + (left ? -10 : 10), y + 4, "ink", left ? "right" : "left");
    }
  }

  write(g, text, x, y, tint, align) {
    g.textAlign = align;
    g.lineWidth = 3;
    g.strokeStyle = color("paper");
    g.strokeText(text, x, y);
    g.fillStyle = color(tint);
    g.fillText(text, x, y);
    g.lineWidth = 1.2;
  }

  /** Selects the node under the pointer. */
  pick(event) {
    const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const far = (node) => { const [nx, ny] = this.at(node); return Math.hypot(nx - x, ny - y); };
    const near = [...this.nodes.values()].filter(({ track }) => upto(track.t, this.cursor.t)).sort((a, b) => far(a) - far(b))[0];
    if (near && far(near) < 3 * DOT) this.cursor.select(near.track.address);
  }
}
