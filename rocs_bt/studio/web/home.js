// @ts-check
// First view of the studio: the runs of a project, newest first, and its content.
import { el, put } from "./dom.js";
import { get, start } from "./server.js";

const EVERY = 1500; // [ms] between two looks at the runs
const TITLES = { scenario: "Scenarios", mission: "Missions", rules: "Rules", robot: "Robots" };
const EMPTY = {
  scenario: "No scenario. Make one: rocs-bt new scenario NAME", mission: "No mission. Make one: rocs-bt new mission NAME",
  rules: "No rule file. Make one: rocs-bt new rules NAME", robot: "No robot. Make one: rocs-bt new robot NAME",
};

/** Time since a moment, as people say it. @param {number} t in seconds since 1970 */
const ago = (t) => {
  const gone = Date.now() / 1000 - t;
  if (gone < 60) return "just now";
  if (gone < 3600) return `${Math.floor(gone / 60)} min ago`;
  if (gone < 86400) return `${Math.floor(gone / 3600)} h ago`;
  return new Date(t * 1000).toLocaleDateString();
};

const MUTED = ["timeout", "interrupted", "running", "cut off"];

/** Outcome of a run as one badge: that of its robot, or how many of several succeeded. */
const badge = ({ state, outcomes = {} }) => {
  const all = Object.values(outcomes), good = all.filter((outcome) => outcome === "success").length, least = all.find((outcome) => outcome !== "success");
  const text = state !== "over" ? state : all.length === 1 ? all[0] : `${good} of ${all.length} success`;
  const tone = state === "over" && !least ? "good" : MUTED.includes(state === "over" ? least : state) ? "muted" : "bad";
  return el("span", { class: `badge ${tone}` }, text);
};

const runRow = (run) => el(
  "a", { class: "run", href: `run?run=${encodeURIComponent(run.name)}` },
  badge(run), el("b", {}, run.name),
  el("span", { class: "muted" }, run.duration === undefined ? run.reason ?? "" : `${run.duration.toFixed(1)} s`),
  el("time", { class: "muted" }, ago(run.t)),
);

class Runs {
  constructor() {
    this.find = el("input", { type: "search", placeholder: "search runs (/)", "aria-label": "search runs", oninput: () => this.show() });
    this.count = el("small", { class: "muted" });
    this.list = el("div", { class: "runs" });
    this.box = el("section", {}, el("h2", {}, "Runs ", this.count), el("div", { class: "tools" }, this.find), this.list);
    this.text = "";
    this.all = [];
  }

  async look() {
    if (document.hidden) return;
    const all = await get("runs"), text = JSON.stringify(all) + Math.floor(Date.now() / 60000);
    if (text === this.text) return;
    this.text = text;
    this.all = all;
    this.show();
  }

  show() {
    const word = this.find.value.toLowerCase(), found = this.all.filter((run) => JSON.stringify(run).toLowerCase().includes(word));
    const at = document.activeElement instanceof HTMLAnchorElement ? document.activeElement.getAttribute("href") : null;
    put(this.count, String(this.all.length));
    const none = word ? "No run has this name." : "No run yet. Press ▶ beside a scenario, or type: rocs-bt run exp1";
    this.list.replaceChildren(...(found.length ? found.map(runRow) : [el("p", { class: "empty" }, none)]));
    if (at) [...this.list.querySelectorAll("a")].find((link) => link.getAttribute("href") === at)?.focus();
  }
}

/** Asks for seed, mode and duration of a run, and starts it. */
const starter = (scenario, tell) => {
  const seed = el("input", { type: "number", min: 0, value: 1, "aria-label": "seed" });
  const mode = el("select", { "aria-label": "mode" }, el("option", {}, "lockstep"), el("option", {}, "threaded"));
  const limit = el("input", { type: "number", min: 0, step: "any", placeholder: "to its end", "aria-label": "duration in seconds" });
  const watch = el("input", { type: "checkbox" });
  const form = el(
    "form", { class: "starter", onsubmit: (event) => { event.preventDefault(); go(); } },
    el("label", {}, "seed", seed), el("label", {}, "mode", mode), el("label", {}, "seconds", limit),
    el("label", {}, watch, "reload rules that change"), el("button", { class: "main" }, "▶ run"),
  );
  const go = () => {
    const wanted = { scenario, seed: Number(seed.value), mode: mode.value, watch_rules: watch.checked };
    start(limit.value ? { ...wanted, duration: Number(limit.value) } : wanted).catch((error) => tell(error.message));
  };
  return form;
};

const entry = (kind, { name, doc, own, file }, tell) => {
  const link = el("a", { href: `edit?file=${encodeURIComponent(file)}`, title: file }, name);
  const row = el("li", { class: own ? "own" : "" }, el("b", {}, link), el("span", { class: "muted" }, doc));
  if (kind !== "scenario") return row;
  const more = el("button", { "aria-expanded": "false", title: "options of the run", onclick: () => open() }, "…");
  const open = () => {
    const form = row.querySelector("form");
    more.setAttribute("aria-expanded", String(!form));
    if (form) form.remove(); else row.append(starter(name, tell));
    row.querySelector("form input")?.focus();
  };
  const run = () => start({ scenario: name }).catch((error) => tell(error.message));
  row.prepend(el("button", { class: "play", title: `run ${name} with seed 1`, "aria-label": `run ${name}`, onclick: run }, "▶"));
  row.append(more);
  return row;
};

const section = (kind, entries, tell) => el(
  "section", { class: "kind" }, el("h2", {}, TITLES[kind], " ", el("small", { class: "muted" }, String(entries.length))),
  entries.length ? el("ul", {}, ...entries.map((each) => entry(kind, each, tell))) : el("p", { class: "empty" }, EMPTY[kind]),
);

const show = (project) => {
  const runs = new Runs(), notice = el("p", { class: "notice", role: "alert", hidden: true });
  const tell = (text) => { notice.hidden = !text; put(notice, text); };
  const note = project.own ? project.folder : `${project.folder} is no project: make one with rocs-bt new NAME. The content of rocs_bt is here.`;
  const kinds = Object.entries(project.content).map(([kind, entries]) => section(kind, entries, tell));
  document.title = `${project.name}: rocs_bt studio`;
  document.getElementById("home").replaceChildren(
    el("header", {}, el("h1", {}, project.name), el("span", { class: "muted" }, note)), notice,
    el("div", { class: "halves" }, runs.box, el("div", { class: "content" }, ...kinds)),
  );
  const look = () => runs.look().then(() => tell(""), () => tell("The studio has ended. Start it again: rocs-bt studio"));
  addEventListener("keydown", (event) => {
    if (event.key !== "/" || /^(INPUT|SELECT)$/.test(/** @type {HTMLElement} */ (event.target).tagName)) return;
    event.preventDefault();
    runs.find.focus();
  });
  look();
  setInterval(look, EVERY);
};

get("project").then(show).catch((error) => {
  document.getElementById("home").replaceChildren(el("p", { class: "empty" }, `This project cannot be shown: ${error.message}`));
});
