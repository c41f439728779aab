// @ts-check
// Lines of the log in which two things take turns.
import { short } from "./dom.js";

const LEAST = 6; // changes from one to the other from which on lines are folded

/** What a line of the log is about: a rule, an action or a node; empty for others. */
const subject = (run, [, , , text, about]) => {
  const [agent, topic] = about.split("|", 2), name = about.slice(agent.length + topic?.length + 2);
  if (topic === "ticket") return `action ${run.tracks.get(about)?.v[0].action ?? name} failed`;
  return ["rule", "node"].includes(topic) ? `${topic} ${short(name)}${text.includes(" fired again") ? " fired again" : ""}` : "";
};

/**
 * Parts of a list: two names that take turns at least six times are one part with both names and the number of
 * changes; what is between such parts is a part without changes.
 * @param {string[]} names of which empty ones belong to no turn
 * @returns {{from: number, to: number, names: string[], changes: number}[]} `to` is the first index after the part
 */
export const parts = (names) => {
  const found = [];
  let rest = 0, at = 0;
  const other = (to) => { if (rest < to) found.push({ from: rest, to, names: [], changes: 0 }); };
  while (at < names.length) {
    const pair = [names[at]];
    let end = at + 1, turn = at, changes = 0;
    for (; end < names.length && names[at] && names[end]; end++) {
      if (!pair.includes(names[end]) && pair.push(names[end]) > 2) break;
      if (names[end] !== names[end - 1]) { changes++; turn = end; }
    }
    if (changes >= LEAST) {
      other(at);
      found.push({ from: at, to: end, names: pair.slice(0, 2), changes });
      rest = at = end;
    } else at = turn > at ? turn : end;
  }
  other(names.length);
  return found;
};

/** Parts of lines of the log, of which those with changes are shown as one line. */
export const turns = (run, lines) => parts(lines.map((line) => subject(run, line)));
