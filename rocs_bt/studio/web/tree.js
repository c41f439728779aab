// The mission's tree at the cursor: status, message and ports of each node; branches fold, the failing path is marked.
import { color, el, prepare, put } from "./dom.js";

const SIGNS = { RUNNING: "▶", SUCCESS: "✓", FAILURE: "✗" };
const TINTS = { RUNNING: "running", SUCCESS: "good", FAILURE: "bad" };
const LARGE = 40, MAPPED = 24; // nodes from which on branches that never ran are folded, and a map is shown
const FRESH = 0.5; // [s] for which a change is marked

export class MissionTree {
  constructor(run, cursor) {
    Object.assign(this, { run, cursor, folded: new Set(), rows: [] });
    this.map = el("canvas", { class: "map", title: "All nodes, a row for each level: click to go to one." });
    this.list = el("ol", { class: "tree", role: "tree", tabindex: 0, "aria-label": "mission tree" });
    this.box = el("div", { class: "treebox" }, this.map, this.list);
    this.list.addEventListener("keydown", (event) => this.key(event));
    this.map.addEventListener("click", (event) => this.hit(event));
    cursor.addEventListener("move", () => this.update());
    cursor.addEventListener("agent", () => this.build());
    cursor.addEventListener("select", () => this.mark());
    this.build();
  }

  address(path) { return `${this.cursor.agent}|node|${path}`; }

  build() {
    const { run, cursor: { agent, t } } = this, parents = new Map(), depths = new Map();
    this.nodes = run.get(agent, "tree")?.at(t) ?? run.get(agent, "tree")?.v[0] ?? [];
    for (const { path, children = [] } of this.nodes) for (const child of children) parents.set(child, path);
    this.rows = this.nodes.map(({ path, type, children = [], ports = "" }) => {
      const parent = parents.get(path) ?? "", depth = parent ? depths.get(parent) + 1 : 0;
      depths.set(path, depth);
      const name = parent ? path.slice(parent.length + 1) : path, sign = el("i"), note = el("em");
      const fold = el("button", {
        class: "fold", tabindex: -1, "aria-label": "fold", onclick: (event) => { event.stopPropagation(); this.toggle(path); },
      });
      const item = el(
        "li", { role: "treeitem", onclick: () => this.cursor.select(this.address(path)) },
        fold, sign, el("b", {}, name), el("small", { class: "kind" }, name.startsWith(type) ? "" : type),
        el("small", { class: "ports" }, ports.replace(/^\(|\)$/g, "")), note,
      );
      item.style.paddingLeft = `${6 + 13 * depth}px`;
      const track = run.get(agent, "node", path), notes = run.get(agent, "note", path);
      return { path, parent, depth, children, item, sign, note, fold, track, notes, status: "" };
    });
    const empty = el("li", { class: "empty" }, "This mission has no tree: it is a planner in Python.");
    this.list.replaceChildren(...(this.rows.length ? this.rows.map((row) => row.item) : [empty]));
    this.map.hidden = this.rows.length < MAPPED;
    this.spread();
    const ran = ({ track }) => track && track.v.some((status) => status in SIGNS);
    this.folded = new Set(this.rows.length > LARGE ? this.rows.filter((row) => row.children.length && !ran(row)).map((row) => row.path) : []);
    this.fold();
    this.update();
  }

  /** Horizontal extent of each node on the map, of 1. */
  spread() {
    const leaves = new Map(), starts = new Map();
    for (const { path, children } of [...this.rows].reverse()) {
      leaves.set(path, children.reduce((sum, child) => sum + (leaves.get(child) ?? 0), 0) || 1);
    }
    for (const row of this.rows) {
      const start = starts.get(row.path) ?? 0, total = leaves.get(this.rows[0].path);
      Object.assign(row, { from: start / total, wide: leaves.get(row.path) / total });
      let next = start;
      for (const child of row.children) { starts.set(child, next); next += leaves.get(child) ?? 0; }
    }
  }

  toggle(path) {
    if (!this.folded.delete(path)) this.folded.add(path);
    this.fold();
  }

  fold() {
    const hidden = new Set();
    for (const { path, parent, item, fold, children } of this.rows) {
      if (hidden.has(parent) || this.folded.has(parent)) hidden.add(path);
      item.hidden = hidden.has(path);
      put(fold, children.length ? (this.folded.has(path) ? "▸" : "▾") : "");
      if (children.length) item.setAttribute("aria-expanded", String(!this.folded.has(path)));
    }
  }

  update() {
    const { cursor: { t, agent, selected, playing } } = this, tree = this.run.get(agent, "tree")?.at(t);
    if (tree && tree !== this.nodes) return this.build();
    const failed = new Set();
    for (const row of this.rows) {
      row.status = row.track?.at(t) ?? "";
      // The failing path goes from the root down: nodes that failed, below a parent on the path.
      if (row.status === "FAILURE" && (row.depth === 0 || failed.has(row.parent))) failed.add(row.path);
      const fresh = row.track && t - row.track.since(t) < FRESH;
      const names = [
        row.status.toLowerCase() || "unticked", failed.has(row.path) && "path", fresh && "fresh",
        selected === this.address(row.path) && "selected",
      ].filter(Boolean).join(" ");
      if (row.item.className !== names) {
        row.item.className = names;
        put(row.sign, SIGNS[row.status] ?? "·");
        row.sign.title = row.status || "not ticked";
      }
      put(row.note, row.notes?.at(t) ?? "");
    }
    this.draw();
    if (playing) this.rows.findLast((row) => row.status === "RUNNING" && !row.item.hidden)?.item.scrollIntoView({ block: "nearest" });
  }

  draw() {
    const wide = this.map.clientWidth;
    if (this.map.hidden || !wide) return;
    const levels = 1 + Math.max(...this.rows.map((row) => row.depth)), high = Math.min(48, levels * 6), each = high / levels;
    if (this.size !== `${wide} ${high}`) {
      this.size = `${wide} ${high}`;
      this.map.style.height = `${high}px`;
      this.g = prepare(this.map, wide, high);
    }
    this.g.clearRect(0, 0, wide, high);
    for (const { from, wide: part, depth, status } of this.rows) {
      this.g.fillStyle = color(TINTS[status] ?? "line");
      this.g.fillRect(from * wide, depth * each, Math.max(1, part * wide - 1), each - 1);
    }
    this.levels = levels;
  }

  hit(event) {
    const box = this.map.getBoundingClientRect(), x = (event.clientX - box.left) / box.width;
    const depth = Math.floor(((event.clientY - box.top) / box.height) * this.levels);
    const row = this.rows.find((r) => r.depth === depth && r.from <= x && x < r.from + r.wide);
    if (row) this.cursor.select(this.address(row.path));
  }

  /** Unfolds the branches above the selected node and scrolls to it. */
  mark() {
    const rows = new Map(this.rows.map((row) => [row.path, row]));
    const row = this.rows.find(({ path }) => this.address(path) === this.cursor.selected);
    for (let above = row && rows.get(row.parent); above; above = rows.get(above.parent)) this.folded.delete(above.path);
    this.fold();
    this.update();
    row?.item.scrollIntoView({ block: "nearest" });
  }

  key(event) {
    const open = this.rows.filter((row) => !row.item.hidden), at = open.findIndex((row) => row.item.classList.contains("selected"));
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: open.length - 1 }[event.key];
    if (to === undefined && event.key !== "Enter") return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === "Enter" && open[at]) this.toggle(open[at].path);
    else if (open[to]) this.cursor.select(this.address(open[to].path));
  }
}
