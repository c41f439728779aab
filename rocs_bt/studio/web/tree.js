// @ts-check
// The mission at the cursor: its tree with states, values of ports and messages, and its blackboards.
import { View } from "./cursor.js";
import { afterwards, color, el, prepare, put, reveal, search, short, shown, styled, upto } from "./dom.js";
import { Fact } from "./panels.js";
import { portsOf } from "./run.js";

const SIGNS = { RUNNING: "▶", SUCCESS: "✓", FAILURE: "✗" };
const TINTS = { RUNNING: "deliberative", SUCCESS: "good", FAILURE: "bad" };
const LARGE = 40, MAPPED = 24; // nodes from which on only what runs is unfolded, and a map is shown

export class MissionTree extends View {
  constructor(run, cursor) {
    super(run, cursor);
    this.rows = [];
    /** @type {Map<string, boolean>} branches that a reader has opened or folded */
    this.chosen = new Map();
    this.open = new Set();
    this.map = el("canvas", { class: "map", title: "All nodes, a row for each level: click to go to one." });
    this.find = search("search nodes (n)", () => this.fold());
    this.tools = el("div", { class: "tools" }, this.find);
    this.list = el("ol", { class: "tree", role: "tree", tabindex: 0, "aria-label": "mission tree" });
    this.board = new Blackboard(run, cursor);
    this.box = el("div", { class: "treebox" }, this.tools, this.map, this.list, this.board.box);
    this.list.addEventListener("keydown", (event) => this.key(event));
    this.map.addEventListener("click", (event) => this.hit(event));
    cursor.addEventListener("select", () => this.mark());
    this.build();
  }

  address(path) { return `${this.cursor.agent}|node|${path}`; }

  build() {
    const { run, cursor: { agent, t } } = this, parents = new Map(), depths = new Map();
    this.nodes = run.get(agent, "tree")?.at(t) ?? run.get(agent, "tree")?.v[0] ?? [];
    for (const { path, children = [] } of this.nodes) for (const child of children) parents.set(child, path);
    this.rows = this.nodes.map((node) => {
      const parent = parents.get(node.path) ?? "", depth = parent ? depths.get(parent) + 1 : 0;
      depths.set(node.path, depth);
      return this.row(node, parent, depth);
    });
    this.at = new Map(this.rows.map((row) => [row.path, row]));
    const empty = el("li", { class: "empty" }, "This mission has no tree: it is a planner in Python.");
    this.list.replaceChildren(...(this.rows.length ? this.rows.map((row) => row.item) : [empty]));
    this.map.hidden = this.rows.length < MAPPED;
    this.tools.hidden = this.rows.length < MAPPED;
    this.size = "";
    this.chosen.clear();
    this.spread();
    this.update();
    this.fold();
  }

  row(node, parent, depth) {
    const { run, cursor: { agent } } = this, { path, type, children = [], ports = "" } = node;
    const name = parent ? path.slice(parent.length + 1) : path, sign = el("i"), note = el("em"), tries = el("small", { class: "tries" });
    const fold = el("button", { class: "fold", tabindex: -1, "aria-label": "fold", onclick: (event) => { event.stopPropagation(); this.toggle(path); } });
    const given = portsOf(node).map((port) => {
      const value = el("span", {}, port.given);
      return { ...port, value, box: el("span", { class: port.entry ? "port key" : "port", title: `${port.name} = ${port.given}` }, `${port.name} `, value) };
    });
    const kind = name.startsWith(type) ? null : el("small", { class: "kind" }, type);
    const item = el(
      "li", { role: "treeitem", onclick: () => this.cursor.select(this.address(path)) },
      fold, sign, el("b", {}, name), tries, kind, el("small", { class: "ports" }, ...given.map((port) => port.box)), note,
    );
    item.style.paddingLeft = `${4 + 12 * depth}px`;
    const text = `${path} ${type} ${ports}`.toLowerCase(), track = run.get(agent, "node", path);
    return {
      path, parent, depth, children, item, sign, note, tries, fold, text, ports: given.filter((port) => port.entry), status: "",
      track, began: track?.attempts.map((each) => each.from) ?? [], notes: run.get(agent, "note", path), from: 0, wide: 0,
    };
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
    this.chosen.set(path, !this.opened(path));
    this.fold();
  }

  /** Whether a branch is unfolded: as chosen; of a large tree only if it is on the way to what runs, failed or is selected. */
  opened(path) { return this.chosen.get(path) ?? (this.rows.length <= LARGE || this.open.has(path)); }

  fold() {
    const hidden = new Set(), word = this.find.value.trim().toLowerCase(), found = new Set();
    if (word) {
      for (const row of this.rows) {
        if (row.text.includes(word)) for (let above = row; above && !found.has(above.path); above = this.at.get(above.parent)) found.add(above.path);
      }
    }
    for (const { path, parent, item, fold, children, text } of this.rows) {
      const open = word ? true : this.opened(path);
      if (word ? !found.has(path) : parent && (hidden.has(parent) || !this.opened(parent))) hidden.add(path);
      item.hidden = hidden.has(path);
      item.classList.toggle("found", Boolean(word) && text.includes(word));
      put(fold, children.length ? (open ? "▾" : "▸") : "");
      if (children.length) item.setAttribute("aria-expanded", String(open));
    }
    this.values();
  }

  /** Values of the ports of visible nodes. */
  values() {
    const { run, cursor: { t, agent } } = this;
    for (const { item, ports } of this.rows) {
      if (item.hidden) continue;
      for (const port of ports) {
        port.track ??= run.get(agent, "board", port.entry);
        const value = port.track?.at(t) ?? null;
        put(port.value, value === null ? port.given : value);
        port.box.classList.toggle("unset", value === null);
      }
    }
  }

  update() {
    const { cursor: { t, agent, selected, playing } } = this, tree = this.run.get(agent, "tree")?.at(t);
    if (tree && tree !== this.nodes) { this.build(); return; }
    const path = new Set(this.run.failing(agent, t)), large = this.rows.length > LARGE, open = playing ? new Set(this.open) : new Set();
    for (const row of this.rows) {
      row.status = row.track?.at(t) ?? "";
      const here = selected === this.address(row.path);
      if (large && (here || (row.status === "RUNNING" && row.track) || path.has(row.path))) {
        for (let above = row.parent; above && !open.has(above); above = this.at.get(above)?.parent) open.add(above);
      }
      styled(
        row.item, row.status.toLowerCase() || "unticked", path.has(row.path) && "path", this.run.change(row.track, t) && "fresh", here && "selected",
        row.item.classList.contains("found") && "found", this.cursor.stops.has(this.address(row.path)) && "stop",
      );
      put(row.sign, SIGNS[row.status] ?? "·", row.status || "not ticked");
      const note = row.notes?.at(t) ?? "";
      put(row.note, note, note);
      if (row.began.length > 1) put(row.tries, `${upto(row.began, t)}/${row.began.length}`, "attempts so far, and of the whole run");
    }
    if (large && (open.size !== this.open.size || [...open].some((each) => !this.open.has(each)))) { this.open = open; this.fold(); } else this.values();
    this.draw();
    const runs = this.rows.findLast((row) => row.status === "RUNNING" && !row.item.hidden)?.item;
    if (runs && runs !== this.runs) afterwards(this, () => reveal(this.list, runs));
    this.runs = runs;
  }

  draw() {
    const wide = this.map.hidden ? 0 : this.map.clientWidth; // asking for a width makes the browser lay out the page
    if (!wide) return;
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

  /** Scrolls to the selected node; what a reader folded above it is unfolded. */
  mark() {
    const row = this.rows.find(({ path }) => this.address(path) === this.cursor.selected);
    for (let above = row && this.at.get(row.parent); above; above = this.at.get(above.parent)) {
      if (this.chosen.get(above.path) === false) this.chosen.delete(above.path);
    }
    this.update();
    this.fold();
    if (row) reveal(this.list, row.item);
  }

  key(event) {
    const open = this.rows.filter((row) => !row.item.hidden), at = open.findIndex((row) => row.item.classList.contains("selected")), row = open[at];
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: open.length - 1 }[event.key];
    const folds = row?.children.length && (event.key === "Enter" || event.key === (this.opened(row.path) ? "ArrowLeft" : "ArrowRight"));
    if (to === undefined && !folds) return;
    event.preventDefault();
    event.stopPropagation();
    if (folds) this.toggle(row.path);
    else if (open[to]) this.cursor.select(this.address(open[to].path));
  }
}

/** Keys of all blackboards of a mission with their values at the cursor. */
class Blackboard extends View {
  constructor(run, cursor) {
    super(run, cursor);
    this.list = el("div", { class: "keys" });
    this.box = el("details", { class: "board", open: true }, el("summary", {}, "blackboard"), this.list);
    this.build();
  }

  build() {
    const { run, cursor } = this;
    this.facts = run.of(cursor.agent, "board").map((track) => {
      const [subtree, key] = track.name.split("\n");
      return new Fact(cursor, track, subtree ? el("small", {}, `${short(subtree)} `) : null, key);
    });
    this.box.hidden = !this.facts.length;
    this.list.replaceChildren(...this.facts.map(({ row }) => row));
    this.update();
  }

  update() { for (const fact of this.facts) fact.show(this.run, this.cursor, shown, "–"); }
}
