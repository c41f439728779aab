// Rows over one axis of time: rules with how near each comparison of their guard is, actions, and pinned signals.
import { FONT, color, el, prepare, put, short, shown, upto } from "./dom.js";

const AXIS = 18, BAR = 18, RIBBON = 26, CURVE = 44, GAP = 2; // [px] heights
const FIRST = ["battery", "goal_distance", "speed", "min_clearance"]; // signals shown while none is pinned
const LINES = 24; // values of a signal that are drawn at most
const LEAST = 0.2, RECENT = 30; // [s] shortest interval that is shown; interval of a run that goes on

export class Timeline {
  constructor(run, cursor) {
    Object.assign(this, { run, cursor, from: run.start, to: Math.max(run.end, run.start + LEAST), pinned: new Set(), rows: [], onwindow: () => {} });
    this.canvas = el("canvas");
    this.line = el("div", { class: "now" });
    this.labels = el("div", { class: "labels" });
    this.plot = el("div", { class: "plot" }, this.canvas, this.line);
    this.box = el("div", { class: "timeline", tabindex: 0, "aria-label": "rules, actions and signals over time" }, this.labels, this.plot);
    this.plot.addEventListener("pointerdown", (event) => { this.plot.setPointerCapture(event.pointerId); this.point(event, true); });
    this.plot.addEventListener("pointermove", (event) => { if (event.buttons === 1) this.point(event, false); });
    this.plot.addEventListener("dblclick", () => this.window(run.start, run.end));
    this.plot.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    cursor.addEventListener("move", () => this.place());
    cursor.addEventListener("agent", () => this.build());
    cursor.addEventListener("select", () => this.pick());
    this.build();
  }

  /** Pins a signal as a row, or removes it. */
  pin(address, on = !this.pinned.has(address)) {
    if (on) this.pinned.add(address); else this.pinned.delete(address);
    this.build();
  }

  build() {
    const { agent } = this.cursor;
    this.rows = [...this.rules(agent), ...this.actions(agent), ...this.curves(agent)];
    let y = AXIS;
    for (const row of this.rows) { row.y = y; y += row.high + GAP; }
    this.high = y + 4;
    this.labels.replaceChildren(el("div", { class: "axisname" }, "time [s]"), ...this.rows.map((row) => this.label(row)));
    this.fit();
  }

  /** Takes what is new in a run that goes on; the last seconds stay in view while the cursor follows. */
  grow(fresh) {
    const { run, cursor } = this, span = this.to - this.from;
    if (fresh) this.build();
    for (const row of [...this.rules(cursor.agent), ...this.actions(cursor.agent)]) {
      const known = this.rows.find((each) => each.address === row.address);
      if (known) known.bars = row.bars;
    }
    if (cursor.follows) this.window(Math.max(run.start, run.end - Math.max(span, RECENT)), Math.max(run.end, run.start + RECENT));
    else this.fit();
  }

  label(row) {
    row.value = el("output");
    row.node = el(
      "div", { class: "label", title: row.title ?? row.label, onclick: () => this.cursor.select(row.address) },
      el("span", {}, row.label), row.value,
      row.pinned ? el("button", {
        class: "pin", title: "remove", "aria-label": `remove ${row.label}`,
        onclick: (event) => { event.stopPropagation(); this.pin(row.address, false); },
      }, "×") : null,
    );
    row.node.style.height = `${row.high + GAP}px`;
    return row.node;
  }

  rules(agent) {
    const { run } = this, names = new Set([...Object.keys(run.guards[agent] ?? {}), ...run.of(agent, "rule").map((r) => r.name)]);
    return [...names].map((name) => {
      const track = run.get(agent, "rule", name), near = run.get(agent, "near", name);
      const bars = track?.spans(run.end, (s) => s.latched || s.active).map(({ from, to, value }) => ({ from, to, fill: value.active ? "reactive" : "latched" }));
      return { address: `${agent}|rule|${name}`, label: short(name), title: name, high: near ? RIBBON : BAR, bars: bars ?? [], near };
    });
  }

  actions(agent) {
    const rows = new Map(), { run } = this;
    for (const ticket of run.of(agent, "ticket")) {
      const last = ticket.v.at(-1), i = ticket.v.findIndex((v) => v.state === "RUNNING");
      const row = rows.get(last.action) ?? { address: ticket.address, label: last.action, high: BAR, bars: [] };
      rows.set(last.action, row);
      if (i < 0) continue;
      const fill = last.state === "FAILED" ? "bad" : last.priority === "HIGH" ? "reactive" : "deliberative";
      row.bars.push({ from: ticket.t[i], to: ticket.t[i + 1] ?? run.end, fill, address: ticket.address });
    }
    return [...rows.values()];
  }

  curves(agent) {
    const { run } = this, first = FIRST.map((name) => run.get(agent, "signal", name) ?? run.get(agent, "truth", name)).filter(Boolean).slice(0, 3);
    const tracks = this.pinned.size ? [...this.pinned].map((address) => run.tracks.get(address)).filter(Boolean) : first;
    return tracks.map((track) => ({
      address: track.address, label: track.name || track.topic, high: CURVE, curve: track,
      unit: track.topic === "signal" ? run.unit(agent, track.name) : track.topic === "truth" ? "m" : "", pinned: this.pinned.has(track.address),
    }));
  }

  fit() {
    const wide = this.plot.clientWidth;
    if (!wide) return;
    this.wide = wide;
    this.canvas.style.height = this.line.style.height = `${this.high}px`;
    this.draw(prepare(this.canvas, wide, this.high));
    this.place();
  }

  x(t) { return ((t - this.from) / (this.to - this.from)) * this.wide; }

  time(x) { return this.from + (x / this.wide) * (this.to - this.from); }

  /** Shows an interval. */
  window(from, to) {
    const { start, end } = this.run, span = Math.min(Math.max(to - from, LEAST), Math.max(end - start, LEAST));
    this.from = Math.max(start, Math.min(from, end - span));
    this.to = this.from + span;
    this.fit();
    this.onwindow(this.from, this.to);
  }

  /** Moves the cursor to the pointer; a press selects the row too. */
  point(event, press) {
    const x = event.clientX - this.plot.getBoundingClientRect().left, y = event.clientY - this.canvas.getBoundingClientRect().top;
    const t = this.time(x), row = press && this.rows.find((r) => y >= r.y && y < r.y + r.high + GAP);
    if (row) this.cursor.select(row.bars?.find((b) => b.from <= t && t < b.to && b.address)?.address ?? row.address, t);
    else this.cursor.move(t);
  }

  wheel(event) {
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY), span = this.to - this.from;
    if (!sideways && !event.ctrlKey && !event.shiftKey && !event.altKey) return; // scrolls the rows
    event.preventDefault();
    if (sideways && !event.ctrlKey && !event.shiftKey) {
      const by = (event.deltaX / this.wide) * span;
      this.window(this.from + by, this.to + by);
      return;
    }
    const at = this.time(event.clientX - this.plot.getBoundingClientRect().left), factor = Math.exp((event.deltaY || event.deltaX) * 0.002);
    this.window(at - (at - this.from) * factor, at + (this.to - at) * factor);
  }

  draw(g) {
    const span = this.to - this.from, raw = span / (this.wide / 80), base = 10 ** Math.floor(Math.log10(raw));
    const tick = [1, 2, 5, 10].map((m) => m * base).find((step) => step >= raw);
    g.font = `11px ${FONT}`;
    for (let t = Math.ceil(this.from / tick) * tick; t <= this.to; t += tick) {
      g.fillStyle = color("line");
      g.fillRect(Math.round(this.x(t)), AXIS - 4, 1, this.high);
      g.fillStyle = color("muted");
      g.fillText(String(Number(t.toFixed(6))), Math.round(this.x(t)) + 3, 11);
    }
    for (const row of this.rows) if (row.curve) this.curve(g, row); else this.bars(g, row);
  }

  bars(g, { y, high, bars, near }) {
    g.fillStyle = color("track");
    g.fillRect(0, y, this.wide, high);
    if (near) this.ribbon(g, near, y, high);
    const low = near ? y + high - 8 : y + 2, tall = near ? 8 : high - 4;
    for (const { from, to, fill } of bars) {
      if (to < this.from || from > this.to) continue;
      g.fillStyle = color(fill);
      g.fillRect(this.x(from), low, Math.max(1.5, this.x(to) - this.x(from)), tall);
    }
  }

  /** How near a guard is: the fuller, the nearer its last missing comparison. Each comparison is scaled by its own range. */
  ribbon(g, track, y, high) {
    this.columns(track, 0, ({ x, most, next }) => {
      if (!Number.isFinite(most)) return;
      const tall = Math.max(0, Math.min(1, most)) * (high - 9);
      g.fillStyle = color(most >= 1 ? "latched" : "margin");
      g.fillRect(x, y + high - 8 - tall, Math.max(1, next - x), tall);
    });
  }

  /** Least and greatest value of each column of pixels, so that a minute and an hour cost the same. */
  columns(track, k, visit) {
    const wide = track.width || 1, last = Math.min(track.t.length, upto(track.t, this.to) + 1);
    let i = Math.max(0, upto(track.t, this.from) - 1);
    while (i < last) {
      const x = Math.floor(this.x(track.t[i]));
      let least = Infinity, most = -Infinity, value = NaN;
      for (; i < last && Math.floor(this.x(track.t[i])) === x; i++) {
        value = track.v[i * wide + k];
        if (Number.isFinite(value)) { least = Math.min(least, value); most = Math.max(most, value); }
      }
      visit({ x, least, most, value, next: i < track.t.length ? Math.min(this.x(track.t[i]), this.wide) : this.wide });
    }
  }

  curve(g, { curve: track, y, high, unit }) {
    const lines = Math.min(track.width || 1, LINES), ks = Array.from({ length: lines }, (_, k) => k);
    let low = Infinity, top = -Infinity;
    for (const k of ks) this.columns(track, k, ({ least, most }) => { low = Math.min(low, least); top = Math.max(top, most); });
    if (!Number.isFinite(low)) return;
    const [a, b] = top - low < 1e-9 ? [low - 0.5, top + 0.5] : [low, top], at = (v) => y + 3 + ((b - v) / (b - a)) * (high - 6);
    g.strokeStyle = color("curve");
    g.lineWidth = 1.3;
    g.globalAlpha = lines > 1 ? 0.6 : 1;
    for (const k of ks) this.trace(g, track, k, at);
    g.globalAlpha = 1;
    g.fillStyle = color("muted");
    g.fillText(`${shown(top)} ${unit}`, 3, y + 11);
    g.fillText(shown(low), 3, y + high - 2);
  }

  trace(g, track, k, at) {
    let drawn = false;
    g.beginPath();
    this.columns(track, k, ({ x, least, most, value, next }) => {
      if (!Number.isFinite(least)) { drawn = false; return; }
      if (drawn) g.lineTo(x, at(least)); else g.moveTo(x, at(least));
      g.lineTo(x, at(most));
      drawn = Number.isFinite(value);
      if (drawn) { g.lineTo(x, at(value)); g.lineTo(next, at(value)); }
    });
    g.stroke();
  }

  place() {
    const { t } = this.cursor, span = this.to - this.from;
    if (t < this.from - 1e-6 || t > this.to + 1e-6) {
      const from = t - span * (t < this.from ? 0.2 : 0.8);
      this.window(from, from + span);
      return;
    }
    this.line.style.transform = `translateX(${this.x(t)}px)`;
    for (const row of this.rows) put(row.value, row.curve ? `${shown(row.curve.at(t))} ${row.unit}` : "");
  }

  /** Marks the row of the selected thing; a selected signal without a row is pinned. */
  pick() {
    const { selected } = this.cursor, track = this.run.tracks.get(selected);
    if (track?.width && track.topic !== "scan" && track.topic !== "pose" && !this.rows.some((row) => row.address === selected)) this.pin(selected, true);
    for (const row of this.rows) {
      row.node.classList.toggle("selected", row.address === selected || Boolean(row.bars?.some((bar) => bar.address === selected)));
    }
  }
}
