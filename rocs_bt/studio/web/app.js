// @ts-check
// The page: its panels around one cursor.
import { Arena } from "./arena.js";
import { Control } from "./control.js";
import { Cursor } from "./cursor.js";
import { button, dark, el, put, short } from "./dom.js";
import { Fleet } from "./fleet.js";
import { Inspector } from "./inspector.js";
import { About, Knowledge, Log, Signals } from "./panels.js";
import { Run } from "./run.js";
import { both, listed } from "./second.js";
import { runName } from "./server.js";
import { Layers } from "./scene.js";
import { Space } from "./space.js";
import { Timeline } from "./timeline.js";
import { chosen, csv, help, report } from "./tools.js";
import { Transport } from "./transport.js";
import { MissionTree } from "./tree.js";

const SMALL = 8; // nodes up to which the tree gets less room
const MANY = 8; // robots above which the page opens with their table

/** Outcome of a run of one robot, or of how many of several robots succeeded; a click goes there. */
const verdict = (run, cursor) => {
  const outcomes = run.agents.map((agent) => run.outcome(agent)?.outcome), good = outcomes.filter((o) => o === "success").length;
  const worst = ["bad", "muted", "good"].find((tone) => outcomes.some((o) => run.tone(o) === tone)) ?? "muted";
  const first = run.agents.find((agent) => run.tone(run.outcome(agent)?.outcome) === worst);
  const go = () => cursor.select(`${first}|outcome|`, run.outcome(first)?.t);
  const text = run.going && !outcomes.some(Boolean) ? "running" : run.agents.length === 1 ? outcomes[0] ?? "unknown" : `${good} of ${outcomes.length} success`;
  return el("button", { class: `badge ${worst}`, onclick: go }, text);
};

/** Button between the arena from above and in space; robots that fly or walk begin in space. */
const staged = (run, arena, space) => {
  const button = el("button", { class: "flip", title: "from above or in space (3)", onclick: () => act() });
  const show = (flat) => {
    arena.canvas.hidden = !flat;
    space.canvas.hidden = space.names.hidden = flat;
    put(button, flat ? "3D" : "2D");
    if (!flat && !space.made) { // no WebGL
      show(true);
      button.disabled = true;
      button.title = space.broken;
    } else if (flat) arena.fit(); else space.update();
  };
  const act = () => show(arena.canvas.hidden);
  const climbs = run.header.bodies.some(({ name }) => run.get(name, "pose")?.width > 3);
  setTimeout(() => show(!climbs));
  return { button, act };
};

/** Tabs of panels: one is visible. */
const tabbed = (panels, cursor, kind) => {
  const bar = el("nav", { class: "tabs", role: "tablist" }), buttons = {};
  const choose = (name) => {
    for (const [key, { box }] of Object.entries(panels)) {
      box.hidden = key !== name;
      buttons[key].setAttribute("aria-selected", String(key === name));
    }
    cursor.say("shown");
  };
  for (const name of Object.keys(panels)) buttons[name] = bar.appendChild(el("button", { role: "tab", onclick: () => choose(name) }, name));
  bar.hidden = Object.keys(panels).length < 2;
  return { box: el("section", { class: kind }, bar, ...Object.values(panels).map(({ box }) => box)), choose };
};

/** What the recording lacks, and what the address names and the run does not have. */
const missing = (run, cursor) => {
  const box = el("span", { class: "cut" });
  const show = () => put(box, [run.missing, cursor.lost.size && `Not in this run: ${[...cursor.lost].join(", ")}.`].filter(Boolean).join(" "));
  cursor.addEventListener("lost", show);
  show();
  return box;
};

/** List of what pauses the page, each with a button that removes it. */
const stops = (cursor) => {
  const box = el("span", { class: "stops" });
  const one = (address) => {
    const text = `pauses at ${short(address.slice(address.lastIndexOf("|") + 1))} ×`;
    return button(text, "do not pause there any more (b)", () => cursor.stop(address));
  };
  const show = () => box.replaceChildren(...[...cursor.stops].map(one));
  cursor.addEventListener("stops", show);
  return box;
};

/** Shows a run; returns what takes its changes if it goes on. */
const open = (run) => {
  const cursor = new Cursor(run), app = document.getElementById("app"), { scenario, bodies = [] } = run.header;
  const layers = new Layers(), arena = new Arena(run, cursor, layers), tree = new MissionTree(run, cursor), timeline = new Timeline(run, cursor);
  const transport = new Transport(run, cursor), inspector = new Inspector(run, cursor);
  const panels = {
    log: new Log(run, cursor), knowledge: new Knowledge(run, cursor), signals: new Signals(run, cursor, timeline), about: new About(run, cursor),
    ...(run.other && { differences: listed(run, cursor) }),
  };
  const tabs = tabbed(panels, cursor, "side"), fleet = run.agents.length > 1 ? { robots: new Fleet(run, cursor) } : {};
  const mission = tabbed({ tree, ...fleet }, cursor, "mission");
  const picker = el(
    "select", { "aria-label": "robot", onchange: () => cursor.show(picker.value) },
    ...run.agents.map((a) => el("option", { value: a }, `${a}: ${run.outcome(a)?.outcome ?? "unknown"}`)),
  );
  cursor.addEventListener("agent", () => { picker.value = cursor.agent; });
  const commands = [run.header.command, run.other && `${run.other.header.command} (′)`].filter(Boolean).join("\n");
  const what = el("span", { class: "muted time", title: commands }, duration(run));
  const cut = missing(run, cursor), control = new Control(run, cursor);
  const space = new Space(run, cursor, arena.area, layers), flip = staged(run, arena, space);
  const table = keys(run, cursor, { tabs, panels, flip: flip.act, layers, timeline, tree, mission, inspector, control });
  const header = el(
    "header", {}, el("h1", {}, scenario), what, verdict(run, cursor), cut, run.agents.length > 1 ? picker : null,
    control.box, transport.box, stops(cursor), menu(run, table),
  );
  const stage = el("section", { class: "stage" }, arena.canvas, space.canvas, space.names, layers.box, flip.button);
  app.replaceChildren(
    header, stage, mission.box, el("section", { class: "inspect" }, inspector.box),
    el("section", { class: "time" }, timeline.box), tabs.box,
  );
  app.classList.toggle("small", tree.rows.length < SMALL && run.agents.length <= MANY);
  const treeless = !tree.rows.length && run.agents.length < 2;
  app.classList.toggle("flat", !bodies.length);
  app.classList.toggle("bare", !bodies.length && treeless);
  app.classList.toggle("still", !bodies.length && run.end <= run.start);
  timeline.onwindow = (from, to) => transport.frame(from, to);
  timeline.onwindow(timeline.from, timeline.to);
  timeline.onlegend = () => table.find(({ key }) => key === "?").act(false);
  const fit = () => { arena.fit(); timeline.fit(); transport.build(); tree.update(); };
  const watch = [new ResizeObserver(fit), new ResizeObserver(() => { arena.fit(); space.update(); })];
  watch[0].observe(app);
  watch[1].observe(stage);
  dark.addEventListener("change", () => setTimeout(fit));
  tabs.choose(run.other ? "differences" : bodies.length || !treeless ? "log" : "knowledge");
  if (!bodies.length && treeless) panels.knowledge.show(true);
  mission.choose(run.agents.length > MANY ? "robots" : "tree");
  cursor.keep("layers", () => layers.turned, (names) => { layers.turned = names; });
  fit();
  picker.value = cursor.agent;
  cursor.say("select");
  cursor.move(cursor.t);
  if (run.going) return live(run, cursor, { transport, header, control });
  return () => {};
};

/** Button at the head of a run that goes on; returns what takes its changes. */
const live = (run, cursor, { transport, header, control }) => {
  const head = el("button", { class: "head", title: "stay at the newest time", onclick: () => cursor.follow() }, "live");
  const show = () => {
    head.classList.toggle("on", cursor.follows);
    put(head, run.going ? "live" : "ended");
  };
  transport.box.append(head);
  cursor.addEventListener("follow", show);
  show();
  return (fresh) => {
    cursor.say("grow", fresh);
    if (cursor.follows) cursor.lead();
    put(header.querySelector(".time"), duration(run));
    header.querySelector(".badge").replaceWith(verdict(run, cursor));
    cursor.say("lost");
    control.update();
    show();
  };
};

const duration = ({ header, other, end, start }) => {
  const beside = other ? ` and ${other.header.scenario}′ seed ${other.header.seed}` : "";
  const names = otherName ? `${runName} and ${otherName}′` : `seed ${header.seed}${beside}`;
  return header.bodies?.length ? `${names}, ${(end - start).toFixed(1)} s` : "";
};

/** Buttons of what has a key and no other place. */
const menu = (run, table) => {
  const box = el("details", { class: "menu" }, el("summary", { title: "more" }, "⋯"));
  const one = ({ key, item, act }) => (
    el("button", { onclick: () => { box.open = false; act(false); } }, el("span", {}, item), el("kbd", {}, key))
  );
  const items = table.filter(({ item }) => item).map(one);
  box.append(el("div", {}, ...items));
  box.addEventListener("focusout", (event) => { if (!box.contains(event.relatedTarget)) box.open = false; });
  return box;
};

/** Keys with their texts for the help; those with `item` are in the menu too. */
const keys = (run, cursor, { tabs, panels, flip, layers, timeline, tree, mission, inspector, control }) => {
  const period = 1 / (run.header.rates?.control ?? 20), find = (tab, { find: input }) => { tabs.choose(tab); input.focus(); };
  const by = (sign) => (wide) => cursor.move(cursor.t + sign * (wide ? 1 : period));
  const moment = () => cursor.select(run.moment.address, run.moment.t), pause = () => { if (cursor.selected) cursor.stop(cursor.selected); };
  const second = (text) => both(here(), Run.from(text)).then((joined) => { history.replaceState(null, "", " "); open(joined); }, fail);
  const compare = () => (runName ? location.assign(`./#with=${encodeURIComponent(runName)}`) : chosen(second));
  const next = () => cursor.show(run.agents[(run.agents.indexOf(cursor.agent) + 1) % run.agents.length]);
  const said = () => inspector.box.innerText.replaceAll(/\n+/g, "\n  ");
  /** @type {{key: string, keys: string[], text: string, act: (shift: boolean) => void, item?: string}[]} */
  const table = [
    { key: "space", keys: [" "], text: "play or pause", act: () => cursor.play() },
    { key: "→", keys: ["ArrowRight"], text: "one control period on; with shift one second", act: by(1) },
    { key: "←", keys: ["ArrowLeft"], text: "one control period back; with shift one second", act: by(-1) },
    { key: ".", keys: ["."], text: "next event", act: () => cursor.step(1) },
    { key: ",", keys: [","], text: "previous event", act: () => cursor.step(-1) },
    { key: "home, end", keys: ["Home"], text: "start and end", act: () => cursor.move(run.start) },
    { key: "", keys: ["End"], text: "", act: () => cursor.move(run.end) },
    { key: "f", keys: ["f"], text: "decisive moment: the failure, else the first reflex", act: moment },
    { key: "b", keys: ["b"], text: "pause when the selected node fails or the selected rule fires", item: "pause at the selected thing", act: pause },
    { key: "+, −", keys: ["+", "="], text: "zoom the time axis; with ctrl and the wheel too, shift and drag moves it", act: () => timeline.zoom(0.5) },
    { key: "", keys: ["-"], text: "", act: () => timeline.zoom(2) },
    { key: "w", keys: ["w"], text: "30 seconds around the cursor", act: () => timeline.recent() },
    { key: "0", keys: ["0"], text: "the whole run", act: () => timeline.window(run.start, run.end) },
    { key: "/", keys: ["/"], text: "search signals", act: () => find("signals", panels.signals) },
    { key: "n", keys: ["n"], text: "search nodes of the tree", act: () => { mission.choose("tree"); tree.tools.hidden = false; tree.find.focus(); } },
    { key: "l", keys: ["l"], text: "search the log", act: () => find("log", panels.log) },
    { key: "k", keys: ["k"], text: "search the knowledge", act: () => find("knowledge", panels.knowledge) },
    { key: "r", keys: ["r"], text: "next robot", act: next },
    { key: "3", keys: ["3"], text: "from above or in space", act: flip },
    { key: "c", keys: ["c"], text: "the camera follows the robot", act: () => layers.toggle("follow") },
    { key: "esc", keys: ["Escape"], text: "select the robot", act: () => cursor.select("") },
    { key: "o", keys: ["o"], text: "open a second run over this one", item: `compare with ${runName ? "another run" : "a second report"} …`, act: compare },
    { key: "d", keys: ["d"], text: "first differences of two runs", act: () => { if (run.other) tabs.choose("differences"); } },
    { key: "s", keys: ["s"], text: "save the shown signals as CSV", item: "save shown signals as CSV", act: () => csv(run, timeline) },
    { key: "i", keys: ["i"], text: "copy as a report of a fault", item: "copy as a report of a fault", act: () => report(run, cursor, said()) },
    ...control.keys(),
    { key: "?", keys: ["?"], text: "this list", item: "keys", act: () => help(table.filter(({ text }) => text)) },
  ];
  onkeydown = (event) => {
    const { tagName, type } = /** @type {HTMLInputElement} */ (event.target), ticks = type === "checkbox";
    const found = table.find((each) => each.keys.includes(event.key)), types = !ticks && /^(INPUT|SELECT|TEXTAREA)$/.test(tagName);
    if (event.key === "Escape" && /^(INPUT|SELECT)$/.test(tagName)) /** @type {HTMLElement} */ (event.target).blur();
    if (!found || event.ctrlKey || event.metaKey || event.altKey || types || document.querySelector("dialog[open]")) return;
    if (event.key === " " && (ticks || /^(BUTTON|SUMMARY)$/.test(tagName))) return; // presses the button
    event.preventDefault();
    found.act(event.shiftKey);
  };
  return table;
};

addEventListener("keyup", ({ key, target }) => { // what is a button by its role is pressed by enter
  if (key === "Enter" && target instanceof HTMLElement && target.getAttribute("role") === "button") target.click();
});

const fail = (error) => {
  document.getElementById("app").replaceChildren(el("p", { class: "empty" }, `This page cannot show its run: ${error.message}`));
  throw error;
};

const data = document.getElementById("data"), second = document.getElementById("second");
const otherName = new URLSearchParams(location.search).get("second");
/** The run of this page as it is now. */
const here = () => (data ? Run.from(data.textContent) : Run.open(runName));
if (second || otherName) both(here(), second ? Run.from(second.textContent) : Run.open(otherName)).then(open).catch(fail);
else if (data) here().then(open).catch(fail);
else {
  let take = (_) => {};
  Run.open(runName, (fresh) => take(fresh)).then((run) => { take = open(run); }).catch(fail);
}
