// The page: its panels around one cursor.
import { Arena } from "./arena.js";
import { Cursor } from "./cursor.js";
import { dark, el, put } from "./dom.js";
import { Inspector } from "./inspector.js";
import { About, Knowledge, Log, Signals } from "./panels.js";
import { Run } from "./run.js";
import { Space } from "./space.js";
import { Timeline } from "./timeline.js";
import { Transport } from "./transport.js";
import { MissionTree } from "./tree.js";

const SMALL = 8; // nodes up to which the tree gets less room

/** Outcome of a run of one robot, or of how many of several robots succeeded; a click goes there. */
const verdict = (run, cursor) => {
  const outcomes = run.agents.map((agent) => run.outcome(agent)?.outcome ?? "unknown"), good = outcomes.filter((o) => o === "success").length;
  if (run.agents.length === 1) {
    const go = () => cursor.select(`${run.agents[0]}|outcome|`, run.outcome(run.agents[0])?.t);
    return el("button", { class: `badge ${outcomes[0]}`, onclick: go }, outcomes[0]);
  }
  const tone = good === outcomes.length ? "success" : outcomes.every((o) => o === "unknown") ? "unknown" : "failed";
  return el("span", { class: `badge ${tone}` }, `${good} of ${outcomes.length} success`);
};

/** Button between the arena from above and in space; robots that fly or walk begin in space. */
const staged = (run, arena, space) => {
  const button = el("button", { class: "flip", title: "from above or in space (3)", onclick: () => act() });
  const show = (flat) => {
    arena.canvas.hidden = !flat;
    space.canvas.hidden = flat;
    put(button, flat ? "3D" : "2D");
    if (!flat && !space.made) { // no WebGL
      show(true);
      button.disabled = true;
      button.title = space.broken;
    } else if (flat) arena.fit(); else space.draw();
  };
  const act = () => show(arena.canvas.hidden);
  const climbs = run.header.bodies.some(({ name }) => run.get(name, "pose")?.width > 3);
  setTimeout(() => show(!climbs));
  return { button, act };
};

/** Tabs of panels: one is visible. */
const tabbed = (panels, cursor) => {
  const bar = el("nav", { class: "tabs", role: "tablist" }), buttons = {};
  const choose = (name) => {
    for (const [key, { box }] of Object.entries(panels)) {
      box.hidden = key !== name;
      buttons[key].setAttribute("aria-selected", String(key === name));
    }
    cursor.say("shown");
  };
  for (const name of Object.keys(panels)) buttons[name] = bar.appendChild(el("button", { role: "tab", onclick: () => choose(name) }, name));
  return { box: el("section", { class: "side" }, bar, ...Object.values(panels).map(({ box }) => box)), choose };
};

const open = (run) => {
  const cursor = new Cursor(run), app = document.getElementById("app");
  const arena = new Arena(run, cursor), tree = new MissionTree(run, cursor), timeline = new Timeline(run, cursor);
  const transport = new Transport(run, cursor), inspector = new Inspector(run, cursor);
  const panels = { log: new Log(run, cursor), knowledge: new Knowledge(run, cursor), signals: new Signals(run, cursor, timeline), about: new About(run, cursor) };
  const tabs = tabbed(panels, cursor), { scenario } = run.header;
  const picker = el(
    "select", { "aria-label": "robot", onchange: () => cursor.show(picker.value) },
    ...run.agents.map((a) => el("option", { value: a }, `${a}: ${run.outcome(a)?.outcome ?? "unknown"}`)),
  );
  cursor.addEventListener("agent", () => { picker.value = cursor.agent; });
  const what = el("span", { class: "muted time" }, duration(run));
  const cut = run.complete === false ? el("span", { class: "cut" }, "The run was killed: its recording ends here.") : null;
  const header = el("header", {}, el("h1", {}, scenario), what, verdict(run, cursor), cut, run.agents.length > 1 ? picker : null, transport.box);
  const space = new Space(run, cursor, arena.box), flip = staged(run, arena, space);
  const stage = el("section", { class: "stage" }, arena.canvas, space.canvas, flip.button);
  app.replaceChildren(
    header, stage, el("section", { class: "mission" }, tree.box), el("section", { class: "inspect" }, inspector.box),
    el("section", { class: "time" }, timeline.box), tabs.box,
  );
  app.classList.toggle("small", tree.rows.length < SMALL);
  timeline.onwindow = (from, to) => transport.fit([from, to]);
  const fit = () => { arena.fit(); timeline.fit(); transport.fit(); tree.update(); };
  new ResizeObserver(fit).observe(app);
  new ResizeObserver(() => { arena.fit(); space.draw(); }).observe(stage);
  dark.addEventListener("change", () => setTimeout(fit));
  tabs.choose("log");
  fit();
  picker.value = cursor.agent;
  cursor.say("select");
  cursor.move(cursor.t);
  keys(run, cursor, tabs, panels, flip.act);
  if (run.going) return live(run, cursor, { arena, tree, timeline, transport, header, panels });
  return () => {};
};

/** Button at the head of a run that goes on; returns what takes its changes. */
const live = (run, cursor, { arena, tree, timeline, transport, header, panels }) => {
  const head = el("button", { class: "head", title: "stay at the newest time", onclick: () => cursor.follow() }, "live");
  const show = () => {
    head.classList.toggle("on", cursor.follows);
    put(head, run.going ? "live" : "ended");
  };
  transport.box.append(head);
  cursor.addEventListener("follow", show);
  show();
  return (fresh) => {
    arena.grow();
    if (fresh) { tree.build(); panels.knowledge.build(); panels.signals.build(); }
    panels.log.grow();
    if (cursor.follows) cursor.lead();
    timeline.grow(fresh);
    transport.fit();
    put(header.querySelector(".time"), duration(run));
    header.querySelector(".badge").replaceWith(verdict(run, cursor));
    show();
  };
};

const duration = (run) => `seed ${run.header.seed}, ${(run.end - run.start).toFixed(1)} s`;

const keys = (run, cursor, tabs, panels, flip) => {
  const period = 1 / (run.header.rates?.control ?? 20);
  const acts = {
    " ": () => cursor.play(),
    ".": () => cursor.step(1),
    ",": () => cursor.step(-1),
    "/": () => { tabs.choose("signals"); panels.signals.find.focus(); },
    ArrowRight: (wide) => cursor.move(cursor.t + (wide ? 1 : period)),
    ArrowLeft: (wide) => cursor.move(cursor.t - (wide ? 1 : period)),
    Home: () => cursor.move(run.start),
    End: () => cursor.move(run.end),
    Escape: () => cursor.select(""),
    3: flip,
    f: () => { const { t, address } = run.moment(); cursor.select(address, t); },
  };
  addEventListener("keydown", (event) => {
    const { tagName } = /** @type {HTMLElement} */ (event.target), act = acts[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(tagName)) return;
    if (event.key === " " && tagName === "BUTTON") return; // presses the button
    event.preventDefault();
    act(event.shiftKey);
  });
};

const fail = (error) => {
  document.getElementById("app").replaceChildren(el("p", { class: "empty" }, `This page cannot show its run: ${error.message}`));
  throw error;
};

const data = document.getElementById("data");
if (data) Run.from(data.textContent).then(open).catch(fail);
else {
  let take = (_) => {};
  Run.open((fresh) => take(fresh)).then((run) => { take = open(run); }).catch(fail);
}
