// @ts-check
// The tree of a mission, its palette and the form of a node: views of the text that ask for edits of it.
import { el, search } from "./dom.js";

const WRAPPERS = new Set(["root", "BehaviorTree"]);
const KINDS = ["Control", "Decorator", "Action", "Condition", "SubTree"];
const inside = (path, outer) => path === outer || path.startsWith(`${outer}/`);
const parent = (path) => path.slice(0, path.lastIndexOf("/"));
const index = (path) => Number(path.slice(path.lastIndexOf("/") + 1));

export class Nodes {
  /** @param {{edit: (asked: any) => Promise<void>, choose: (row: any) => void, write: (item: any) => void}} on */
  constructor(on) {
    this.on = on;
    this.rows = [];
    this.folded = new Set();
    this.chosen = "";
    this.held = null;
    this.kinds = new Map();
    this.whole = true;
    this.find = search("search nodes", () => this.offer());
    this.offers = el("div");
    this.palette = el("section", { class: "palette", "aria-label": "palette" }, this.find, this.offers);
    this.tree = el("ol", { class: "nodes", tabindex: "0", role: "tree", "aria-label": "mission tree", onkeydown: (event) => this.key(event) });
    this.form = el("form", { class: "ports", "aria-label": "ports of the node", onsubmit: (event) => event.preventDefault() });
  }

  learn(nodes) {
    this.known = nodes;
    this.kinds = new Map(nodes.map((node) => [node.name, node.kind]));
    this.offer();
  }

  offer() {
    const word = this.find.value.toLowerCase(), found = (this.known ?? []).filter((node) => node.name.toLowerCase().includes(word));
    this.offers.replaceChildren(...KINDS.flatMap((kind) => {
      const own = found.filter((node) => node.kind === kind);
      return own.length ? [el("h3", {}, kind), el("ul", {}, ...own.map((node) => this.offered(node)))] : [];
    }));
  }

  offered(node) {
    const add = () => this.add(node);
    return el("li", {
      draggable: "true", tabindex: "0", title: node.doc, "data-node": node.name, ondblclick: add,
      onkeydown: (event) => { if (event.key === "Enter") { event.preventDefault(); add(); } },
      ondragstart: (event) => { this.held = { text: node.text }; event.dataTransfer.setData("text/plain", node.text); },
    }, node.name);
  }

  /** Adds a node of the palette into the chosen node, or behind it if it takes no child. */
  add(node) {
    const row = this.row(this.chosen) ?? this.rows.find((each) => each.tag === "BehaviorTree");
    if (!row) return;
    const into = this.takes(row);
    this.on.edit({ do: "insert", new: node.text, parent: into ? row.path : parent(row.path), ...(into ? {} : { index: index(row.path) + 1 }) });
  }

  row(path) { return this.rows.find((row) => row.path === path); }

  /** Whether a node takes another child. */
  takes(row) {
    if (row.tag === "root") return false;
    if (row.tag === "BehaviorTree") return row.children === 0;
    const kind = this.kinds.get(row.tag);
    return kind === "Control" || (kind === "Decorator" && row.children === 0) || (kind === undefined && row.children > 0 && row.tag !== "SubTree");
  }

  show(tree, marks) {
    this.whole = tree.whole;
    this.rows = tree.rows.filter((row) => row.tag !== "root" && row.tag !== "include" && !this.model(row, tree.rows));
    const hidden = (row) => [...this.folded].some((path) => row.path !== path && inside(row.path, path));
    this.tree.replaceChildren(...this.rows.filter((row) => !hidden(row)).map((row) => this.line(row, marks)));
    this.tree.classList.toggle("muted", !tree.whole);
  }

  model(row, rows) { return rows.some((outer) => /^TreeNodes?Model$/.test(outer.tag) && inside(row.path, outer.path)); }

  line(row, marks) {
    const at = (mark) => this.rows.findLast((each) => each.line <= mark.line && mark.line <= each.last);
    const own = marks.filter((mark) => !mark.file && mark.level !== "note" && row === at(mark)), chosen = row.path === this.chosen ? "chosen" : "";
    const state = own.some((mark) => mark.level === "error") ? "wrong" : own.length ? "doubtful" : "", shut = this.folded.has(row.path);
    const li = el(
      "li", {
        class: `${state} ${chosen}`.trim(), draggable: "true", role: "treeitem", "data-path": row.path,
        title: own.map((mark) => mark.message).join("\n"), onclick: () => this.choose(row.path),
      },
      el("i", { onclick: (event) => { event.stopPropagation(); this.fold(row.path); } }, row.children ? (shut ? "▸" : "▾") : "·"),
      el("b", {}, row.tag), el("small", {}, row.ports.map(([name, value]) => `${name}="${value}"`).join(" ")),
    );
    li.style.paddingLeft = `${8 + 14 * (row.path.split("/").length - 2)}px`;
    const clear = () => li.classList.remove("before", "into", "after");
    li.addEventListener("dragstart", (event) => { this.held = { path: row.path }; event.dataTransfer.setData("text/plain", row.tag); });
    li.addEventListener("dragover", (event) => {
      clear();
      const place = this.place(row, li, event);
      if (place) { event.preventDefault(); li.classList.add(place.where); }
    });
    li.addEventListener("dragleave", clear);
    li.addEventListener("drop", (event) => { event.preventDefault(); clear(); this.drop(this.place(row, li, event)); });
    return li;
  }

  fold(path) {
    if (!this.folded.delete(path)) this.folded.add(path);
    this.on.write(null);
  }

  /** Place that a drop at a row means: before it, into it, or behind it; null where the held node cannot go. */
  place(row, li, event) {
    const box = li.getBoundingClientRect(), part = (event.clientY - box.top) / box.height;
    if (!this.whole || (this.held?.path && inside(row.path, this.held.path))) return null;
    if (this.takes(row) && part > 0.25 && (part < 0.75 || WRAPPERS.has(row.tag) || row.children)) {
      return { where: "into", parent: row.path, ...(part < 0.75 ? {} : { index: 0 }) };
    }
    if (WRAPPERS.has(row.tag)) return null;
    const outer = this.row(parent(row.path));
    if (outer?.tag === "BehaviorTree" && this.held?.text) return null; // a tree has one root
    return { where: part > 0.5 ? "after" : "before", parent: parent(row.path), index: index(row.path) + (part > 0.5 ? 1 : 0) };
  }

  drop(place) {
    const { held } = this;
    this.held = null;
    if (!held || !place) return;
    const { where: _, ...to } = place;
    this.on.edit(held.path ? { do: "move", node: held.path, ...to } : { do: "insert", new: held.text, ...to });
  }

  choose(path, tell = true) {
    this.chosen = path;
    for (const li of this.tree.children) {
      li.classList.toggle("chosen", li.dataset.path === path);
      if (li.dataset.path === path) li.scrollIntoView({ block: "nearest" });
    }
    const row = this.row(path);
    if (tell && row) this.on.choose(row);
  }

  /** The form of a node; every change of a field is an edit of the text. */
  fill(node) {
    if (!node?.node) return this.form.replaceChildren();
    const list = el("datalist", { id: "keys" }, ...node.keys.map((key) => el("option", { value: key })));
    const field = (port) => {
      const input = el("input", {
        value: port.value ?? "", list: "keys", name: port.name, autocomplete: "off", placeholder: port.default === null ? "required" : port.default,
        onchange: () => this.on.edit({ do: "set", node: node.path, name: port.name, value: input.value === "" && port.value !== "" ? null : input.value }),
      });
      const type = [port.direction, port.type.replace("std::", "")].filter(Boolean).join(" ");
      return el("label", { class: port.value === null ? "" : "given", title: port.doc }, el("span", {}, port.name), input, el("small", {}, type));
    };
    const shown = node.ports.filter((port) => port.value !== null || !port.name.startsWith("_")), rest = node.ports.filter((port) => !shown.includes(port));
    this.form.replaceChildren(
      el("h3", {}, node.node), el("p", {}, [node.kind, node.doc].filter(Boolean).join(": ")), ...shown.map(field),
      ...(rest.length ? [el("details", {}, el("summary", {}, "conditions and scripts"), ...rest.map(field))] : []), list,
    );
  }

  key(event) {
    const seen = [...this.tree.children].map((li) => li.dataset.path), at = seen.indexOf(this.chosen), row = this.row(this.chosen);
    const go = (i) => this.choose(seen[Math.max(0, Math.min(seen.length - 1, i))]);
    if (event.altKey && row && !WRAPPERS.has(row.tag)) {
      const outer = parent(row.path), k = index(row.path), above = this.row(`${outer}/${k - 1}`), up = this.row(outer);
      const to = {
        ArrowUp: k > 0 && { parent: outer, index: k - 1 }, ArrowDown: this.row(`${outer}/${k + 1}`) && { parent: outer, index: k + 2 },
        ArrowRight: above && this.takes(above) && { parent: above.path },
        ArrowLeft: up && !WRAPPERS.has(up.tag) && this.row(parent(outer))?.tag !== "BehaviorTree" && { parent: parent(outer), index: index(outer) + 1 },
      }[event.key];
      if (to) this.on.edit({ do: "move", node: row.path, ...to });
      if (event.key.startsWith("Arrow")) event.preventDefault();
      return;
    }
    const act = {
      ArrowDown: () => go(at + 1), ArrowUp: () => go(at - 1), Home: () => go(0), End: () => go(seen.length - 1),
      ArrowLeft: () => (row?.children && !this.folded.has(row.path) ? this.fold(row.path) : go(seen.indexOf(parent(this.chosen)))),
      ArrowRight: () => (row && this.folded.has(row.path) ? this.fold(row.path) : go(at + 1)),
      Delete: () => row && !WRAPPERS.has(row.tag) && this.on.edit({ do: "remove", node: row.path }),
      Enter: () => this.form.querySelector("input")?.focus(),
    }[event.key];
    if (act) { event.preventDefault(); act(); }
  }
}
