// @ts-check
// Rows over one axis of time: events, rules with how near each comparison of their guard is, actions, and signals.
import { arrows, button, el, prepare, put, short, shown } from "./dom.js";
import { AXIS, Lanes, marks } from "./lanes.js";
import { legend } from "./legend.js";
import { isSecond, twin } from "./second.js";
import { whyNot } from "./why.js";

const BAR = 16, RIBBON = 20, CURVE = 38, TALL = 96, MOST = 150, GAP = 3, MARKS = 14, HEADING = 14; // [px] heights
const FIRST = ["battery", "goal_distance", "speed", "min_clearance"]; // signals shown while none is pinned
const LEAST = 0.2, RECENT = 30, LONG = 180; // [s] shortest interval; interval of a run that goes on; run that begins with a part
const exact = (t) => Number(t.toFixed(5)); // of the interval, so that an address has all of it

export class Timeline extends Lanes {
  constructor(run, cursor) {
    super(run, cursor);
    this.to = Math.max(run.end, run.start + LEAST);
    this.pinned = new Set();
    this.opened = ""; // rule whose comparisons are shown
    this.onwindow = (_from, _to) => {};
    this.onlegend = () => {};
    this.canvas = el("canvas");
    this.line = el("div", { class: "now" });
    this.hover = el("div", { class: "hover", hidden: true });
    this.reading = el("output", { class: "reading", hidden: true });
    this.labels = el("div", { class: "labels" });
    this.plot = el("div", { class: "plot" }, this.canvas, this.line, this.hover, this.reading);
    this.legend = el("div", { class: "below" });
    const about = { class: "timeline", tabindex: 0, "aria-label": "rules, actions and signals over time" };
    this.box = el("div", about, this.labels, this.plot, this.legend);
    this.plot.addEventListener("pointerdown", (event) => {
      this.plot.setPointerCapture(event.pointerId);
      this.drag = event.shiftKey || event.button === 1;
      this.point(event, !this.drag);
    });
    this.plot.addEventListener("pointermove", (event) => { if (event.buttons) this.point(event, false); else this.read(event); });
    this.plot.addEventListener("pointerleave", () => { this.hover.hidden = this.reading.hidden = true; });
    this.plot.addEventListener("dblclick", () => this.window(run.start, run.end));
    this.plot.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.box.addEventListener("keydown", (event) => arrows(event, (step) => this.step(step)));
    cursor.addEventListener("select", () => this.pick());
    const long = run.end - run.start > LONG && !run.going;
    if (long) this.recent();
    cursor.keep("pin", () => [...this.pinned], (all) => { this.pinned = new Set(all.filter((address) => cursor.known(address))); this.show(); });
    cursor.keep("window", () => (!this.whole ? [this.from, this.to].map(String) : long ? ["all"] : []), ([from, to]) => {
      if (Number(to) > Number(from)) this.window(Number(from), Number(to)); else if (from || !long) this.window(run.start, run.end);
    });
    this.build();
  }

  /** Shows the seconds around the cursor. */
  recent() { this.window(this.cursor.t - RECENT * 0.6, this.cursor.t + RECENT * 0.4); }

  /** Zooms in or out around the cursor. @param {number} factor of the interval */
  zoom(factor) {
    const { t } = this.cursor;
    this.window(t - (t - this.from) * factor, t + (this.to - t) * factor);
  }

  /** Pins a signal as a row, or removes it. */
  pin(address, on = !this.pinned.has(address)) {
    if (on) this.pinned.add(address); else this.pinned.delete(address);
    this.show();
    this.cursor.write();
  }

  show() {
    this.build();
    this.cursor.say("pins");
  }

  /** Whether the whole run is shown, or the newest of one that goes on. */
  get whole() { return this.cursor.follows || this.to - this.from > this.run.end - this.run.start - 1e-3; }

  build() {
    const { agent } = this.cursor, group = (label, rows) => (rows.length ? [{ address: "", label, kind: "heading", least: HEADING }, ...rows] : []);
    this.rows = [
      this.events(agent), ...group("rules", this.rules(agent)), ...group("actions", this.actions(agent)), ...group("signals", this.curves(agent)),
    ];
    const zooms = [
      button("−", "zoom out (-)", () => this.zoom(2)), button("+", "zoom in (+)", () => this.zoom(0.5)),
      button(`${RECENT} s`, `${RECENT} seconds around the cursor (w)`, () => this.recent()),
      button("all", "the whole run (0)", () => this.window(this.run.start, this.run.end)),
    ];
    this.labels.replaceChildren(el("div", { class: "axisname" }, ...zooms, el("span", {}, "s")), ...this.rows.map((row) => this.label(row)));
    const drawn = this.rows.flatMap((row) => [...row.bars ?? [], ...row.marks ?? []]);
    const tints = new Set(drawn.map(({ fill }) => fill));
    if (this.rows.some((row) => row.near)) tints.add("margin").add("latched");
    if (this.run.other) tints.add("twin");
    this.legend.replaceChildren(legend(tints, () => this.onlegend()));
    const wanted = this.rows.filter(({ kind }) => kind !== "inner").reduce((sum, row) => sum + GAP + row.least * (row.curve ? 1.5 : 1), AXIS);
    document.getElementById("app").style.setProperty("--time", `${Math.ceil(wanted) + 30 + (this.run.of(agent, "compare").length ? 2 * CURVE : 0)}px`);
    this.fit();
    this.mark();
  }

  /** Gives each row its height: the selected curve more, and all curves a share of what is left. */
  lay() {
    const need = this.rows.reduce((sum, row) => sum + GAP + (row.big ? TALL : row.least), AXIS), curves = this.rows.filter((row) => row.curve);
    const spare = Math.max(0, this.box.clientHeight - this.legend.offsetHeight - need - 2), share = Math.min(MOST - CURVE, spare / (curves.length || 1));
    let y = AXIS;
    for (const row of this.rows) {
      row.y = y;
      row.high = row.curve ? Math.floor(row.big ? Math.max(TALL, row.least + share) : row.least + share) : row.least;
      y += row.high + GAP;
      const high = `${row.high + GAP}px`;
      if (row.node.style.height !== high) row.node.style.height = high;
    }
    this.high = y;
  }

  /** Takes what is new in a run that goes on; the last seconds stay in view while the cursor follows. */
  grow(fresh) {
    const { run, cursor } = this, span = this.to - this.from;
    if (fresh) this.build();
    for (const row of [this.events(cursor.agent), ...this.rules(cursor.agent), ...this.actions(cursor.agent)]) {
      const known = this.rows.find((each) => each.address === row.address);
      if (known) { known.bars = row.bars; known.marks = row.marks; }
    }
    if (cursor.follows) this.window(Math.max(run.start, run.end - Math.max(span, RECENT)), Math.max(run.end, run.start + RECENT));
    else this.fit();
  }

  label(row) {
    row.value = el("output");
    row.text = "";
    row.scales = row.curve ? [el("i"), el("i", { class: "limit" }), el("i")] : [];
    const open = () => { if (row.address) this.cursor.select(this.track(row, this.cursor.t)); };
    row.node = el(
      "div", { class: `label ${row.kind ?? ""}`, title: row.title ?? row.label, onclick: open },
      el("span", {}, row.label), row.value,
      row.pinned ? el("button", {
        class: "pin", title: "remove", "aria-label": `remove ${row.label}`,
        onclick: (event) => { event.stopPropagation(); this.pin(row.address, false); },
      }, "×") : null,
      row.curve ? el("div", { class: "scale" }, ...row.scales) : null,
    );
    return row.node;
  }

  /** Row of what happened: faults, reflexes that fired, outcomes. */
  events(agent) {
    return { address: "", label: "events", least: MARKS, bars: [], marks: marks(this.run, agent) };
  }

  rules(agent) {
    const { run } = this, tracked = ["guards", "rule"].flatMap((topic) => run.of(agent, topic).map((track) => track.name));
    const names = new Set([...Object.keys(run.guards[agent] ?? {}), ...tracked]);
    return [...names].flatMap((name) => {
      const track = run.get(agent, "rule", name), near = run.get(agent, "near", name), address = `${agent}|rule|${name}`;
      const bar = ({ from, to, value }) => ({ from, to, fill: value.active ? "reactive" : "latched" });
      const bars = (each) => each?.spans(run.end, (s) => s.latched || s.active).map(bar) ?? [], least = near ? RIBBON : BAR;
      const row = { address, label: short(name), title: name, least, bars: bars(track), second: bars(twin(run, address)), near, rule: name };
      return this.opened === address ? [row, ...this.comparisons(agent, name)] : [row];
    });
  }

  /** Both sides of each comparison of a guard, as rows below the rule that is selected. */
  comparisons(agent, rule) {
    return (this.run.guard(agent, rule, this.cursor.t)?.sides ?? []).flatMap(({ name, text, unit }) => {
      const track = this.run.get(agent, "compare", name);
      return track ? [{ address: track.address, label: text, kind: "inner", least: CURVE, curve: track, sides: true, unit }] : [];
    });
  }

  actions(agent) {
    const rows = new Map(), { run } = this;
    for (const [who, into] of [[agent, "bars"], ...(run.other && !isSecond(agent) ? [[`${agent}′`, "second"]] : [])]) {
      for (const ticket of run.of(who, "ticket")) {
        const last = ticket.v.at(-1), i = ticket.v.findIndex((v) => v.state === "RUNNING" || v.state === "FAILED"); // some fail at once
        const row = rows.get(last.action) ?? { address: `${agent}|action|${last.action}`, label: last.action, least: BAR, bars: [], second: [] };
        rows.set(last.action, row);
        if (i < 0) continue;
        const fill = last.state === "FAILED" ? "bad" : last.priority === "HIGH" ? "reactive" : "deliberative";
        const text = `${last.action} #${ticket.name}: ${last.state}`;
        row[into].push({ from: ticket.t[i], to: ticket.t[i + 1] ?? (last.state === "FAILED" ? ticket.t[i] : run.end), fill, address: ticket.address, text });
      }
    }
    for (const row of rows.values()) row.address = (row.bars[0] ?? row.second[0])?.address ?? row.address;
    return [...rows.values()];
  }

  curves(agent) {
    const { run } = this, first = FIRST.map((name) => run.get(agent, "signal", name) ?? run.get(agent, "truth", name)).filter(Boolean).slice(0, 3);
    const tracks = this.pinned.size ? [...this.pinned].map((address) => run.tracks.get(address)).filter(Boolean) : first;
    return tracks.map((track) => ({
      address: track.address, label: track.name || track.topic, least: CURVE, curve: track, pinned: this.pinned.has(track.address),
      unit: track.topic === "signal" ? run.unit(agent, track.name) : track.topic === "truth" ? "m" : "", second: twin(run, track.address),
    }));
  }

  fit() {
    const wide = this.plot.clientWidth;
    if (!wide) return;
    this.wide = wide;
    this.lay();
    this.canvas.style.height = `${this.high}px`;
    this.line.style.height = this.hover.style.height = `${this.high}px`;
    this.redraw();
  }

  redraw() {
    if (!this.wide) return;
    this.draw(prepare(this.canvas, this.wide, this.high));
    this.update();
  }

  /** Shows an interval. */
  window(from, to) {
    const { start, end } = this.run, span = Math.min(Math.max(to - from, LEAST), Math.max(end - start, LEAST));
    this.from = exact(Math.max(start, Math.min(from, end - span)));
    this.to = exact(this.from + span);
    this.redraw();
    this.onwindow(this.from, this.to);
    this.cursor.write();
  }

  under(event) {
    const x = event.clientX - this.plot.getBoundingClientRect().left, y = event.clientY - this.canvas.getBoundingClientRect().top;
    const t = this.time(x), row = this.rows.find((r) => y >= r.y && y < r.y + r.high + GAP), near = this.across(5);
    const bar = row?.bars?.find((b) => b.from <= t && t < b.to && b.address) ?? row?.marks?.find((m) => Math.abs(m.t - t) < near);
    return { x, y, t: bar?.t ?? t, row, bar };
  }

  /** Moves the cursor to the pointer; a press selects the row too. With shift, the axis moves. */
  point(event, press) {
    if (this.drag) return this.shift(-event.movementX);
    const { t, row, bar } = this.under(event), address = bar?.address ?? this.track(row, t);
    return press && address ? this.cursor.select(address, t) : this.cursor.move(t);
  }

  /** What a row is about at a time: of an action the attempt that runs then, or the last one. */
  track(row, t) { return row?.bars?.findLast((bar) => bar.from <= t && bar.address)?.address ?? row?.address; }

  /** Moves the axis. @param {number} x [px] */
  shift(x) { this.window(this.from + this.across(x), this.to + this.across(x)); }

  /** Time that some pixels are long. */
  across(x) { return (x / this.wide) * (this.to - this.from); }

  /** Shows time and value under the pointer. */
  read(event) {
    const { x, y, t, row, bar } = this.under(event);
    const value = bar?.text ?? (row?.curve ? this.valued(row, t) : row?.rule ? this.nearest(row, t) : "");
    this.hover.hidden = this.reading.hidden = false;
    this.hover.style.transform = `translateX(${x}px)`;
    put(this.reading, `${t.toFixed(2)} s${value ? `  ${value}` : ""}`);
    const left = Math.max(2, x > this.wide / 2 ? x - this.reading.offsetWidth - 8 : x + 8);
    this.reading.style.transform = `translate(${left}px, ${y + 12}px)`;
  }

  wheel(event) {
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (!sideways && !event.ctrlKey && !event.shiftKey && !event.altKey) return undefined; // scrolls the rows
    event.preventDefault();
    if (sideways && !event.ctrlKey && !event.shiftKey) return this.shift(event.deltaX);
    const at = this.time(event.clientX - this.plot.getBoundingClientRect().left), factor = Math.exp((event.deltaY || event.deltaX) * 0.002);
    return this.window(at - (at - this.from) * factor, at + (this.to - at) * factor);
  }

  /** Arrows up and down select the next row. */
  step(step) {
    const at = this.rows.findIndex((row) => row.node.classList.contains("selected")), rows = this.rows.filter((row) => row.address);
    const next = rows[Math.min(rows.length - 1, Math.max(0, rows.indexOf(this.rows[at]) + step))];
    if (next) { this.cursor.select(next.address); next.node.scrollIntoView({ block: "nearest" }); }
  }

  /** What keeps a rule from firing: by how much the farthest comparison of its guard does not hold. */
  nearest({ rule, address }, t) {
    const { held } = whyNot(this.run, this.cursor.agent, rule, t), state = this.run.tracks.get(address)?.at(t);
    if (state?.active || state?.waits) return state.active ? "active" : "waits";
    const gaps = held.map(({ left, right, unit }) => ({ gap: Math.abs(left - right), unit }));
    if (!gaps.length) return this.run.get(this.cursor.agent, "guard", rule)?.at(t)?.since === undefined ? "off" : "holds";
    const [first] = gaps;
    return Number.isNaN(first.gap) ? "not known" : Number.isFinite(first.gap) ? `${shown(first.gap)} ${first.unit} off` : "far off";
  }

  valued({ curve, unit, sides, second }, t) {
    if (!sides) return `${shown(curve.at(t))} ${unit}${second ? ` / ${shown(second.at(t))}` : ""}`;
    const [left, right] = curve.at(t) ?? [NaN, NaN];
    return `${shown(left)} | ${shown(right)} ${unit}`;
  }

  update() {
    const { t } = this.cursor, span = this.to - this.from;
    if (t < this.from - 1e-6 || t > this.to + 1e-6) {
      const from = t - span * (t < this.from ? 0.2 : 0.8);
      this.window(from, from + span);
      return;
    }
    this.line.style.transform = `translateX(${this.x(t)}px)`;
    for (const row of this.rows) {
      const text = row.curve ? this.valued(row, t) : row.near ? this.nearest(row, t) : "";
      if (text !== row.text) { row.text = text; put(row.value, text); }
    }
  }

  /** Marks the row of the selected thing; a selected signal without a row is pinned, a selected rule shows its comparisons. */
  pick() {
    const { selected, agent } = this.cursor, track = this.run.tracks.get(selected), [, topic, name = ""] = selected.split("|", 3);
    const opened = topic === "rule" ? selected : topic === "compare" ? `${agent}|rule|${name.split("\n")[0]}` : this.opened;
    if (opened !== this.opened) { this.opened = opened; this.build(); }
    const free = track?.width && !["scan", "pose", "compare", "near"].includes(track.topic);
    if (free && !this.rows.some((row) => row.address === selected)) this.pin(selected, true);
    this.mark();
  }

  mark() {
    const { selected, stops } = this.cursor;
    let changes = false;
    for (const row of this.rows) {
      const here = Boolean(row.address) && (row.address === selected || Boolean(row.bars?.some((bar) => bar.address === selected)));
      const big = here && Boolean(row.curve);
      changes ||= big !== Boolean(row.big);
      row.big = big;
      row.node.classList.toggle("selected", here);
      row.node.classList.toggle("stop", stops.has(row.address));
    }
    if (changes) this.fit();
  }
}
