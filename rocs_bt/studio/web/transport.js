// @ts-check
// Play, steps, speed and clock, and the whole run as one bar with its marks.
import { button, color, el, prepare, put, seconds } from "./dom.js";
import { Lanes, marks } from "./lanes.js";

const HIGH = 28, PACES = [0.1, 0.25, 0.5, 1, 2, 5, 10];

export class Transport {
  constructor(run, cursor) {
    this.run = run;
    this.cursor = cursor;
    /** @type {number[] | null} */
    this.window = null;
    this.lanes = new Lanes(run, cursor);
    this.clock = el("output", { class: "clock" });
    this.play = button("▶", "play or pause (space)", () => cursor.play());
    this.pace = el(
      "select", { "aria-label": "speed", onchange: () => { cursor.pace = Number(this.pace.value); } },
      ...PACES.map((pace) => el("option", { value: pace, selected: pace === 1 }, `×${pace}`)),
    );
    this.canvas = el("canvas");
    this.line = el("div", { class: "now" });
    this.bar = el(
      "div",
      { class: "overview", role: "slider", tabindex: 0, "aria-label": "time", "aria-valuemin": run.start, "aria-valuemax": run.end },
      this.canvas, this.line,
    );
    const seek = (event) => {
      cursor.move(this.lanes.time(event.clientX - this.bar.getBoundingClientRect().left));
    };
    this.bar.addEventListener("pointerdown", (event) => { this.bar.setPointerCapture(event.pointerId); seek(event); });
    this.bar.addEventListener("pointermove", (event) => { if (event.buttons === 1) seek(event); });
    this.box = el(
      "div", { class: "transport" },
      button("⇤", "to the start (home)", () => cursor.move(run.start)),
      button("‹", "previous event (,)", () => cursor.step(-1)),
      this.play,
      button("›", "next event (.)", () => cursor.step(1)),
      button("⇥", "to the end (end)", () => cursor.move(run.end)),
      button("⚑", "the decisive moment (f)", () => { const { t, address } = run.moment; cursor.select(address, t); }),
      this.pace, this.clock, this.bar,
    );
    cursor.addEventListener("move", () => this.place());
    cursor.addEventListener("agent", () => this.fit());
    cursor.addEventListener("play", () => put(this.play, cursor.playing ? "❚❚" : "▶"));
  }

  /** Draws the bar; `window` is the interval that the timeline shows. */
  fit(window = this.window) {
    const { run, cursor } = this, wide = this.bar.clientWidth, span = Math.max(run.end - run.start, 1e-9);
    this.window = window;
    if (!wide) return;
    const g = prepare(this.canvas, wide, HIGH), { lanes } = this;
    Object.assign(lanes, { wide, from: run.start, to: run.start + span });
    const bars = run.get(cursor.agent, "route")?.spans(run.end).map(({ from, to, value }) => ({ from, to, fill: value })) ?? [];
    lanes.bars(g, { y: 10, high: 16, bars });
    lanes.points(g, { y: 0, high: 10, marks: marks(run, cursor.agent) });
    if (window && window[1] - window[0] < span - 1e-6) {
      g.strokeStyle = color("ink");
      g.strokeRect(lanes.x(window[0]) + 0.5, 9.5, lanes.x(window[1]) - lanes.x(window[0]) - 1, 17);
    }
    this.bar.setAttribute("aria-valuemax", run.end.toFixed(2));
    this.place();
  }

  place() {
    const { t } = this.cursor;
    put(this.clock, seconds(t));
    this.bar.setAttribute("aria-valuenow", t.toFixed(2));
    this.line.style.transform = `translateX(${this.lanes.wide ? this.lanes.x(t) : 0}px)`;
  }
}
