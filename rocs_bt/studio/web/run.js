// @ts-check
// What held at any time of a run. Each thing that changes is a track, found by its address `agent|topic|name`.
import { upto } from "./dom.js";

const OTHERS = [Infinity, NaN, -Infinity]; // what the whole numbers above the greatest of a column are, as in pack.py
const FRESH = 1; // [s] for which a change is marked

/** Step function: rows of `width` numbers, or values of any kind, each from a time on. */
export class Track {
  /** @param {string} address @param {number[]} t @param {any} v @param {number} width @param {number} ray */
  constructor(address, t, v, width = 0, ray = 1) {
    const [agent, topic] = address.split("|", 2);
    this.agent = agent;
    this.topic = topic;
    this.name = address.slice(this.agent.length + this.topic.length + 2);
    this.address = address;
    this.t = t;
    this.v = v;
    this.width = width;
    this.ray = ray;
  }

  row(i) { return this.width ? this.v.slice(i * this.width, (i + 1) * this.width) : this.v[i]; }

  /** Value at a time; undefined before the first. */
  at(t) {
    const i = upto(this.t, t) - 1;
    return i < 0 ? undefined : this.row(i);
  }

  /** Time from which the value at a time holds. */
  since(t) { return this.t[upto(this.t, t) - 1]; }

  /** Row between two samples, linearly; of the angles the short way round. @param {number[]} angles columns */
  between(t, angles = []) {
    const i = upto(this.t, t) - 1;
    if (i < 0 || i + 1 >= this.t.length) return this.row(Math.max(i, 0));
    const before = this.row(i), after = this.row(i + 1), part = (t - this.t[i]) / (this.t[i + 1] - this.t[i]);
    return Array.from(before, (value, k) => {
      const step = after[k] - value;
      return value + part * (angles.includes(k) ? Math.atan2(Math.sin(step), Math.cos(step)) : step);
    });
  }

  /** Times at which a node fails, a rule fires, or another thing changes. */
  get hits() {
    const { t, v, topic } = this;
    const fired = (i) => (v[i].firing?.[0] ?? v[i - 1]?.firing?.[0]) !== v[i - 1]?.firing?.[0], failed = (i) => v[i].state === "FAILED";
    const hit = { node: (i) => v[i] === "FAILURE", rule: fired, ticket: failed }[topic] ?? (() => true);
    return Array.from(t).filter((_, i) => hit(i));
  }

  /** Attempts of a node: when each began and ended, and with which status; the last one may still run. */
  get attempts() {
    const found = [];
    let runs = null;
    this.v.forEach((status, i) => {
      if (!["RUNNING", "SUCCESS", "FAILURE"].includes(status)) { runs = null; return; }
      if (!runs) found.push(runs = { from: this.t[i], to: this.t[i], status });
      Object.assign(runs, { to: this.t[i], status });
      if (status !== "RUNNING") runs = null;
    });
    return found;
  }

  /** Intervals in which the value holds, of those that `keep` accepts. */
  spans(end, keep = (value) => Boolean(value)) {
    return Array.from(this.t, (from, i) => ({ from, to: this.t[i + 1] ?? end, value: this.row(i) })).filter((span) => keep(span.value));
  }

  /** Least and greatest finite number. */
  get range() {
    let low = Infinity, high = -Infinity;
    for (const value of this.v) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    return [low, high];
  }

  /** Takes values of a run that goes on, from an index on. */
  grow(from, t, v) {
    this.t.length = from;
    this.v.length = from * (this.width || 1);
    this.t.push(...t);
    for (const value of v) if (this.width) this.v.push(...value.map(real)); else this.v.push(value);
  }
}

const PORT = /([\w.]+)=("[^"]*"|[^,)]*)/g;

/** Values of a ticket share the parameters of the first. */
const shared = (values) => (values[0]?.parameters && values[0].action ? values.map((value) => ({ ...value, parameters: values[0].parameters })) : values);

/** Ports of a node: name, text as given, and the name of the track of the blackboard's entry that it refers to. */
export const portsOf = ({ ports = "", keys = {} }) => {
  const given = new Map(Array.from(ports.matchAll(PORT), ([, name, text]) => [name, text.replace(/^"|"$/g, "")]));
  for (const [name, entry] of Object.entries(keys)) if (!given.has(name)) given.set(name, `{${entry.split("\n")[1]}}`);
  return Array.from(given, ([name, text]) => ({ name, given: text, entry: keys[name] }));
};

/** Guard of a rule, with the names of the tracks of its comparisons. */
const guardOf = ({ comparisons = [], units = [], ...guard }) => (
  { ...guard, comparisons, sides: comparisons.map((text, i) => ({ name: `${guard.rule}\n${i}`, text, unit: units[i] ?? "" })) });

export class Run {
  constructor({ header, end, log = [], tracks = [], texts = [], ...rest }, columns = (_) => []) {
    const { missing = "", control = false, results = {}, inactive = {}, decisive = [] } = rest;
    this.header = header;
    this.end = end;
    this.log = log;
    const byRule = (guards = []) => Object.fromEntries(guards.map((guard) => [guard.rule, guardOf(guard)]));
    this.guards = Object.fromEntries((header.agents ?? []).map((a) => [a.name, byRule(a.guards)]));
    this.missing = missing; // what the recording lacks, as a sentence
    this.control = control; // whether the run hears commands
    this.results = results;
    this.inactive = inactive;
    this.decisive = decisive; // moments: the causes of failures, else the first reflex
    this.start = header.start ?? 0;
    this.going = false;
    this.other = null; // the second run, whose robots have a prime
    this.differences = [];
    /** @type {string[]} */
    this.agents = (header.agents ?? []).map((a) => a.name);
    /** @type {Map<string, Track>} */
    this.tracks = new Map();
    this.poses = new Map(); // of bodies, those that were asked for last
    /** @type {Map<string, Track[]>} */
    this.topics = new Map();
    for (const [address, kind, t, v, width, ray] of tracks) {
      if (kind === "text") this.add(new Track(address, columns(t), shared(Array.from(columns(v), (i) => texts[i]))));
      else if (Array.isArray(t)) this.add(new Track(address, ...merged(t.map(columns), v.map(columns)), width));
      else this.add(new Track(address, columns(t), columns(v), width, ray));
    }
  }

  add(track) {
    const topic = `${track.agent}|${track.topic}`;
    this.tracks.set(track.address, track);
    if (!this.topics.has(topic)) this.topics.set(topic, []);
    this.topics.get(topic).push(track);
  }

  /** Reads the data of a report: base64 of a packed run. */
  static from(text) { return Run.unpack(Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0))); }

  /** Reads a packed run: deflated JSON and columns. */
  static async unpack(packed) {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const length = new DataView(bytes.buffer).getUint32(0, true), made = new Map();
    const about = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    let at = 4 + length;
    const starts = about.columns.map(([count, , , size]) => { const here = at; at += count * size; return here; });
    return new Run(about, (i) => {
      if (!made.has(i)) made.set(i, unpacked(bytes, starts[i], about.columns[i]));
      return made.get(i);
    });
  }

  /** Opens a run of the server: a packed one, or one that goes on, of which `onchange` gets whether new tracks began; as it is now, without `onchange`. */
  static async open(name, onchange) {
    const search = `?${new URLSearchParams({ run: name, ...(onchange ? {} : { whole: "1" }) })}`, head = async () => {
      const answer = await fetch(`head${search}`);
      if (answer.headers.get("Content-Type") === "application/octet-stream") return answer.arrayBuffer();
      const found = await answer.json();
      if (found?.error) throw new Error(found.error);
      return found;
    };
    let found = null;
    while (!(found = await head())) await new Promise((done) => { setTimeout(done, 200); });
    return found instanceof ArrayBuffer ? Run.unpack(found) : Run.live(found, new EventSource(`events${search}`), onchange);
  }

  /** Follows a run that goes on. */
  static live(head, events, onchange) {
    const run = new Run(head);
    run.going = true;
    return new Promise((ready) => {
      const end = () => { run.going = false; onchange(false); };
      let opened = 0;
      events.onopen = () => { if (opened++) location.reload(); }; // the server counts what each connection has got
      events.onmessage = ({ data }) => {
        const fresh = run.grow(JSON.parse(data));
        run.going = true;
        ready(run);
        onchange(fresh);
      };
      events.addEventListener("over", () => { events.close(); end(); });
      events.onerror = end;
    });
  }

  /** What a reader wants first: the cause of the first failure, else the first reflex, else the start. */
  get moment() { return this.decisive[0] ?? { t: this.start, address: "" }; }

  /** Takes a message of a run that goes on; returns whether new tracks began. */
  grow({ end, log, tracks, decisive = this.decisive, about = {} }) {
    let fresh = false;
    this.poses.clear();
    Object.assign(this, about, { end, decisive });
    this.log.push(...log);
    for (const [address, from, t, v, width, ray] of tracks) {
      if (!this.tracks.has(address)) { this.add(new Track(address, [], [], width, ray)); fresh = true; }
      this.tracks.get(address).grow(from, t, v);
    }
    return fresh;
  }

  /** Whether something has this address; empty for nothing. */
  has(address) {
    const [agent, topic] = address.split("|", 2), name = address.slice(agent.length + 6); // of a rule or a node
    const node = this.get(agent, "tree")?.v.flat().some(({ path }) => path === name);
    const there = { outcome: true, pose: true, rule: name in (this.guards[agent] ?? {}), node };
    return !address || this.tracks.has(address) || (this.agents.includes(agent) && Boolean(there[topic]));
  }

  /** Guard of a rule at a time: that of the header, until its file is replaced. */
  guard(agent, rule, t) {
    const found = this.get(agent, "guards", rule)?.at(t);
    return found ? guardOf(found) : this.guards[agent]?.[rule];
  }

  get(agent, topic, name = "") { return this.tracks.get(`${agent}|${topic}|${name}`); }

  of(agent, topic) { return this.topics.get(`${agent}|${topic}`) ?? []; }

  info(agent) { return this.header.agents.find((a) => a.name === agent); }

  /** How a track has just changed: new, changed or removed; nothing if it has not. */
  change(track, t) {
    const i = track ? upto(track.t, t) - 1 : -1;
    if (i < 0 || t - track.t[i] >= FRESH || track.t[i] <= this.start + 0.1) return "";
    if ((track.v[i] ?? null) === null) return "removed";
    return (track.v[i - 1] ?? null) === null ? "new" : "changed";
  }

  /** Unit of a signal; empty for a plain number. */
  unit(agent, signal) {
    const units = this.info(agent)?.signals?.find((s) => s.name === signal.replace(/^min\(|\)$/g, ""))?.units ?? [];
    return new Set(units).size === 1 && units[0] !== "1" ? units[0] : "";
  }

  /** Pose of a body at a time; null if it is not known. Many parts of the page ask for those at the cursor. */
  pose(body, t) {
    if (this.poses.get(body)?.t !== t) {
      const [x = NaN, y, yaw, z, roll, pitch] = this.get(body, "pose")?.between(t, [2, 4, 5]) ?? [];
      this.poses.set(body, { t, pose: Number.isNaN(x) ? null : { x, y, yaw, z, roll, pitch } });
    }
    return this.poses.get(body).pose;
  }

  /** Outcome of an agent, or null while it has none; a recording that was cut off has it in its summary only. */
  outcome(agent) {
    const result = this.results?.[agent];
    return this.get(agent, "outcome")?.v.at(-1) ?? (result ? { ...result, t: this.end } : null);
  }

  /** Colour of an outcome: red for failures only. */
  tone(outcome) { return outcome === "success" ? "good" : ["timeout", "interrupted", "unknown", undefined].includes(outcome) ? "muted" : "bad"; }

  /** Paths of the nodes from the root to the leaf that made the mission fail at a time; empty if it did not. */
  failing(agent, t) {
    const nodes = this.get(agent, "tree")?.at(t) ?? [], children = new Map(nodes.map((n) => [n.path, n.children ?? []])), found = [];
    const failed = (path) => this.get(agent, "node", path)?.at(t) === "FAILURE", since = (path) => this.get(agent, "node", path)?.since(t) ?? -Infinity;
    for (let path = nodes[0]?.path; path && failed(path);) {
      found.push(path);
      path = children.get(path).filter(failed).reduce((a, b) => (a !== undefined && since(a) > since(b) ? a : b), undefined);
    }
    return found;
  }
}

/** A number of a live message: what JSON has no number for comes as text. */
const real = (value) => ({ "NaN": NaN, "∞": Infinity, "−∞": -Infinity })[value] ?? value;

/** Times and rows of several step functions together. @returns {[number[], number[]]} */
const merged = (times, values) => {
  const t = [...new Set(times.flatMap((each) => [...each]))].sort((a, b) => a - b), at = times.map(() => 0), rows = [];
  for (const when of t) times.forEach((each, k) => { if (each[at[k]] <= when) at[k]++; rows.push(values[k][Math.max(0, at[k] - 1)]); });
  return [t, rows];
};

/** Column of numbers from differences of neighbours, whose bytes are in planes. */
const unpacked = (bytes, start, [count, width, resolution, size, top]) => {
  const rows = count / width, whole = new Int32Array(count);
  for (let column = 0; column < width; column++) {
    let sum = 0;
    for (let row = 0; row < rows; row++) {
      let step = 0;
      for (let i = 0; i < size; i++) step |= bytes[start + i * count + column * rows + row] << (8 * i);
      sum = (sum + ((step >>> 1) ^ -(step & 1))) | 0;
      whole[row * width + column] = sum;
    }
  }
  if (resolution === 1) return whole;
  return Float64Array.from(whole, (w) => (w > top ? OTHERS[w - top - 1] : w * resolution));
};
