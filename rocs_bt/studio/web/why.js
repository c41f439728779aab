// @ts-check
// Why an agent did what it did at a time, and why a rule did not fire: as `rocs-bt replay --why` (record/why.py).

const SLACK = 5e-4, PUSHED = 1, COASTING = 3; // [s]
const LIMIT = 5e-4; // [m] from the limit of a sensor up to which a value is that limit
const LONG = 24; // values from which on only the least is told

/** A number with digits behind the point; halves are rounded to even digits, as Python does. */
const fixed = (x, digits) => {
  const long = Math.abs(x).toFixed(60), cut = long.length - 60 + digits, floor = long.slice(0, cut);
  const even = /^50*$/.test(long.slice(cut)) && /[02468]\.?$/.test(floor);
  return even ? (x < 0 ? "-" : "") + floor : x.toFixed(digits);
};

/** A number with three digits. @param {number} x */
export const three = (x) => {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
  if (x === 0) return "0";
  const [digits, power] = x.toExponential(2).split("e"), e = Number(power);
  const plain = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  return e < -4 || e > 2 ? `${plain(digits)}e${e < 0 ? "-" : "+"}${String(Math.abs(e)).padStart(2, "0")}` : plain(fixed(x, 2 - e));
};

const PLAIN = { "true": "True", "false": "False", "null": "None", "NaN": "nan", "∞": "inf", "−∞": "-inf" };

/** A value of a parameter as text. */
const told = (value) => {
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : three(value);
  if (!Array.isArray(value)) return PLAIN[value] ?? String(value);
  if (value.length > LONG) {
    const heard = value.filter(Number.isFinite), low = Math.min(...heard);
    return `${value.length} values, ${heard.length} finite${heard.length ? `, minimum ${three(low)} at [${value.indexOf(low)}]` : ""}`;
  }
  return value.length === 1 ? told(value[0]) : `[${value.map(told).join(", ")}]`;
};
const parameters = (values) => Object.entries(values).map(([name, v]) => (v === true ? name : `${name}=${told(v)}`)).join(", ");
const ago = (then, t) => (t - then < SLACK ? "" : `, ${fixed(t - then, 2)} s ago`);
const noted = (text, notes) => { const said = notes.filter(Boolean).join("; "); return said ? `${text} (${said})` : text; };
const last = (name) => name.slice(name.lastIndexOf("/") + 1);

/** Statuses of the nodes of an agent's mission at a time. */
export class Mission {
  constructor(run, agent, now) {
    this.run = run;
    this.agent = agent;
    this.now = now;
    this.nodes = new Map((run.get(agent, "tree")?.at(now) ?? []).map((node) => [node.path, node]));
    const [root = ""] = this.nodes.keys();
    this.root = this.status(root) ? root : "";
  }

  status(path) { return this.run.get(this.agent, "node", path)?.at(this.now) ?? ""; }

  note(path) { return this.run.get(this.agent, "note", path)?.at(this.now) ?? ""; }

  since(path, topic = "node") { return this.run.get(this.agent, topic, path)?.since(this.now) ?? -Infinity; }

  changed(path) { return Math.max(this.since(path), this.since(path, "note")); }

  children(path) { return (this.nodes.get(path)?.children ?? []).filter((child) => this.status(child)); }

  waiting(path = this.root) {
    if (path === this.root && this.status(path) !== "RUNNING") return [];
    const running = this.children(path).filter((child) => this.status(child) === "RUNNING");
    return running.length ? running.flatMap((child) => this.waiting(child)) : [this.lowest(path)];
  }

  /** Messages of the nodes above a node that are RUNNING or failed as the root, nearest first. */
  above(path) {
    const parents = new Map([...this.nodes.values()].flatMap((node) => node.children.map((child) => [child, node.path])));
    const found = [], wanted = this.status(this.root);
    for (let up = parents.get(path); up && this.status(up); up = parents.get(up)) {
      if (this.status(up) === wanted && this.note(up)) found.push(this.note(up));
    }
    return found;
  }

  /** Node below a path that was ticked last and gave its outcome. */
  lowest(path) {
    for (let at = path; ;) {
      const ended = this.children(at).filter((child) => this.status(child) !== "INVALID");
      if (!ended.length) return at;
      const same = ended.filter((child) => this.status(child) === this.status(at));
      at = (same.length ? same : ended).reduce((a, b) => (this.changed(b) >= this.changed(a) ? b : a));
    }
  }
}

/** Why the robot of an agent moved as it did at a time: one sentence. */
export const why = (run, agent, t) => {
  const turns = run.get(agent, "alternation")?.at(t + SLACK);
  return `${answer(run, agent, t)}${turns && t - turns.last <= turns.pause + 1e-6 ? `; ${turns.text}` : ""}.`;
};

const answer = (run, agent, t) => {
  const now = t + SLACK, mission = new Mission(run, agent, now);
  const value = (topic, name = "") => run.get(agent, topic, name)?.at(now);
  const since = (topic, name = "") => ago(run.get(agent, topic, name).since(now), t);
  const running = run.of(agent, "ticket").map((track) => track.at(now)).filter((ticket) => ticket?.state === "RUNNING")
    .sort((a, b) => Number(b.priority === "HIGH") - Number(a.priority === "HIGH"))[0];

  const ended = () => {
    const { root } = mission, status = mission.status(root);
    if (!["SUCCESS", "FAILURE"].includes(status)) return "";
    const leaf = status === "FAILURE" ? mission.lowest(root) : "";
    const about = leaf && noted(`: '${leaf}' failed`, [mission.note(leaf), ...mission.above(leaf)]);
    return `its mission had ended with ${status}${ago(mission.changed(root), t)}${about}`;
  };

  const failures = (rule) => { const found = value("failures", rule); return found ? `, and ${found.text}` : ""; };

  const reflex = () => {
    const rule = last(running.by), state = value("rule", running.by), action = running.action === rule ? "" : ` ${running.action}`;
    if (!state?.firing) return `the rule ${rule} runs${action || ` ${running.action}`}`;
    const [at, phase, reading] = state.firing, { cause, again = 0 } = state, then = ago(at, t);
    const clue = (when) => { const found = run.get(agent, "clue", running.by)?.at(when); return found ? ` (${found})` : ""; };
    let text = `the rule ${rule} fired${action}${then}: ${reading}${clue(at)}`;
    if (phase === "stopped") text = `the rule ${rule} fired, and ${running.action} replaced its action, which raised${then}: ${reading}${clue(at)}`;
    else if (cause && at - cause[0] >= SLACK) {
      const held = `it is latched since t = ${fixed(cause[0], 2)} s, when ${cause[1]}${clue(cause[0])}`;
      text = phase === "fired again"
        ? `the rule ${rule} fired${action} again (${again} re-firing${again === 1 ? "" : "s"})${then}: its action had ended, and ${held}`
        : `the rule ${rule} resumed${action}${then}, after it waited for ${last(state.behind || "another rule")}: ${held}`;
    }
    const clear = `; its guard is clear since t = ${fixed(run.get(agent, "rule", running.by).since(now), 2)} s, and its action goes on`;
    return `${text}${state.phase === "released" ? clear : ""}${failures(running.by)}`;
  };

  const waits = () => `its mission ${mission.waiting().map((path) => {
    const what = [mission.note(path), ...mission.above(path)].filter(Boolean), took = t - mission.since(path);
    return `waits in '${path}'${took > SLACK ? ` for ${fixed(took, 2)} s` : ""}${what.length ? `: ${what.join("; ")}` : ""}`;
  }).join(", and ")}`;

  const cause = () => {
    const failed = value("failed"), by = value("stopped");
    if (failed) {
      const [what] = failed.split("\n", 1);
      return `${what}${since("failed")}: ${failed.slice(what.length + 1)}`;
    }
    if (by !== undefined) return ended() || `it was stopped${since("stopped")} by ${by}`;
    if (running?.priority === "HIGH") return reflex();
    if (running) {
      const leaf = mission.status(running.by) ? `the leaf '${running.by}' of its mission` : `'${running.by}'`;
      return noted(`${leaf} runs ${running.action}(${parameters(running.parameters)})`, mission.above(running.by));
    }
    const failing = run.of(agent, "rule").find((track) => track.at(now)?.active)?.name;
    if (failing) return ended() || `the rule ${last(failing)} is active${failures(failing)}`;
    return ended() || (mission.root ? waits() : "no action was active");
  };

  const linked = (motion, because) => {
    const drives = run.get(agent, "drive"), before = drives?.at(t - SLACK), current = drives?.at(now);
    if (motion === "acted") return `acted because ${because}`;
    if (motion === "was stationary") {
      const commanded = current && !current[3] && value("stopped") === undefined && running;
      return `${motion} ${commanded ? "while" : "because"} ${because}`;
    }
    if (before?.[1] && running && before[1] === running.ticket) return `${motion} because ${because}`;
    for (let i = (drives?.t.length ?? 0) - 1; i >= 0; i--) {
      if (drives.t[i] >= t - SLACK) continue;
      if (t - drives.t[i] > COASTING) break;
      const [, ticket, action, neutral] = drives.v[i];
      if (ticket && !neutral) return `${motion} by the last command of ${action}${ago(drives.t[i], t)}; now ${because}`;
    }
    return `${motion} without a command, while ${because}`;
  };

  const motion = value("motion") ?? "acted", because = cause(), push = value("push");
  const tilt = value("motion", "true tilt") || value("motion", "tilt");
  if (tilt) return `${agent} ${tilt}, while ${because}`;
  if (push && push.t - SLACK <= t && t <= push.t + push.duration + PUSHED) {
    const force = `${three(Math.hypot(...push.force))} N for ${three(push.duration)} s (scripted)`;
    return `${agent} ${motion} and was ${push.agent ? "" : `${push.body} was `}pushed by ${force}${ago(push.t, t)}, while ${because}`;
  }
  const [held] = run.of(agent, "hold").filter((track) => track.at(now)).sort((a, b) => a.since(now) - b.since(now));
  const link = ["was stationary", "acted"].includes(motion) ? "because" : "although";
  if (held) return `${agent} ${motion} ${link} a safety gate holds '${held.name}' in neutral${ago(held.since(now), t)} (${held.at(now)}), while ${because}`;
  return `${agent} ${linked(motion, because)}`;
};

/** What keeps a rule back if no comparison does. */
const back = (guard, { replaced, mode, since, blind, ready }, t) => {
  if (replaced) return "its rule file was replaced, and the new one does not have it";
  if (mode !== undefined) return `it acts in mode ${guard.modes.map((each) => `'${each}'`).join(" or ")} only, and the mode is '${mode}'`;
  if (since === undefined) return "nothing that it compares can make its guard true";
  const unknown = "its guard cannot be evaluated, which counts as true", hold = guard.hold ?? 0, reasons = [];
  const held = `${blind ? `${unknown},` : "its guard has held"} for ${fixed(Math.max(t - since, 0), 2)} s`;
  if (t - since < hold) reasons.push(`${held} of the ${three(hold)} s that it must`);
  if (ready > t) reasons.push(`its cooldown ends in ${fixed(ready - t, 2)} s`);
  return reasons.join(" and ") || (blind ? unknown : "its guard holds");
};

/** Why a rule did not fire at a time: the reason, and the comparisons that held it back. */
export const whyNot = (run, agent, rule, t) => {
  const now = t + SLACK, state = run.get(agent, "rule", rule)?.at(now), stopped = run.get(agent, "stopped")?.t[0];
  const off = run.inactive[agent]?.[rule], guard = run.guard(agent, rule, now), found = run.get(agent, "guard", rule)?.at(now);
  if (off) return { because: off.replace(/\.+$/, ""), held: [] };
  if (state?.active) return { because: "it fired, and its action is active", held: [] };
  if (state?.waits) {
    const above = run.guard(agent, state.behind, now)?.priority > guard?.priority ? ", which has a higher priority" : "";
    const fired = state.firing ? `, fired last at t = ${fixed(state.firing[0], 2)} s,` : "";
    return { because: `it is latched${fired} and waits for ${last(state.behind || "another rule")}${above}`, held: [] };
  }
  if (stopped < t - SLACK) return { because: `the agent was stopped${ago(stopped, t)}`, held: [] };
  if (!guard || !found) return { because: "the values of its guard are not recorded", held: [] };
  const held = (found.held ?? []).map((index) => {
    const { name, text, unit } = guard.sides[index < 0 ? -1 - index : index], si = unit && ` ${unit}`;
    const [left, right, truth] = run.get(agent, "compare", name).at(now), gap = Math.abs(left - right);
    const limit = unit === "m" && guard.limits?.find(([value]) => Math.abs(left - value) < LIMIT)?.[1];
    const by = Number.isFinite(gap) ? ` by ${three(gap)}${si}` : "";
    const values = Number.isNaN(gap) ? "" : `${by} (${three(left)} against ${three(right)}${si}${limit ? `; ${limit}` : ""})`;
    const is = truth ? `must not hold, but holds${values}` : `does not hold${values}`;
    const because = `'${text}' ${Number.isNaN(truth) ? "is not decided, because a value is not known" : is}`;
    return { name, text, left, right, unit, because };
  });
  const because = held.map((each) => each.because).join(" and "), only = guard.only_invalid ? "; it fires only when its signals are invalid" : "";
  return { because: because ? because + only : back(guard, found, t), held };
};
