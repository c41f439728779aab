// @ts-check
// All robots as a table at the cursor: outcome, what each does, its progress and its clearance.
import { View } from "./cursor.js";
import { arrows, el, put, short, shown, styled } from "./dom.js";

const COLUMNS = ["robot", "outcome", "does", "to go", "clearance"];

export class Fleet extends View {
  constructor(run, cursor) {
    super(run, cursor);
    this.body = el("tbody");
    const head = el("tr", {}, ...COLUMNS.map((name) => el("th", { scope: "col" }, name)));
    this.box = el("div", { class: "fleet", tabindex: 0, "aria-label": "robots" }, el("table", {}, el("thead", {}, head), this.body));
    this.box.addEventListener("keydown", (event) => arrows(event, (step) => this.step(step)));
    this.fill();
  }

  grow(fresh) { if (fresh) this.fill(); }

  fill() {
    const { run } = this, order = { bad: 0, muted: 1, good: 2 };
    const tone = (agent) => run.tone(run.outcome(agent)?.outcome);
    const agents = [...run.agents].sort((a, b) => order[tone(a)] - order[tone(b)] || a.localeCompare(b, "en", { numeric: true }));
    this.rows = agents.map((agent) => {
      const cells = COLUMNS.map(() => el("td"));
      const dot = el("span", { class: "dot" }), name = el("span"), bar = el("i"), part = el("span");
      cells[0].append(dot, agent);
      cells[1].append(name);
      cells[3].append(el("span", { class: "progress" }, bar), part);
      const row = el("tr", { onclick: () => this.cursor.select(`${agent}|pose|`) }, ...cells);
      const goal = run.get(agent, "signal", "goal_distance"), most = goal ? goal.range[1] : NaN;
      return { agent, row, cells, dot, name, bar, part, goal, most, outcome: null, clearance: run.get(agent, "truth", "min_clearance") };
    });
    this.body.replaceChildren(...this.rows.map(({ row }) => row));
    this.update();
  }

  /** What a robot does at a time: its reflex, else its action, else where its mission waits. */
  doing(agent, t) {
    const { run } = this, rule = run.of(agent, "rule").find((each) => each.at(t)?.active);
    if (rule) return { text: short(rule.name), route: "reactive" };
    const ticket = run.of(agent, "ticket").findLast((each) => each.t[0] <= t && each.at(t)?.state === "RUNNING");
    return ticket ? { text: ticket.at(t).action, route: "deliberative" } : { text: "–", route: "idle" };
  }

  update() {
    const { t } = this.cursor;
    for (const each of this.rows) {
      const { agent, row, cells, dot, name, bar, part, goal, most, clearance } = each;
      const outcome = each.outcome ??= this.run.outcome(agent), over = outcome && outcome.t <= t + 1e-3, { text, route } = this.doing(agent, t);
      const left = goal?.at(t), done = Number.isFinite(left) && most > 0 ? Math.max(0, 1 - left / most) : 0;
      put(name, outcome ? outcome.outcome : "–");
      styled(name, outcome ? this.run.tone(outcome.outcome) : "muted");
      put(cells[2], over ? "ended" : text);
      styled(dot, "dot", over ? this.run.tone(outcome.outcome) : route);
      const wide = `${(100 * done).toFixed(0)}%`;
      if (bar.style.width !== wide) bar.style.width = wide;
      put(part, goal ? `${shown(left)} m` : "–");
      put(cells[4], `${shown(clearance?.at(t))} m`);
      styled(row, agent === this.cursor.agent ? "selected" : "");
    }
  }

  step(step) {
    const next = this.rows[this.rows.findIndex(({ agent }) => agent === this.cursor.agent) + step];
    if (next) { this.cursor.select(`${next.agent}|pose|`); next.row.scrollIntoView({ block: "nearest" }); }
  }
}
