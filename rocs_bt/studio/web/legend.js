// @ts-check
// Colours and marks with their one meaning. Every colour of the style sheet is listed here or is neutral.
import { el } from "./dom.js";

/** Meaning of each colour; `short` is its name in the line below the time axis. */
export const MEANINGS = [
  { tint: "deliberative", short: "mission", text: "the mission: nodes that run, its actions, the way that it drove, its planned path" },
  { tint: "reactive", short: "reflex", text: "a reflex: a rule whose action is active, actions of rules, the way that they drove" },
  { tint: "latched", short: "guard holds", text: "a rule whose guard holds, or that is latched or waits" },
  { tint: "margin", short: "how near", text: "how near a rule is to firing: the higher, the nearer" },
  { tint: "hold", short: "", text: "a comparison holds in this time" },
  { tint: "idle", short: "", text: "nothing moves the robot" },
  { tint: "belief", short: "", text: "what the robot senses and believes: rays, echoes, its own map, objects" },
  { tint: "actor", short: "scripted", text: "what a script moves: doors, people, robots without an agent" },
  { tint: "good", short: "success", text: "success, and goals" },
  { tint: "bad", short: "failure", text: "failure, and nothing else" },
  { tint: "twin", short: "second run", text: "the second run" },
  { tint: "fresh", short: "", text: "changed just now" },
  { tint: "select", short: "", text: "selected" },
];

const MARKS = [
  ["◆", "event on the time axis, and on the bar of the whole run"],
  ["▶ ✓ ✗ ·", "node that runs, succeeded, failed, was not ticked"], ["┄", "limit that a value is compared with"],
  ["▔", "the curve is beyond the scale, which shows the region of the limit"], ["◇", "where the robot believes an object to be"],
];

export const swatch = (tint) => {
  const box = el("i", { class: "swatch" });
  box.style.background = `var(--${tint})`;
  return box;
};

/** Line of the colours that the rows of the timeline use. */
export const legend = (tints, act) => el(
  "button", { class: "legend", title: "all colours and marks (?)", onclick: act },
  ...MEANINGS.filter(({ tint, short }) => short && tints.has(tint)).map(({ tint, short, text }) => el("span", { title: text }, swatch(tint), short)),
);

/** All colours and marks, for the help. */
export const colours = () => [
  el("h3", {}, "Colours"), el("ul", { class: "meanings" }, ...MEANINGS.map(({ tint, text }) => el("li", {}, swatch(tint), text))),
  el("h3", {}, "Marks"), el("ul", { class: "meanings" }, ...MARKS.map(([mark, text]) => el("li", {}, el("b", {}, mark), text))),
];

/** Colour of a line of the log; empty for a line that is no event on the axis. */
export const tintOf = ([, , level, , about]) => {
  const topic = about.split("|", 2)[1];
  return level > 3 ? "bad" : topic === "actor" ? "actor" : level < 3 ? "" : topic === "rule" ? "reactive" : "ink";
};
