// @ts-check
// The tabs: log, knowledge at the cursor, the list of signals, and how the run was made.
import { View } from "./cursor.js";
import { afterwards, el, put, search, short, shown, styled, upto } from "./dom.js";
import { Graph } from "./graph.js";
import { tintOf } from "./legend.js";
import { isSecond } from "./second.js";
import { get, runName } from "./server.js";
import { raw } from "./tools.js";

const MOST = 3000; // lines of the log on the page
const ASK = 500; // [ms] between two questions for what the run has printed
const AGAIN = 3; // failures of a rule's action from which on they are one line, as in record/decisive.py

/** A list below a field to search it by and other tools; `label` is that of the field, empty for none. */
class Panel extends View {
  constructor(run, cursor, list, label = "", ...tools) {
    super(run, cursor);
    this.list = list;
    this.find = search(label, () => { this.build(); cursor.write(); });
    this.box = el("div", { class: "panel", role: "tabpanel" }, label ? el("div", { class: "tools" }, this.find, ...tools) : null, list);
  }
}

/** Row of a track: a name, and its value at the cursor; it is marked if it has just changed, and a click selects it. */
export class Fact {
  constructor(cursor, track, ...name) {
    this.track = track;
    this.value = el("span");
    const about = { class: "fact", title: track.name.replaceAll("\n", " "), tabindex: 0, role: "button" };
    this.row = el("div", { ...about, onclick: () => cursor.select(track.address) }, el("span", {}, ...name), this.value);
  }

  /** Shows the value in words; returns it, null if there is none. */
  show(run, { t, selected }, words, none) {
    const now = this.track.at(t) ?? null, text = now === null ? none : words(now);
    styled(this.row, "fact", run.change(this.track, t), selected === this.track.address && "selected");
    put(this.value, text, text);
    return now;
  }
}

export class Log extends Panel {
  constructor(run, cursor) {
    const least = el(
      "select", { "aria-label": "least level", onchange: () => { this.build(); cursor.write(); } },
      ...[["all", 1], ["info", 2], ["warnings", 3], ["errors", 4]].map(([name, level]) => el("option", { value: level, selected: level === 2 }, String(name))),
    );
    super(run, cursor, el("ol", { class: "log" }), "filter the log", least);
    this.least = least;
    /** @type {Set<string>} what is repeated, and was opened */
    this.open = new Set();
    this.build();
    const { find } = this, { value } = least;
    const filter = () => (find.value || least.value !== value ? [find.value, least.value] : []);
    cursor.keep("log", filter, ([word = "", level = value]) => { find.value = word; least.value = level; this.build(); });
  }

  build() {
    const word = this.find.value.toLowerCase(), least = Number(this.least.value), { agent } = this.cursor;
    const mine = ["", agent, `${agent}′`], has = ([, of, level, text]) => level >= least && mine.includes(of) && text.toLowerCase().includes(word);
    const lines = this.run.log.filter(has);
    this.lines = lines.slice(-MOST);
    this.times = this.lines.map(([t]) => t);
    /** @type {any[]} */
    this.items = this.lines.map((line) => this.line(line));
    const more = lines.length > MOST ? `${lines.length - MOST} earlier lines are not shown; filter the log.` : "";
    const none = this.items.length ? more : word ? "No line has this text." : "Nothing was logged at this level.";
    this.list.replaceChildren(...(none ? [el("li", { class: "empty" }, none)] : []), ...this.items);
    for (const each of this.repeated()) this.sum(each);
    this.here = -1;
    this.count = this.run.log.length;
    this.update();
  }

  line([t, agent, level, text, about]) {
    const kinds = `${level === 1 ? "muted" : tintOf([t, agent, level, text, about])} ${isSecond(agent) ? "second" : ""}`;
    const go = () => (about ? this.cursor.select(about, t) : this.cursor.move(t));
    const whole = (event) => { event.stopPropagation(); raw(this.run, [t, agent, level, text, about]); };
    return el(
      "li", { class: kinds, tabindex: 0, role: "button", onclick: go }, el("time", {}, t.toFixed(2)), el("span", {}, text),
      el("button", { class: "raw", title: "the whole event", "aria-label": "the whole event", onclick: whole }, "{ }"),
    );
  }

  /** What the run says in one sentence of many lines: two rules or actions that alternate, and an action of a rule that fails again and again. */
  repeated() {
    const found = new Map(), { run } = this;
    for (const track of run.agents.flatMap((agent) => [...run.of(agent, "alternation"), ...run.of(agent, "failures")])) {
      track.v.forEach((now, i) => { // the last value of each is that of all of it
        if (!now || now.count < AGAIN) return;
        const { begin = now.first, last = track.t[i], names = [track.name] } = now, text = now.names ? now.text : `${short(track.name)}: ${now.text}`;
        found.set(`${track.address} ${begin}`, { agent: track.agent, begin, last, text, names });
      });
    }
    return [...found.values()];
  }

  /** Folds the lines of what is repeated below one line, which opens. */
  sum({ agent, begin, last, text, names }) {
    const about = ([t, of, , , address]) => of === agent && t > begin - 1e-3 && t < last + 1e-3 && names.some((name) => this.named(address, name));
    const items = this.items.filter((item, i) => !item.head && about(this.lines[i])), key = `${agent} ${begin}`;
    if (items.length < 2) return;
    const mark = el("span"), head = el(
      "li", { class: "turns", tabindex: 0, role: "button", onclick: () => { show(!this.open.delete(key)); } },
      el("time", {}, begin.toFixed(2)), el("span", {}, mark, text),
    );
    const show = (on) => {
      if (on) this.open.add(key);
      put(mark, on ? "▾ " : "▸ ");
      head.setAttribute("aria-expanded", String(on));
      for (const item of items) item.hidden = !on;
    };
    for (const item of items) { item.classList.add("inner"); item.head = head; }
    items[0].before(head);
    show(this.open.has(key));
  }

  /** Whether a line's address is a rule, or an action of it or of this name. */
  named(address, name) {
    const ticket = this.run.tracks.get(address)?.v[0];
    return address.endsWith(`|rule|${name}`) || ticket?.by === name || ticket?.action === name;
  }

  /** Takes new lines of a run that goes on. */
  grow() {
    if (this.run.log.length !== this.count) this.build();
  }

  update() {
    const here = upto(this.times, this.cursor.t) - 1;
    if (here === this.here) return;
    const item = this.items[here]?.hidden ? this.items[here].head : this.items[here];
    this.list.querySelector(".here")?.classList.remove("here");
    item?.classList.add("here");
    this.here = here;
    if (item) afterwards(this, () => { this.list.scrollTop = item.offsetTop - this.list.clientHeight * 0.6; });
  }
}

export class Knowledge extends Panel {
  constructor(run, cursor) {
    const all = el("input", { type: "checkbox", onchange: () => this.build() }), graph = new Graph(run, cursor);
    const drawn = el("input", { type: "checkbox", onchange: () => this.show(drawn.checked) }), box = (input, text) => el("label", {}, input, text);
    super(run, cursor, el("div", { class: "knowledge" }), "search the knowledge", box(all, "only what changes"), box(drawn, "graph"));
    graph.canvas.hidden = true;
    this.list.before(graph.canvas);
    this.graph = graph;
    this.drawn = drawn;
    this.all = all;
    this.build();
  }

  build() {
    const things = new Map(), word = this.find.value.toLowerCase(), { run, cursor } = this;
    for (const track of run.of(cursor.agent, "fact")) {
      const [node, name, target] = track.name.split("\n");
      if (!things.has(node)) things.set(node, { node, kind: null, facts: [] });
      if (name === undefined) things.get(node).kind = track;
      else things.get(node).facts.push({ track, name: target === undefined ? name : `${name} → ${target}`, edge: target !== undefined });
    }
    for (const track of run.of(cursor.agent, "sensor")) things.get(track.name)?.facts.push({ track, name: "failure", edge: false });
    const changes = ({ facts, kind }) => [...facts.map((f) => f.track), kind].some((track) => track && (track.t.length > 1 || track.t[0] > run.start + 0.5));
    const named = ({ node, facts }) => [node, ...facts.map((f) => f.name)].join(" ").toLowerCase().includes(word);
    const wanted = [...things.values()].filter((thing) => named(thing) && (!this.all.checked || changes(thing)));
    this.things = wanted.sort((a, b) => Number(changes(b)) - Number(changes(a))).map(({ node, kind, facts: all }) => {
      const tag = el("small"), facts = all.map(({ track, name, edge }) => Object.assign(new Fact(cursor, track, name), { edge }));
      return { kind, facts, tag, card: el("section", { class: "thing" }, el("h4", {}, node, tag), ...facts.map((fact) => fact.row)) };
    });
    this.graph.build();
    const none = el("p", { class: "empty" }, word ? "Nothing has this name." : this.all.checked ? "Nothing changes in this run." : "This robot knows nothing.");
    this.list.replaceChildren(...(this.things.length ? this.things.map((thing) => thing.card) : [none]));
    this.update();
  }

  update() {
    const { run, cursor } = this, { t } = cursor;
    if (!this.graph.canvas.hidden) this.graph.draw();
    for (const { kind, tag, card, facts } of this.things) {
      const now = kind?.at(t), gone = Boolean(kind) && (now ?? null) === null;
      styled(card, "thing", gone && "gone", run.change(kind, t));
      put(tag, gone ? "not known at this time" : now ?? "");
      for (const fact of facts) {
        const value = fact.show(run, cursor, (v) => (fact.edge && !Object.keys(v).length ? "" : shown(v)), "removed");
        fact.row.hidden = run.change(fact.track, t) !== "removed" && (value === null || gone);
      }
    }
  }

  /** Shows the graph above the list, or the list alone. */
  show(on) {
    this.drawn.checked = on;
    this.graph.canvas.hidden = !on;
    this.update();
  }
}

export class Signals extends Panel {
  constructor(run, cursor, timeline) {
    super(run, cursor, el("div", { class: "signals" }), "search signals and commands (/)");
    this.timeline = timeline;
    cursor.addEventListener("pins", () => this.build());
    this.build();
  }

  build() {
    const word = this.find.value.toLowerCase(), { agent } = this.cursor, topics = ["signal", "command", "truth", "follower"];
    const tracks = topics.flatMap((topic) => this.run.of(agent, topic)).filter(({ name }) => name.toLowerCase().includes(word));
    const pinned = (track) => this.timeline.pinned.has(track.address);
    this.rows = tracks.sort((a, b) => Number(pinned(b)) - Number(pinned(a))).map((track) => {
      const value = el("span"), unit = track.topic === "signal" ? this.run.unit(agent, track.name) : "";
      const box = el("input", { type: "checkbox", onchange: () => this.timeline.pin(track.address, box.checked) });
      box.checked = this.timeline.pinned.has(track.address);
      return { track, value, unit, row: el("label", {}, box, el("span", {}, track.name), value) };
    });
    this.list.replaceChildren(...(this.rows.length ? this.rows.map((r) => r.row) : [el("p", { class: "empty" }, "No signal has this name.")]));
    this.update();
  }

  update() {
    for (const { track, value, unit } of this.rows) put(value, `${shown(track.at(this.cursor.t))} ${unit}`);
  }
}

/** How the run was made, and what of its content was not active. */
export class About extends Panel {
  constructor(run, cursor) {
    super(run, cursor, el("dl", { class: "about" }));
    this.text = el("pre", { tabindex: 0, "aria-label": "what the run has printed" });
    this.output = el("details", { class: "output", hidden: !runName, ontoggle: () => this.update() }, el("summary", {}, "output of the run"), this.text);
    this.box.append(this.output);
    this.build();
  }

  build() {
    const { run, cursor: { agent } } = this, { command, mode, versions = {}, rates = {}, content_hash: hash } = run.header;
    const info = run.info(agent) ?? {}, listed = (values) => Object.entries(values).map(([name, value]) => `${name} ${shown(value)}`).join(", ");
    const rows = [
      ["again", command], ["robot", info.robot], ["mission", info.mission], ["rules", (info.rules ?? []).join(", ")],
      ...Object.values(run.inactive[agent] ?? {}).map((text) => ["inactive", text]),
      ...(run.results?.[agent]?.requirements ?? []).map(({ name, require, text }) => [name, `${require}: ${text}`]),
      ["mode", mode], ["rates [Hz]", listed(rates)], ["versions", listed(versions)], ["content", hash],
    ];
    this.list.replaceChildren(...rows.filter(([, text]) => text).flatMap(([label, text]) => [el("dt", {}, label), el("dd", {}, text)]));
  }

  /** Asks for what the run has printed, while it is open. */
  async update() {
    if (!this.output.open || this.asking) return;
    this.asking = true;
    const printed = await get(`output${location.search}`).catch((error) => error.message);
    put(this.text, printed || "Nothing is kept: the run printed nothing, or another process started it.");
    setTimeout(() => { this.asking = false; }, ASK);
  }
}
