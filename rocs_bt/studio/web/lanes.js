// @ts-check
// Pictures of the rows over an axis of time: marks, bars, how near a guard is, and curves.
import { View } from "./cursor.js";
import { color, face, put, shown, upto, widthOf } from "./dom.js";
import { tintOf } from "./legend.js";

export const AXIS = 18; // [px] height of the axis
const LINE = 13, EDGE = 6; // [px] height of a label of a scale; from the edges of the plot to the ends of the interval
const THIN = 4, WEIGHTS = ["ink", "actor", "reactive", "good", "twin", "bad"]; // [px] per mark of the events; the last wins
const LINES = 24; // values of a signal that are drawn at most

/** What happened to a robot, as marks on an axis: lines of the log with a colour, its outcome, first differences. */
export const marks = (run, agent) => {
  const lines = run.log.filter((line) => tintOf(line) && (!line[1] || line[1] === agent));
  const found = lines.map((line) => ({ t: line[0], text: line[3], address: line[4], fill: tintOf(line) })), outcome = run.outcome(agent);
  if (outcome) found.push({ t: outcome.t, text: outcome.outcome, address: `${agent}|outcome|`, fill: run.tone(outcome.outcome) });
  for (const { kind, t, track } of run.differences) {
    found.push({ t, text: `first difference of ${kind}: ${track.agent} ${track.name}`, address: track.address, fill: "twin" });
  }
  return found;
};

export class Lanes extends View {
  constructor(run, cursor) {
    super(run, cursor);
    this.from = run.start;
    this.to = run.end;
    this.wide = 0;
    this.high = 0;
    /** @type {any[]} */
    this.rows = [];
  }

  x(t) { return EDGE + ((t - this.from) / (this.to - this.from)) * (this.wide - 2 * EDGE); }

  time(x) { return this.from + ((x - EDGE) / (this.wide - 2 * EDGE)) * (this.to - this.from); }

  draw(g) {
    const span = this.to - this.from, raw = span / (this.wide / 80), base = 10 ** Math.floor(Math.log10(raw));
    const tick = [1, 2, 5, 10].map((m) => m * base).find((step) => step >= raw);
    face(g, 11);
    for (let t = Math.ceil(this.from / tick) * tick; t <= this.to; t += tick) {
      g.fillStyle = color("line");
      g.fillRect(Math.round(this.x(t)), AXIS - 4, 1, this.high);
      g.fillStyle = color("muted");
      const text = String(Number(t.toFixed(6))), x = Math.round(this.x(t)) + 3;
      if (x + widthOf(g, text) < this.wide) g.fillText(text, x, 12);
    }
    for (const row of this.rows) {
      if (row.bars) this.bars(g, row);
      if (row.marks) this.points(g, row);
      else if (row.sides) this.sides(g, row);
      else if (row.curve) this.curve(g, row);
    }
  }

  points(g, { y, high, marks: all }) {
    const seen = new Map(), middle = y + high / 2, weight = ({ fill }) => WEIGHTS.indexOf(fill);
    const place = ({ t }) => Math.floor(this.x(t) / THIN), shows = all.filter(({ t }) => t >= this.from && t <= this.to);
    for (const mark of shows.sort((a, b) => weight(a) - weight(b))) seen.set(place(mark), mark); // the last of a place is drawn
    for (const { t, fill } of shows.filter((mark) => seen.get(place(mark)) === mark)) {
      const x = this.x(t);
      g.fillStyle = color(fill);
      g.beginPath();
      for (const [dx, dy] of [[0, -6], [4, 0], [0, 6], [-4, 0]]) g.lineTo(x + dx, middle + dy);
      g.fill();
    }
  }

  bars(g, { y, high, bars, near = null, second = [] }) {
    g.fillStyle = color("track");
    g.fillRect(0, y, this.wide, high);
    if (near) this.ribbon(g, near, y, high);
    const low = near ? y + high - 8 : y + 2, tall = near ? 8 : high - 4;
    const own = bars.map((bar) => ({ ...bar, top: low, tall: second.length ? tall - 4 : tall }));
    const all = [...own, ...second.map((bar) => ({ ...bar, fill: "twin", top: low + tall - 3, tall: 3 }))];
    for (const { from, to, fill, top, tall: each } of all) {
      if (to < this.from || from > this.to) continue;
      g.fillStyle = color(fill);
      g.fillRect(this.x(from), top, Math.max(1.5, this.x(to) - this.x(from)), each);
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
      visit({ x, least, most, value, next: this.x(Math.min(track.t[i] ?? this.to, this.to)) });
    }
  }

  /**
   * Vertical scale over some columns of tracks; null if they have no finite value. With a limit, a column of one of
   * them, the scale shows the region of the limit; values beyond it are drawn on its edge.
   */
  scale(parts, { y, high }, limit = null) {
    const over = (all) => {
      let low = Infinity, top = -Infinity;
      for (const [track, k] of all) this.columns(track, k, ({ least, most }) => { low = Math.min(low, least); top = Math.max(top, most); });
      return [low, top];
    };
    let [low, top] = over(parts);
    if (!Number.isFinite(low)) return null;
    const [first, last] = limit ? over([limit]) : [NaN, NaN];
    if (Number.isFinite(first)) {
      const room = Math.max(last - first, Math.abs(first), Math.abs(last), 0.25 * (top - low));
      [low, top] = [Math.min(Math.max(low, first - room), first - 0.2 * room), Math.max(Math.min(top, last + room), last + 0.2 * room)];
    }
    const [a, b] = top - low < 1e-9 ? [low - 0.5, top + 0.5] : [low, top];
    return { low, top, at: (v) => y + 3 + ((b - Math.min(b, Math.max(a, v))) / (b - a)) * (high - 6) };
  }

  /** Writes the ends of a scale, and the limit at the cursor, beside the plot. */
  ends({ low, top, at }, { scales, y, high, curve, sides }) {
    const limit = sides ? curve.at(this.cursor.t)?.[1] ?? NaN : NaN, places = [[top, 0], [limit, at(limit) - y - LINE / 2], [low, high - LINE]];
    const middle = Math.min(high - LINE, Math.max(0, places[1][1])), shows = limit >= low && limit <= top;
    const near = (place) => shows && Math.abs(place - middle) < LINE, step = 10 ** (Math.floor(Math.log10(top - low || 1)) - 1);
    scales.forEach((scale, i) => {
      const hidden = i === 1 ? !shows : near(places[i][1]) || (i === 2 && top - low < 1e-9);
      put(scale, hidden ? "" : shown(i === 1 ? limit : Math.round(places[i][0] / step) * step));
      scale.style.top = `${i === 1 && shows ? middle : places[i][1] || 0}px`;
    });
  }

  curve(g, row) {
    const { curve: track, second } = row, lines = Math.min(track.width || 1, LINES), ks = Array.from({ length: lines }, (_, k) => k);
    const scale = this.scale([...ks.map((k) => [track, k]), ...(second ? ks.map((k) => [second, k]) : [])], row);
    if (!scale) return;
    g.lineWidth = 1.4;
    g.globalAlpha = lines > 1 ? 0.6 : 1;
    if (second) for (const k of ks) this.trace(g, second, k, scale, "twin", [5, 3]);
    for (const k of ks) this.trace(g, track, k, scale, "curve");
    g.globalAlpha = 1;
    this.ends(scale, row);
  }

  /** Left side of a comparison as a line, right side dashed; the background shows when it holds. */
  sides(g, row) {
    const { curve: track, y, high } = row, scale = this.scale([[track, 0], [track, 1]], row, [track, 1]);
    g.fillStyle = color("hold");
    this.columns(track, 2, ({ x, most, next }) => { if (most > 0) g.fillRect(x, y, Math.max(1, next - x), high); });
    if (!scale) return;
    g.lineWidth = 1.4;
    this.trace(g, track, 1, scale, "curve", [4, 3]);
    this.trace(g, track, 0, scale, "curve");
    this.ends(scale, row);
  }

  /** Draws a column of a track; what is beyond the scale is a thick pale line on its edge. */
  trace(g, track, k, { at, low, top }, tint, dashes = []) {
    let drawn = false;
    const beyond = [];
    g.strokeStyle = g.fillStyle = color(tint);
    g.setLineDash(dashes);
    g.beginPath();
    this.columns(track, k, ({ x, least, most, value, next }) => {
      if (!Number.isFinite(least)) { drawn = false; return; }
      if (drawn) g.lineTo(x, at(least)); else g.moveTo(x, at(least));
      g.lineTo(x, at(most));
      drawn = Number.isFinite(value);
      if (drawn) { g.lineTo(x, at(value)); g.lineTo(next, at(value)); }
      if (value > top + 1e-9 || value < low - 1e-9) beyond.push([x, at(value), next]);
    });
    g.stroke();
    g.setLineDash([]);
    g.globalAlpha = 0.35;
    g.beginPath();
    for (const [x, y, next] of beyond) g.rect(x, y - 3, Math.max(1, next - x), 6);
    g.fill();
    g.globalAlpha = 1;
  }
}
