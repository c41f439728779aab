// @ts-check
// Two runs in one page: the robots of the second have a prime, and the first differences are marked.
import { el, seconds, shown, upto } from "./dom.js";
import { Track } from "./run.js";

const MARK = "′";
const KINDS = { decisions: ["node", "rule", "ticket", "outcome"], knowledge: ["fact", "board"], commands: ["command"], motion: ["pose"] };
const CLOSE = 0.01; // [m, rad, SI] from which numbers differ; recorded ones are rounded

export const isSecond = (agent) => agent.endsWith(MARK);

/** Adds the tracks, robots and log of a second run to a run. */
const join = (run, other) => {
  const mark = (name) => (name ? name + MARK : name), renamed = (list = []) => list.map((each) => ({ ...each, name: mark(each.name) }));
  const failed = (each) => each.agents.some((agent) => (each.outcome(agent)?.outcome ?? "success") !== "success");
  const moments = other.decisive.map((each) => ({ ...each, address: each.address.replace("|", `${MARK}|`) }));
  run.decisive = failed(other) && !failed(run) ? [...moments, ...run.decisive] : [...run.decisive, ...moments];
  for (const { agent, topic, name, t, v, width, ray } of other.tracks.values()) run.add(new Track(`${mark(agent)}|${topic}|${name}`, t, v, width, ray));
  const { agents, bodies } = run.header, { header } = other;
  run.header = { ...run.header, agents: [...agents, ...renamed(header.agents)], bodies: [...bodies, ...renamed(header.bodies)] };
  run.agents.push(...other.agents.map(mark));
  for (const key of ["guards", "results", "inactive"]) for (const [agent, value] of Object.entries(other[key])) run[key][mark(agent)] = value;
  const lines = other.log.map(([t, agent, level, text, about]) => [t, mark(agent), level, text, about.replace("|", `${MARK}|`)]);
  run.log = [...run.log, ...lines].sort((a, b) => a[0] - b[0]);
  run.end = Math.max(run.end, other.end);
  run.other = other;
  run.missing = [run.missing, other.missing && `${other.header.scenario}${MARK}: ${other.missing}`].filter(Boolean).join(" ");
  run.differences = differences(run);
};

/** Track of the second run for one of the first. */
export const twin = (run, address) => (run.other ? run.tracks.get(address.replace("|", `${MARK}|`)) : undefined);

/** First difference of each kind, earliest first; a track that only one run has differs from its beginning. */
const differences = (run) => {
  const found = [], alone = ({ agent, address }) => !isSecond(agent) || !run.tracks.has(address.replace(`${MARK}|`, "|"));
  for (const [kind, topics] of Object.entries(KINDS)) {
    let first = null;
    for (const track of run.tracks.values()) {
      if (!topics.includes(track.topic) || !alone(track)) continue;
      const t = differs(track, twin(run, track.address), first?.t ?? Infinity);
      if (t !== undefined) first = { kind, t, track };
    }
    if (first) found.push(first);
  }
  return found.sort((a, b) => a.t - b.t);
};

/** First time before `limit` at which two tracks differ; undefined if they do not. */
const differs = (a, b, limit) => {
  if (!b) return a.t[0] < limit ? a.t[0] : undefined;
  const times = [...a.t, ...b.t].filter((t) => t < limit).sort((x, y) => x - y);
  return times.find((t) => !alike(a.row(upto(a.t, t) - 1), b.row(upto(b.t, t) - 1), a.width));
};

const alike = (a, b, width) => {
  if (!width) return JSON.stringify(a ?? null) === JSON.stringify(b ?? null);
  for (let k = 0; k < width; k++) if (!(Math.abs(a[k] - b[k]) < CLOSE) && !(Object.is(a[k], b[k]))) return false;
  return true;
};

const worded = (value) => {
  if (value?.state) return `${value.action} ${value.state}`;
  return shown(value?.outcome ?? (value?.phase === undefined ? value : value.active ? "active" : value.latched ? "latched" : "clear"));
};

const named = ({ topic, name }) => (topic === "ticket" ? `action #${name}` : (name || topic).replaceAll("\n", " "));

/** Panel of the first differences; each is a link to its moment. */
export const listed = (run, cursor) => ({ box: el(
  "div", { class: "panel", role: "tabpanel" }, el("ol", { class: "log differences" },
    ...run.differences.map(({ kind, t, track }) => el("li", {}, el(
      "a", { href: cursor.address(t, track.address, track.agent), onclick: (event) => { event.preventDefault(); cursor.select(track.address, t); } },
      el("time", {}, seconds(t)),
      el(
        "span", {}, el("b", {}, kind), ` ${track.agent} ${named(track)}: `,
        (isSecond(track.agent) ? [undefined, track] : [track, twin(run, track.address)]).map((each) => worded(each?.at(t))).join(" / "),
      ),
    ))),
    run.differences.length ? null : el("li", { class: "empty" }, "No decision, knowledge, command or pose differs."),
  ),
) });

/** Two runs as one; without the second one, if that cannot be read. @param {Promise<any>} first @param {Promise<any>} second */
export const both = async (first, second) => {
  const missing = (error) => (run) => { run.missing = [run.missing, `The second run cannot be shown: ${error.message}`].filter(Boolean).join(" "); };
  const add = second.then((other) => (run) => join(run, other), missing), run = await first;
  (await add)(run);
  return run;
};
