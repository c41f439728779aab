// @ts-check
// The selected thing in words: one sentence with its cause, the evidence, what came next, and numbers that are folded.
import { View } from "./cursor.js";
import { el, put, seconds, short, shown, upto } from "./dom.js";
import { portsOf } from "./run.js";
import { Mission, three, why, whyNot } from "./why.js";

const MOVES = { reactive: "a reflex", deliberative: "its mission", idle: "nothing" };
const SIGNALS = ["speed", "turn_rate", "goal_distance", "battery"];
const FELT = ["collision", "stuck", "fell"]; // outcomes that a reflex is to prevent
const LED = 2; // [s] before an outcome, of which warnings are listed
const MARKS = { SUCCESS: "✓", FAILURE: "✗", RUNNING: "▶" };
const TRIES = 5; // attempts of a node that are listed
const MANY = 24; // values of a signal that are listed

/** @typedef {{label: string, text: string, address?: string, t?: number}} Row */
/** @typedef {{title: string, cause: string, evidence?: Row[], next?: Row[], more?: Row[]}} Said */
/** @returns {Row} */
const row = (label, text, address, t) => ({ label, text, address, t });
const lasts = (track, t) => (t - track?.since(t) >= 0.01 ? ` for ${seconds(t - track.since(t))}` : "");

/** Sets a sentence whose asides, in brackets after a space, are paler than the rest. */
const stress = (element, text) => {
  if (element.shown === text) return;
  element.shown = text;
  const parts = text.split(/( \((?:[^()]|\([^()]*\))*\))/);
  element.replaceChildren(...parts.map((part, i) => (i % 2 ? el("span", {}, part) : part)));
};

export class Inspector extends View {
  constructor(run, cursor) {
    super(run, cursor, el("aside", { class: "inspector", "aria-live": "off" }));
    this.shape = "";
    this.open = false; // whether a reader has unfolded the numbers
  }

  update() {
    const { cursor: { t, agent, selected }, run } = this, [of = "", topic = ""] = selected.split("|", 2);
    const track = run.tracks.get(selected), name = selected.slice(of.length + topic.length + 2), who = of || agent;
    const robot = run.info(who) ? this.robot : this.actor, { node, rule, ticket, outcome, alternation, actor, sensor } = this;
    const view = { node, rule, ticket, outcome, alternation, actor, sensor, pose: robot }[topic] ?? (track ? this.track : robot);
    const { title, cause, evidence = [], next = [], more = [] } = view.call(this, who, name, t, track);
    const rows = [...evidence, ...next, ...more], plain = ({ address, t: at }) => address === undefined && at === undefined;
    const shape = [cause === "", evidence.length, next.length, ...rows.map(plain)].join();
    if (shape !== this.shape) this.make(shape, cause, evidence.length, next.length, rows.map(plain));
    put(this.title, title);
    stress(this.cause, cause);
    this.lines.forEach((line, i) => { line.row = rows[i]; put(line.firstChild, rows[i].label); put(line.lastChild, rows[i].text); });
  }

  /** Makes the elements of a view; while the cursor moves, mostly their texts change only. */
  make(shape, cause, evidence, next, plain) {
    this.shape = shape;
    this.title = el("h3");
    this.cause = el("p", { class: "cause", hidden: !cause });
    this.lines = plain.map((each) => this.line(each));
    const lines = (from, to, name) => (from < to ? [...(name ? [el("h4", {}, name)] : []), ...this.lines.slice(from, to)] : []), folds = evidence + next;
    const about = { open: this.open, hidden: folds === plain.length, ontoggle: () => { this.open = folded.open; } };
    const folded = el("details", about, el("summary", {}, "numbers and data"), ...lines(folds, plain.length));
    this.box.replaceChildren(this.title, this.cause, ...lines(0, evidence), ...lines(evidence, folds, "then"), folded);
  }

  line(plain) {
    const go = ({ currentTarget: { row: { address, t } } }) => (address === undefined ? this.cursor.move(t) : this.cursor.select(address, t));
    const acts = { class: "row link", role: "link", tabindex: 0, onclick: go, onkeydown: (e) => { if (e.key === "Enter") go(e); } };
    return el("div", plain ? { class: "row" } : acts, el("span"), el("b"));
  }

  /** @returns {Said} */
  robot(agent, _, t) {
    const { run } = this, about = run.info(agent), evidence = [], pose = run.pose(agent, t), mission = new Mission(run, agent, t);
    if (!run.header.bodies?.length) return { title: agent, cause: about?.mission ?? "", evidence: run.header.command ? [row("of", run.header.command)] : [] };
    for (const hold of run.of(agent, "hold").filter((each) => each.at(t))) evidence.push(row("held", `${hold.name}: ${hold.at(t)}`, hold.address));
    for (const rule of run.of(agent, "rule").filter((each) => each.at(t)?.active)) {
      evidence.push(row("rule", `${short(rule.name)}${lasts(rule, t)}`, rule.address), ...this.guard(agent, rule.name, t));
    }
    for (const ticket of run.of(agent, "ticket").filter((each) => each.at(t)?.state === "RUNNING")) {
      evidence.push(row("action", `${ticket.v[0].action}${lasts(ticket, t)}`, ticket.address));
    }
    for (const path of mission.root ? mission.waiting().slice(0, 4) : []) {
      const text = [short(path), mission.note(path)].filter(Boolean).join(": ");
      evidence.push(row("node", `${MARKS[mission.status(path)] ?? "·"} ${text}`, `${agent}|node|${path}`));
    }
    const outcome = run.outcome(agent), next = this.later(agent, t);
    if (outcome) next.push(row("outcome", outcome.outcome, `${agent}|outcome|`, outcome.t));
    const more = SIGNALS.map((name) => run.get(agent, "signal", name)).filter(Boolean)
      .map((track) => row(track.name, `${shown(track.at(t))} ${run.unit(agent, track.name)}`, track.address));
    if (pose) more.push(row("pose", this.place(pose)));
    return { title: agent, cause: why(run, agent, t), evidence, next, more: [row("moved by", MOVES[run.get(agent, "route")?.at(t)] ?? "–"), ...more] };
  }

  /** The next line of the log about an agent. */
  later(agent, t) {
    const log = this.run.log.find(([at, who, level]) => who === agent && level > 1 && at > t + 1e-3);
    return log ? [row(seconds(log[0]), log[3], log[4] || undefined, log[0])] : [];
  }

  place({ x, y, yaw }) { return `${x.toFixed(2)}, ${y.toFixed(2)} m, ${((yaw * 180) / Math.PI).toFixed(0)}°`; }

  /** A body without an agent. @returns {Said} */
  actor(name, _, t) {
    const { run } = this, track = run.get(name, "actor"), pose = run.pose(name, t), state = track?.at(t) ?? "at rest";
    if (!pose) return { title: name, cause: "It is not in the recorded world." };
    const near = run.agents.map((agent) => [agent, run.pose(agent, t)]).filter(([, at]) => at)
      .map(([agent, at]) => row(agent, `${Math.hypot(at.x - pose.x, at.y - pose.y).toFixed(2)} m away`, `${agent}|pose|`));
    const cause = `${state === "moves" ? "It moves" : `It is ${state}`}${lasts(track, t)}.`;
    return { title: name, cause, evidence: near, next: this.after(track, t), more: [row("pose", this.place(pose))] };
  }

  /** @returns {Said} */
  outcome(agent) {
    const { run } = this, found = run.outcome(agent), results = run.results?.[agent] ?? {}, evidence = [];
    if (!found) return { title: agent, cause: "It has no outcome yet." };
    const { outcome, reason, time_to_goal: reached, t: at } = found, after = reached ? ` ${seconds(reached)} after the start` : "";
    const locked = run.decisive.find((each) => each.text && each.address.startsWith(`${agent}|`));
    if (locked) evidence.push(row("from", locked.text, locked.address, locked.t));
    const felt = run.decisive.find(({ address }) => address === `${agent}|outcome|`)?.t ?? at; // of a collision, which need not end the run
    if (FELT.includes(outcome)) for (const rule of Object.keys(run.guards[agent] ?? {})) {
      const { because } = whyNot(run, agent, rule, felt), state = run.get(agent, "rule", rule)?.at(felt);
      evidence.push(row(short(rule), state?.active || state?.waits ? because : `did not fire: ${because}`, `${agent}|rule|${rule}`, felt));
    }
    for (const { name, require, text, t: when } of results.requirements ?? []) {
      const mark = text.startsWith("violated") ? "✗" : text.startsWith("satisfied") ? "✓" : "?", says = require === name ? "" : ` (${require})`;
      evidence.push(row(name, `${mark} ${text}${says}`, undefined, when ?? undefined));
    }
    const before = Math.max(run.start, at - 0.01);
    evidence.push(row("before", why(run, agent, before), `${agent}|pose|`, before), ...this.near(agent, { name: "outcome" }, at));
    for (const [when, , , text, about] of run.log.filter((l) => l[1] === agent && l[0] > at - LED && l[0] <= at && l[2] >= 3 && !l[4].endsWith("|outcome|"))) {
      evidence.push(row(seconds(when), text, about || undefined, when));
    }
    const cause = reason ? `${reason.includes(seconds(at)) ? "" : `At ${seconds(at)}: `}${reason}.` : `At ${seconds(at)}${after}.`;
    return { title: `${agent}: ${outcome}`, cause, evidence, more: (results.numbers ?? []).map(([name, value]) => row(name, value)) };
  }

  /** A sensor that has failed: since when, and the last values of its signals. @returns {Said} */
  sensor(agent, name, t, track) {
    const { run } = this, about = run.info(agent)?.sensors?.find((each) => each.name === name), failed = track.at(t);
    const signal = (each) => run.get(agent, "signal", each) ?? run.get(agent, "signal", `min(${each})`);
    const evidence = (about?.signals ?? []).map(signal).filter(Boolean).map((each) => {
      const last = Array.from(each.t.slice(0, upto(each.t, t))).findLast((at) => !Array.from(each.at(at)).every(Number.isNaN));
      const text = last === undefined ? "no value yet" : `${shown(each.at(last))} ${run.unit(agent, each.name)} since ${seconds(last)}`;
      return row(`last ${each.name}`, text, each.address, last);
    });
    const works = track.since(t) === undefined ? "It gives data; it fails later." : "It gives data again.";
    return { title: `sensor ${name}`, cause: failed ? `It has given no data${lasts(track, t)}: ${failed}` : works, evidence, next: this.after(track, t) };
  }

  /** Two rules or actions that alternate. @returns {Said} */
  alternation(agent, _, t, track) {
    const { run } = this, found = track?.v.filter((each) => each && each.begin <= t + 1e-3 && t <= each.last + each.pause).at(-1);
    if (!found) return { title: "alternation", cause: "No rules or actions alternate now." };
    const { begin, last, changes, moved, text, names } = found;
    const evidence = names.map((name) => {
      const rule = run.get(agent, "rule", name), first = rule?.t.find((at) => at >= begin - 1e-3 && rule.at(at).active);
      return row(short(name), first === undefined ? "an action of the mission" : `first at ${seconds(first)}: ${rule.at(first).reading}`, rule?.address, first);
    });
    const next = this.later(agent, last);
    return { title: "alternation", cause: `${text}.`, evidence, next, more: [row("changes", shown(changes)), row("moved", `${shown(moved)} m`)] };
  }

  /** @returns {Said} */
  rule(agent, name, t, track) {
    const { run } = this, state = track?.at(t), address = `${agent}|rule|${name}`, about = run.guard(agent, name, t);
    const fired = track?.hits ?? [], again = fired.length - (track?.v.at(-1)?.fired ?? 0), times = (n) => (n === 1 ? "once" : `${n} times`);
    const total = `${times(fired.length)}${again ? `, ${again} of them again while it was latched` : ""}`, { because } = whyNot(run, agent, name, t);
    const next = [row("fired", fired.length ? total : "never")], around = [fired.findLast((s) => s < t - 1e-3), fired.find((s) => s > t + 1e-3)];
    around.forEach((at, i) => { if (at !== undefined) next.push(row(["previous", "next"][i], seconds(at), address, at)); });
    const more = state?.reading ? [row("read", `${state.reading}, ${seconds(t - track.since(t))} ago`, address, track.since(t))] : [];
    for (const [key, value] of Object.entries({ ...about?.thresholds, ...state?.parameters })) more.push(row(key, shown(value)));
    if (about?.place) more.push(row("does", `${about.action}: ${about.doc}`), row("priority", about.priority), row("file", about.place));
    const active = run.of(agent, "ticket").map((ticket) => ticket.at(t)).find((ticket) => ticket?.state === "RUNNING" && ticket.by === name);
    const told = active || (state?.active && run.get(agent, "failures", name)?.at(t)); // the robot does what the rule does
    const still = state?.waits ? because.slice(3) : `did not fire: ${because}`;
    const cause = told ? why(run, agent, t) : state?.active ? `It fired, and its action is active${lasts(track, t)}.` : `${short(name)} ${still}.`;
    return { title: short(name), cause, evidence: this.guard(agent, name, t), next, more };
  }

  /** The comparisons of a guard: whether each is true, both sides, and by how much. @returns {Row[]} */
  guard(agent, rule, t) {
    const { run } = this, guard = run.guard(agent, rule, t), since = run.get(agent, "guard", rule)?.at(t)?.since;
    const lasting = guard?.hold ? [row("for", `${three(guard.hold)} s${since === undefined ? "" : `: held for ${seconds(t - since)}`}`)] : [];
    const sides = (guard?.sides ?? []).map(({ name, text, unit }) => {
      const track = run.get(agent, "compare", name), [left, right, holds] = track?.at(t) ?? [NaN, NaN, NaN], gap = Math.abs(left - right);
      const si = unit && ` ${unit}`, by = Number.isFinite(gap) ? `, by ${three(gap)}${si}` : "";
      const values = Number.isNaN(holds) ? "a value is not known" : `${shown(left)} against ${shown(right)}${si}${by}`;
      return row(guard.when.includes(text) ? "when" : "until", `${Number.isNaN(holds) ? "?" : holds > 0 ? "✓" : "✗"} ${text}: ${values}`, track?.address);
    });
    return [...sides, ...lasting];
  }

  /** @returns {Said} */
  node(agent, path, t, track) {
    const { run } = this, mission = new Mission(run, agent, t), about = mission.nodes.get(path), evidence = [], at = (child) => `${agent}|node|${child}`;
    for (const child of about?.children ?? []) {
      const note = mission.note(child), word = mission.status(child) || "not ticked";
      evidence.push(row(MARKS[word] ? `${MARKS[word]} ${word}` : `· ${word}`, `${short(child)}${note && `: ${note}`}`, at(child)));
    }
    for (const { name, given: text, entry } of about ? portsOf(about) : []) {
      const value = entry && run.get(agent, "board", entry);
      evidence.push(row(name, entry ? `${text} = ${value?.at(t) ?? "no value"}` : text, value?.address));
    }
    for (const ticket of run.of(agent, "ticket").filter((k) => k.v[0].by === path && k.t[0] <= t).slice(-3)) {
      evidence.push(row("sent", `${ticket.v[0].action} #${ticket.name}: ${ticket.at(t).state}`, ticket.address), ...this.near(agent, ticket, t));
    }
    if (mission.status(path) === "RUNNING" && !about?.children?.length) evidence.push(row("robot", why(run, agent, t), `${agent}|pose|`));
    const more = [row("type", about?.type ?? "–"), row("path", path), ...this.nearby(track, t, (status) => status ?? "removed", 1)];
    const cause = this.status(mission, path, lasts(track, t)), next = [...this.attempts(agent, path, track, t), ...this.after(track, t)];
    return { title: short(path), cause, evidence, next, more };
  }

  /** Attempts of a node that was tried several times, those around a time; each is a link to its end. */
  attempts(agent, path, track, t) {
    const all = track?.attempts ?? [], here = all.findLastIndex(({ from }) => from <= t + 1e-6), notes = this.run.get(agent, "note", path);
    const first = Math.max(0, Math.min(here - 2, all.length - TRIES));
    return all.length < 2 ? [] : all.slice(first, first + TRIES).map(({ from, to, status }, k) => {
      const i = first + k, note = notes?.at(to + 1e-3), text = `${status}${to > from ? ` after ${seconds(to - from)}` : ""}${note ? `: ${note}` : ""}`;
      return row(`${i === here ? "▸ " : ""}attempt ${i + 1} of ${all.length}`, `${seconds(to)} ${text}`, track.address, to);
    });
  }

  /** The status of a node and its cause, which is itself or a node below or before it. */
  status(mission, path, lasting) {
    const status = mission.status(path), leaf = status && mission.lowest(path), note = mission.note(leaf);
    if (status) {
      const below = leaf !== path && `'${short(leaf)}'${mission.status(leaf) === status ? "" : ` is ${mission.status(leaf)}`}`;
      const cause = [below, note, leaf !== path && mission.note(path)].filter(Boolean).join(", ");
      return `${status}${lasting}${cause && `: ${cause}`}.`;
    }
    const parent = [...mission.nodes.values()].find(({ children = [] }) => children.includes(path));
    if (!parent) return "It has not been ticked.";
    if (!mission.status(parent.path)) return `It has not been ticked, because '${short(parent.path)}' has not.`;
    const before = parent.children.slice(0, parent.children.indexOf(path)).findLast((child) => mission.status(child));
    return `It has not been ticked${before ? `: '${short(before)}' before it is ${mission.status(before)}` : ""}.`;
  }

  /** @returns {Said} */
  ticket(agent, number, t, track) {
    const { run } = this, [first] = track.v, now = track.at(t), evidence = [], next = [];
    const rule = run.get(agent, "rule", first.by), from = (name) => run.get(agent, "node", name) ?? run.get(agent, "rule", name);
    const ended = now && now.state !== "RUNNING" && now.by !== first.by ? ` by '${now.by}'` : "", because = now?.reason ? `: ${now.reason}` : "";
    const what = `${first.action} of the ${rule ? "rule" : "leaf"} '${short(first.by)}'`;
    const cause = now ? `${what} is ${now.state}${ended}${lasts(track, t)}${because}.` : "It has not been sent.";
    for (const name of new Set(track.v.map((v) => v.by))) evidence.push(row("by", name, from(name)?.address));
    track.v.forEach((v, i) => (track.t[i] <= t + 1e-6 ? evidence : next).push(row(seconds(track.t[i]), v.state, track.address, track.t[i])));
    const read = rule?.at(track.t[0])?.reading;
    if (read) evidence.push(row("because", read, rule.address, track.t[0]), ...this.near(agent, rule, track.t[0]));
    evidence.push(...Object.entries(first.parameters).map(([key, value]) => row(key, shown(value))), ...this.near(agent, track, t));
    return { title: `${first.action} #${number}`, cause, evidence, next };
  }

  /** What was near when an action failed. */
  near(agent, { name }, t) { return [this.run.get(agent, "clue", name)?.at(t)].filter(Boolean).map((text) => row("where", text)); }

  /** A signal, a fact, or another thing that changes. @returns {Said} */
  track(agent, name, t, track) {
    const unit = track.topic === "signal" ? this.run.unit(agent, name) : "", value = (v) => `${shown(v)} ${unit}`.trim(), more = [], since = track.since(t);
    const title = name.replaceAll("\n", " ").trim() || track.topic, evidence = since === undefined ? [] : [row("since", seconds(since), track.address, since)];
    const word = name.replace(/^min\(|\)$/g, ""), uses = new RegExp(`\\b${word.replaceAll(/\W/g, "\\$&")}\\b`);
    if (track.topic === "signal") for (const rule of Object.keys(this.run.guards[agent] ?? {})) {
      for (const each of this.guard(agent, rule, t).filter(({ text }) => uses.test(text))) evidence.push({ ...each, label: short(rule) });
    }
    if (track.width === 1) track.range.forEach((found, i) => {
      const at = track.t[Math.max(0, track.v.indexOf(found))];
      more.push(row(["least", "greatest"][i], `${value(track.at(at))} at ${seconds(at)}`, track.address, at));
    }); else if (track.width) {
      track.row(Math.max(0, upto(track.t, t) - 1)).slice(0, MANY).forEach((v, i) => more.push(row(`[${i}]`, value(v))));
    } else evidence.push(...this.nearby(track, t, shown));
    const now = track.at(t), known = now !== undefined && now !== null && !(track.width && Array.from(now).every(Number.isNaN));
    return { title, cause: known ? `${title} is ${value(now)}.` : `${title} has no valid value.`, evidence, more };
  }

  /** The next change of a track. */
  after(track, t) {
    const i = track ? upto(track.t, t) : 0;
    return track && i < track.t.length ? [row(seconds(track.t[i]), shown(track.v[i] ?? "removed"), track.address, track.t[i])] : [];
  }

  /** Changes of a track before a time, and `after` of it. */
  nearby(track, t, text, after = 3) {
    if (!track) return [];
    const i = upto(track.t, t) - 1, from = Math.max(0, i - 2);
    return Array.from(track.t.slice(from, Math.max(from, i + after)), (at, k) => row(seconds(at), text(track.v[from + k]), track.address, at));
  }
}
