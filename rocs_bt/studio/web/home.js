// @ts-check
// First view of the studio: the runs of a project, episodes of its comparisons, and its content.
import { el, put, search } from "./dom.js";
import { copy, edit, get, post, start } from "./server.js";

const EVERY = 1500; // [ms] between two looks at the runs
const MOST = 200; // scenes of comparisons that are listed
const TITLES = { scenario: "scenarios", mission: "missions", rules: "rules", robot: "robots" };
const MUTED = ["timeout", "interrupted", "running", "cut off", "limit"];
const ORDERS = {
  newest: (a, b) => b.t - a.t, name: (a, b) => a.name.localeCompare(b.name, "en", { numeric: true }),
  outcome: (a, b) => outcome(a).text.localeCompare(outcome(b).text), longest: (a, b) => (b.duration ?? 0) - (a.duration ?? 0),
};

/** Time since a moment, as people say it. @param {number} t in seconds since 1970 */
const ago = (t) => {
  const gone = Date.now() / 1000 - t;
  if (gone < 60) return "just now";
  if (gone < 3600) return `${Math.floor(gone / 60)} min ago`;
  if (gone < 86400) return `${Math.floor(gone / 3600)} h ago`;
  return new Date(t * 1000).toLocaleDateString();
};

const tone = (word) => (word === "success" ? "good" : MUTED.includes(word) ? "muted" : "bad");

/** Outcome of a run in a word or two: that of its robot, or how many of several succeeded. */
const outcome = ({ state, outcomes = {} }) => {
  const all = Object.values(outcomes), good = all.filter((each) => each === "success").length, least = all.find((each) => each !== "success");
  if (state !== "over") return { text: state, tone: tone(state) };
  return { text: all.length === 1 ? all[0] : `${good} of ${all.length} success`, tone: tone(least ?? "success") };
};

const pageOf = (run, second) => `run?${new URLSearchParams({ run, ...(second && { second }) })}`;

const matches = (thing, { value }) => JSON.stringify(thing).toLowerCase().includes(value.toLowerCase());

class Runs {
  constructor() {
    const show = () => this.show();
    this.find = search("search runs (/)", show);
    this.order = el("select", { "aria-label": "order of the runs", onchange: show }, ...Object.keys(ORDERS).map((name) => el("option", {}, name)));
    this.count = el("small", { class: "muted" });
    this.list = el("div", { class: "runs" });
    this.bar = el("p", { class: "notice", role: "status", hidden: true });
    this.box = el("section", {}, el("h2", {}, "Runs ", this.count), el("div", { class: "tools" }, this.find, this.order), this.bar, this.list);
    this.text = "";
    this.all = [];
    this.picked = new URLSearchParams(location.hash.slice(1)).getAll("with"); // the newest two that were selected
  }

  async look() {
    if (document.hidden) return;
    const all = await get("runs"), text = JSON.stringify(all) + Math.floor(Date.now() / 60000);
    if (text === this.text) return;
    this.text = text;
    this.all = all;
    this.show();
  }

  pick(name, on) {
    this.picked = [...this.picked.filter((each) => each !== name), ...(on ? [name] : [])].slice(-2);
    this.show();
  }

  row(run) {
    const { text, tone: hue } = outcome(run), about = { "aria-label": `select ${run.name}`, title: "select two runs to compare them" };
    const box = el("input", { type: "checkbox", ...about, onchange: () => this.pick(run.name, box.checked) });
    box.checked = this.picked.includes(run.name);
    return el("div", { class: "run" }, box, el(
      "a", { href: pageOf(run.name) }, el("span", { class: `badge ${hue}` }, text), el("b", {}, run.name),
      el("span", { class: "muted" }, run.duration === undefined ? "" : `${run.duration.toFixed(1)} s`), el("time", { class: "muted" }, ago(run.t)),
      run.reason ? el("span", { class: "reason muted", title: run.reason }, run.reason) : null,
    ));
  }

  show() {
    const found = this.all.filter((run) => matches(run, this.find)).sort(ORDERS[this.order.value]), [one, two] = this.picked;
    const label = document.activeElement?.getAttribute("aria-label"), at = document.activeElement?.getAttribute("href");
    put(this.count, String(this.all.length));
    const none = this.find.value ? "No run has this name." : "No run yet. Press ▶ beside a scenario, or type: rocs-bt run exp1";
    this.list.replaceChildren(...(found.length ? found.map((run) => this.row(run)) : [el("p", { class: "empty" }, none)]));
    [...this.list.querySelectorAll("a, input")].find((e) => (at ? e.getAttribute("href") === at : label && e.getAttribute("aria-label") === label))?.focus();
    this.bar.hidden = !one;
    this.bar.replaceChildren(
      two ? el("a", { class: "main", href: pageOf(one, two) }, `compare ${one} and ${two}`) : `Select the run to compare with ${one}.`,
      el("button", { onclick: () => { this.picked = []; this.show(); } }, "cancel"),
    );
  }
}

/** Episodes of comparisons, by scene and seed; what is not recorded is played first. */
class Episodes {
  constructor(tell) {
    this.tell = tell;
    this.find = search("search scenes and planners", () => this.show());
    this.list = el("div", { class: "scenes" });
    this.box = el("section", { hidden: true }, el("h2", {}, "Episodes of comparisons"), el("div", { class: "tools" }, this.find), this.list);
    get("episodes").then((all) => { this.all = all; this.box.hidden = !all.length; this.show(); }, (error) => tell(error.message));
  }

  show() {
    const found = this.all.filter((each) => matches(each, this.find)), same = (a, b) => a.scene === b.scene && a.seed === b.seed;
    const scenes = found.filter((each, i) => !i || !same(each, found[i - 1])).map((first) => found.filter((each) => same(each, first)));
    this.list.replaceChildren(...scenes.slice(0, MOST).map((each) => this.scene(each)));
    if (scenes.length > MOST) this.list.append(el("p", { class: "empty" }, `${scenes.length - MOST} more: search them.`));
  }

  scene(all) {
    const [{ scene, seed }] = all, best = all.find((each) => each.outcome === "success") ?? all[0];
    const other = all.find((each) => each.outcome !== best.outcome) ?? all.find((each) => each !== best);
    const title = ({ run, reason }) => [reason, run ? "open its recording" : "play it again with a recording, and open that"].filter(Boolean).join(": ");
    const one = (each) => el(
      "button", { title: title(each), onclick: () => this.open(each) },
      `${each.run ? "" : "▶ "}${each.planner} `, el("span", { class: tone(each.outcome) }, each.outcome), ` ${each.t.toFixed(1)} s`,
    );
    return el(
      "div", { class: "scene" }, el("b", {}, `${scene}, seed ${seed}`),
      other ? el("button", { title: `${best.planner} and ${other.planner} over each other`, onclick: () => this.open(best, other) }, "both") : null,
      ...all.map(one),
    );
  }

  open(...some) {
    const named = ({ run, planner, scene, seed }) => (run ? Promise.resolve(run) : post("play", { planner, scene, seed }).then((answer) => answer.run));
    Promise.all(some.map(named)).then(([one, two]) => location.assign(pageOf(one, two)), (error) => this.tell(error.message));
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


const entry = (kind, { name, doc, own, file }, project, tell) => {
  const link = el("a", { href: edit(file), title: file }, name), about = { title: `copy ${name} into this project, to change it` };
  const row = el("li", { class: own ? "own" : "" }, el("b", {}, link), el("span", { class: "muted", title: doc }, doc));
  const copied = () => el("button", { ...about, "aria-label": `copy ${name}`, onclick: () => copy(kind, name, tell) }, "copy");
  if (!own && project.writable) row.append(copied());
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

/** The content, a kind at a time. */
const content = (project, tell) => {
  const find = search("search the content", () => show()), list = el("ul"), given = el("details"), tabs = el("nav", { class: "tabs", role: "tablist" });
  let kind = "scenario";
  const show = () => {
    const found = project.content[kind].filter((each) => matches(each, find));
    for (const tab of tabs.children) tab.setAttribute("aria-selected", String(tab.dataset.kind === kind));
    const none = find.value ? "Nothing has this name." : `Nothing of this kind. Make one: rocs-bt new NAME --kind ${kind}`;
    const rows = (own) => found.filter((each) => each.own === own).map((each) => entry(kind, each, project, tell)), shipped = rows(false);
    list.replaceChildren(...(found.length ? rows(true) : [el("li", { class: "empty" }, none)]));
    given.hidden = !shipped.length;
    given.open = !project.own || Boolean(find.value); // a person's own content is not lost among that of rocs_bt
    given.replaceChildren(el("summary", {}, `${shipped.length} of rocs_bt`), el("ul", {}, ...shipped));
  };
  for (const [name, title] of Object.entries(TITLES)) {
    const choose = () => { kind = name; show(); };
    const count = project.content[name].filter(({ own }) => own || !project.own).length;
    tabs.append(el("button", { role: "tab", "data-kind": name, onclick: choose }, `${title} ${count}`));
  }
  show();
  return el("section", { class: "kind" }, tabs, el("div", { class: "tools" }, find), list, given);
};

/** What to do first in a folder without content. */
const beginning = (project, tell) => {
  const act = (text, about, go) => el("div", {}, el("button", { class: "main", onclick: go }, text), el("p", { class: "muted" }, about));
  const exp1 = () => start({ scenario: "exp1" }).catch((error) => tell(error.message));
  const watch = act("▶ watch exp1", "A robot drives around a box. The page explains what it does and why.", exp1);
  return el(
    "section", { class: "first" }, el("h2", {}, "Begin here"), watch,
    ...(project.writable ? [
      act("change exp1", "Copies the scenario into this folder and opens it: other robot, start, goal or world.", () => copy("scenario", "exp1", tell)),
      act("change a reflex", "Copies the rules avoid_collision. Their tests run as you type.", () => copy("rules", "avoid_collision", tell)),
    ] : []),
  );
};

const show = (project) => {
  const notice = el("p", { class: "notice", role: "alert", hidden: true }), tell = (text) => { notice.hidden = !text; put(notice, text); };
  const runs = new Runs(), episodes = new Episodes(tell);
  document.title = `${project.name}: rocs_bt studio`;
  document.getElementById("home").replaceChildren(
    el("header", {}, el("h1", {}, project.name), el("span", { class: "muted" }, project.folder)), notice, ...(project.own ? [] : [beginning(project, tell)]),
    el("div", { class: "halves" }, el("div", {}, runs.box, episodes.box), content(project, tell)),
  );
  let gone = false;
  const back = () => { if (gone) tell(""); gone = false; };
  const ended = "The studio has ended. Start it again: rocs-bt studio";
  const lost = (error) => { gone = true; tell(error instanceof TypeError ? ended : error.message); }; // a TypeError is that of the network
  const look = () => runs.look().then(back, lost);
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
