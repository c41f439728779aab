// @ts-check
// The selected thing in words: its state at the cursor, why it is so, and what led to it.
import { el, put, seconds, short, shown, upto } from "./dom.js";
import { portsOf } from "./run.js";
import { why, whyNot } from "./why.js";

const MOVES = { reactive: "a reflex", deliberative: "its mission", idle: "nothing" };
const SIGNALS = ["speed", "turn_rate", "goal_distance", "battery"];
const FELT = ["collision", "stuck", "fell"]; // outcomes that a reflex is to prevent
const LED = 2; // [s] before an outcome, of which warnings are listed

/** @typedef {{label: string, text: string, address?: string, t?: number}} Row */
const row = (label, text, address, t) => ({ label, text, address, t });

export class Inspector {
  constructor(run, cursor) {
    this.run = run;
    this.cursor = cursor;
    this.last = "";
    this.box = el("aside", { class: "inspector", "aria-live": "off" });
    for (const name of ["select", "agent", "move"]) cursor.addEventListener(name, () => this.update());
  }

  update() {
    const { cursor: { t, agent, selected } } = this, [given = "", topic = ""] = selected.split("|", 2);
    const track = this.run.tracks.get(selected), name = selected.slice(given.length + topic.length + 2), who = given || agent;
    const views = { node: this.node, rule: this.rule, ticket: this.ticket, outcome: this.outcome, pose: this.robot };
    const [title, ...rows] = (views[topic] ?? (track ? this.track : this.robot)).call(this, who, name, t, track);
    const key = JSON.stringify([title, rows]);
    if (key === this.last) return;
    this.last = key;
    this.box.replaceChildren(el("h3", {}, title), ...rows.map((r) => this.line(r)));
  }

  line({ label, text, address, t }) {
    const go = () => (address === undefined ? this.cursor.move(t) : this.cursor.select(address, t));
    if (address === undefined && t === undefined) return el("div", { class: "row" }, el("span", {}, label), el("b", {}, text));
    return el("div", { class: "row link", role: "link", tabindex: 0, onclick: go, onkeydown: (e) => { if (e.key === "Enter") go(); } }, el("span", {}, label), el("b", {}, text));
  }

  robot(agent, _, t) {
    if (!this.run.header.bodies?.length) return [agent, ...[["of", this.run.header.command], ["about", this.run.info(agent)?.mission]].filter(([, text]) => text).map(([label, text]) => row(label, text))];
    const { run } = this, rows = [row("moved by", MOVES[run.get(agent, "route")?.at(t)] ?? "–")], pose = run.pose(agent, t);
    for (const hold of run.of(agent, "hold")) if (hold.at(t)) rows.push(row("held", `${hold.name}: ${hold.at(t)}`, hold.address));
    rows.unshift(row("why", why(run, agent, t)));
    for (const rule of run.of(agent, "rule")) {
      const state = rule.at(t);
      if (state?.active) rows.push(row("rule", `${short(rule.name)} for ${seconds(t - rule.since(t))}: ${state.reading ?? ""}`, rule.address));
    }
    for (const ticket of run.of(agent, "ticket")) {
      const now = ticket.at(t);
      if (now?.state === "RUNNING") rows.push(row("action", `${now.action} for ${seconds(t - ticket.since(t))}`, ticket.address));
    }
    for (const { track, note } of this.waiting(agent, t)) rows.push(row("node", `${short(track.name)}${note && `: ${note}`}`, track.address));
    for (const name of SIGNALS) {
      const track = run.get(agent, "signal", name);
      if (track) rows.push(row(name, `${shown(track.at(t))} ${run.unit(agent, name)}`, track.address));
    }
    if (pose) rows.push(row("pose", `${pose.x.toFixed(2)}, ${pose.y.toFixed(2)} m, ${((pose.yaw * 180) / Math.PI).toFixed(0)}°`));
    const outcome = run.outcome(agent);
    if (outcome) rows.push(row("outcome", [outcome.outcome, outcome.reason].filter(Boolean).join(": "), `${agent}|outcome|`, outcome.t));
    return [agent, ...rows];
  }

  /** Nodes in which the mission waits: RUNNING nodes without a RUNNING child. */
  waiting(agent, t) {
    const { run } = this, status = (path) => run.get(agent, "node", path)?.at(t);
    return (run.get(agent, "tree")?.at(t) ?? [])
      .filter(({ path, children = [] }) => status(path) === "RUNNING" && !children.some((child) => status(child) === "RUNNING"))
      .slice(0, 4).map(({ path }) => ({ track: run.get(agent, "node", path), note: run.get(agent, "note", path)?.at(t) ?? "" }));
  }

  outcome(agent) {
    const { run } = this, found = run.outcome(agent);
    if (!found) return [agent, row("outcome", "none yet")];
    const { outcome, reason, time_to_goal: reached, t: at } = found;
    const rows = [row("reason", reason || "–"), row("at", seconds(at), `${agent}|outcome|`, at)];
    if (reached !== null) rows.push(row("time to goal", seconds(reached)));
    if (FELT.includes(outcome)) for (const rule of Object.keys(run.guards[agent] ?? {})) {
      const { because } = whyNot(run, agent, rule, at);
      rows.push(row(short(rule), run.get(agent, "rule", rule)?.at(at)?.active ? because : `did not fire: ${because}`, `${agent}|rule|${rule}`, at));
    }
    for (const [when, , , text, about] of run.log.filter((l) => l[1] === agent && l[0] > at - LED && l[0] <= at && l[2] >= 3)) {
      rows.push(row(seconds(when), text, about || undefined, when));
    }
    for (const { name, text, t: when } of run.results?.[agent]?.requirements ?? []) rows.push(row(name, text, undefined, when ?? undefined));
    for (const [name, value] of run.results?.[agent]?.numbers ?? []) rows.push(row(name, value));
    return [`${agent}: ${outcome}`, ...rows];
  }

  rule(agent, name, t, track) {
    const { run } = this, state = track?.at(t), guard = run.guards[agent]?.[name], address = `${agent}|rule|${name}`;
    const is = state?.active ? "its action is active" : state?.waits ? "latched, waits behind another reflex" : state?.latched ? "latched" : "clear";
    const rows = [row("state", track ? `${is}${track.since(t) === undefined ? "" : ` for ${seconds(t - track.since(t))}`}` : "it never changed")];
    rows.push(state?.active ? row("why", why(run, agent, t)) : row("why not", whyNot(run, agent, name, t).because));
    if (guard) rows.push(row("when", guard.when), ...(guard.until ? [row("until", guard.until)] : []));
    for (const [key, value] of Object.entries(guard?.thresholds ?? {})) rows.push(row(key, value));
    for (const side of guard?.sides ?? []) rows.push(this.comparison(agent, side, t));
    if (state?.reading) rows.push(row("read", `${state.reading}, ${seconds(t - track.since(t))} ago`, address, track.since(t)));
    for (const [key, value] of Object.entries(state?.parameters ?? {})) rows.push(row(key, shown(value)));
    const fired = Array.from(track?.t ?? []).filter((_, i) => track.v[i].fired > (track.v[i - 1]?.fired ?? 0));
    rows.push(row("fired", fired.length === 1 ? "once" : fired.length ? `${fired.length} times` : "never"));
    const before = fired.findLast((s) => s < t - 1e-3), next = fired.find((s) => s > t + 1e-3);
    if (before !== undefined) rows.push(row("previous", seconds(before), address, before));
    if (next !== undefined) rows.push(row("next", seconds(next), address, next));
    if (guard?.place) rows.push(row("does", `${guard.action}: ${guard.doc}`), row("priority", guard.priority), row("file", guard.place));
    return [short(name), ...rows];
  }

  /** One comparison of a guard now: whether it holds, and by how much. */
  comparison(agent, { name, text, unit }, t) {
    const track = this.run.get(agent, "compare", name), [left, right, holds] = track?.at(t) ?? [NaN, NaN, NaN];
    const gap = Math.abs(left - right), word = Number.isNaN(holds) ? "not decided" : holds > 0 ? "holds" : "does not hold";
    const by = Number.isFinite(gap) ? ` by ${shown(gap)} ${unit}` : "";
    return row("compares", `${text}: ${shown(left)} and ${shown(right)} ${unit}, ${word}${by}`, track?.address);
  }

  node(agent, path, t, track) {
    const { run } = this, about = (run.get(agent, "tree")?.at(t) ?? []).find((node) => node.path === path);
    const state = track?.at(t) ? `${track.at(t)} for ${seconds(t - track.since(t))}` : track ? "not ticked yet" : "never ticked";
    const rows = [row("type", about?.type ?? "–"), row("status", state), row("why", why(run, agent, t))], note = run.get(agent, "note", path)?.at(t);
    if (note) rows.push(row("message", note));
    for (const { name, given, entry } of about ? portsOf(about) : []) {
      const value = entry && run.get(agent, "board", entry);
      rows.push(row(name, entry ? `${given} = ${value?.at(t) ?? "no value"}` : given, value?.address));
    }
    for (const ticket of run.of(agent, "ticket").filter((k) => k.v[0].by === path && k.t[0] <= t).slice(-3)) {
      rows.push(row("sent", `${ticket.v[0].action} #${ticket.name}: ${ticket.at(t).state}`, ticket.address));
    }
    rows.push(...this.nearby(track, t, (status) => status ?? "removed"), row("path", path));
    return [short(path), ...rows];
  }

  ticket(agent, number, t, track) {
    const { run } = this, last = track.v.at(-1), by = run.get(agent, "node", last.by) ?? run.get(agent, "rule", last.by);
    const rows = [row("state", track.at(t)?.state ?? "not sent yet"), row("by", last.by, by?.address)];
    track.v.forEach((v, i) => rows.push(row(seconds(track.t[i]), v.state, track.address, track.t[i])));
    if (last.reason) rows.push(row("reason", last.reason));
    for (const [key, value] of Object.entries(last.parameters)) rows.push(row(key, shown(value)));
    return [`${last.action} #${number}`, ...rows];
  }

  track(agent, name, t, track) {
    const unit = track.topic === "signal" ? this.run.unit(agent, name) : "", value = (v) => `${shown(v)} ${unit}`;
    const rows = [row("value", value(track.at(t)))];
    if (track.since(t) !== undefined) rows.push(row("since", seconds(track.since(t)), track.address, track.since(t)));
    if (track.width === 1) {
      let low = 0, high = 0;
      track.v.forEach((v, i) => { if (v < track.v[low]) low = i; if (v > track.v[high]) high = i; });
      rows.push(row("least", `${value(track.v[low])} at ${seconds(track.t[low])}`, track.address, track.t[low]));
      rows.push(row("greatest", `${value(track.v[high])} at ${seconds(track.t[high])}`, track.address, track.t[high]));
    } else if (track.width) {
      track.row(Math.max(0, upto(track.t, t) - 1)).slice(0, 24).forEach((v, i) => rows.push(row(`[${i}]`, value(v))));
    } else rows.push(...this.nearby(track, t, shown));
    return [name.replaceAll("\n", " ").trim() || track.topic, ...rows];
  }

  /** Changes of a track around a time. */
  nearby(track, t, text) {
    if (!track) return [];
    const i = upto(track.t, t) - 1, found = [];
    for (let j = Math.max(0, i - 2); j < Math.min(track.t.length, i + 3); j++) found.push(row(seconds(track.t[j]), text(track.v[j]), track.address, track.t[j]));
    return found;
  }
}
