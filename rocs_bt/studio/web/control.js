// @ts-check
// Control of a run that goes on: pause, step, continue, swap a subtree, reload a rule file; stop, and run again.
import { button, dialog, el, put } from "./dom.js";
import { post, runName, start } from "./server.js";

/** Asks in a dialog; the form's values go to `act`. */
const ask = (title, label, fields, act) => {
  const submit = (event) => {
    event.preventDefault();
    act(Object.fromEntries(Object.entries(fields).map(([name, field]) => [name, field.value])));
    box.close();
  };
  const rows = Object.entries(fields).map(([name, field]) => el("label", {}, el("span", {}, name), field));
  const box = dialog(title, el("form", { class: "ask", onsubmit: submit }, ...rows, el("div", { class: "acts" }, el("button", { class: "main" }, label))));
};

const WAITING = "waiting for go"; // end of the reason of a pause on hardware

export class Control {
  constructor(run, cursor) {
    this.run = run;
    this.cursor = cursor;
    this.pause = button("", "pause or continue the run (p)", () => this.toggle());
    this.step = button("step", "one control period, then pause (x)", () => this.send({ kind: "step" }));
    this.swap = button("swap …", "replace the selected subtree by that of an XML mission", () => this.askSwap());
    const reload = () => this.send(...this.rules().map((rules) => ({ kind: "reload", agent: cursor.agent, rules })));
    this.reload = button("reload", "read the rule files of this robot again", reload);
    this.stop = button("■ stop", "end the run in order, with its report", () => this.try(post("stop")));
    const but = run.header.swaps?.length ? " without its swaps: the command of the run repeats them" : "";
    this.again = button("↻ again", `run the scenario again${but} (a)`, () => this.rerun());
    this.notice = el("output", { class: "muted", role: "status" });
    const parts = [this.pause, this.step, this.swap, this.reload, this.stop, this.again, this.notice];
    this.box = el("div", { class: "control", role: "group", "aria-label": "control of the run" }, ...parts);
    this.update();
  }

  /** Whether the run takes a kind of command. */
  takes(kind) { return Boolean(this.run.going && this.run.control && this.run.header.commands?.includes(kind)); }

  /** Whether the next command of the button lets the run go on. */
  get paused() { return this.takes("continue") && ["pause", "step"].includes(this.run.get("", "control")?.v.at(-1)); }

  /** Whether robots on hardware wait in neutral for a person at their terminal. */
  get waits() {
    const waiting = (agent) => this.run.of(agent, "hold").some((hold) => hold.v.at(-1)?.includes(WAITING));
    return !this.takes("continue") && this.run.agents.some(waiting);
  }

  rules() { return this.run.info(this.cursor.agent)?.rules ?? []; }

  update() {
    const { run, waits } = this, heard = Boolean(run.going && run.control);
    put(this.pause, waits ? "paused" : this.paused ? "▶ continue" : "❚❚ pause");
    if (waits !== this.pause.disabled) put(this.notice, waits ? "press Enter at the robot's terminal" : "");
    this.pause.disabled = waits;
    for (const kind of ["pause", "step", "swap", "reload"]) this[kind].hidden = !this.takes(kind);
    this.stop.hidden = !heard || !runName;
    this.again.hidden = !runName || Boolean(run.other);
    this.box.hidden = this.again.hidden && !heard;
  }

  toggle() { return this.send({ kind: this.paused ? "continue" : "pause" }); }

  send(...commands) { for (const command of commands) this.try(post("control", command)); }

  try(asked) {
    put(this.notice, "");
    return asked.catch((error) => put(this.notice, error.message));
  }

  rerun() {
    const { scenario, seed, mode, command = "" } = this.run.header, limit = /--for ([\d.e+-]+)/.exec(command);
    this.try(start(limit ? { scenario, seed, mode, duration: Number(limit[1]) } : { scenario, seed, mode }));
  }

  askSwap() {
    const [agent, topic] = this.cursor.selected.split("|", 2), chosen = topic === "node" ? this.cursor.selected.slice(agent.length + 6) : "";
    const node = el("input", { value: chosen, required: true, placeholder: "select it in the tree, or type its name" });
    const mission = el("input", { required: true, placeholder: "name of an XML mission" });
    const tree = el("input", { placeholder: "its main tree" });
    const act = (values) => this.send({ kind: "swap", agent: this.cursor.agent, ...values });
    ask("Replace a subtree of the mission", "swap", { node, mission, tree }, act);
  }

  /** Keys with their texts. */
  keys() {
    const press = (button, act) => () => { if (!button.hidden && !button.disabled && !this.box.hidden) act(); };
    return [
      { key: "p", keys: ["p"], text: "pause or continue a run that goes on", act: press(this.pause, () => this.toggle()) },
      { key: "x", keys: ["x"], text: "one control period of a run that goes on, then pause", act: press(this.step, () => this.step.click()) },
      { key: "a", keys: ["a"], text: "run the scenario again, in the studio", act: press(this.again, () => this.rerun()) },
    ];
  }
}
