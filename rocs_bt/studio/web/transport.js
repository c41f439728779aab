// @ts-check
// Play, steps, speed and clock, and the whole run as one bar with its marks.
import { button, el, prepare, put, seconds } from "./dom.js";
import { Lanes, marks } from "./lanes.js";

const HIGH = 28, PACES = [0.1, 0.25, 0.5, 1, 2, 5, 10];

export class Transport extends Lanes {
  constructor(run, cursor) {
    super(run, cursor);
    this.clock = el("output", { class: "clock" });
    this.play = button("▶", "play or pause (space)", () => cursor.play());
    this.pace = el(
      "select", { "aria-label": "speed", onchange: () => { cursor.pace = Number(this.pace.value); } },
      ...PACES.map((pace) => el("option", { value: pace, selected: pace === 1 }, `×${pace}`)),
    );
    this.canvas = el("canvas");
    this.line = el("div", { class: "now" });
    this.part = el("div", { class: "part", hidden: true });
    this.bar = el(
      "div",
      { class: "overview", role: "slider", tabindex: 0, "aria-label": "time", "aria-valuemin": run.start, "aria-valuemax": run.end },
      this.canvas, this.line, this.part,
    );
    const seek = (event) => {
      cursor.move(this.time(event.clientX - this.bar.getBoundingClientRect().left));
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
    cursor.addEventListener("play", () => put(this.play, cursor.playing ? "❚❚" : "▶"));
  }

  /** Frames the interval that the timeline shows. @param {number} from @param {number} to */
  frame(from, to) {
    const { run, part } = this, span = Math.max(run.end - run.start, 1e-9);
    part.hidden = to - from >= span - 1e-6;
    part.style.left = `${(100 * (from - run.start)) / span}%`;
    part.style.width = `${(100 * (to - from)) / span}%`;
  }

  grow() { this.build(); }

  /** Draws the bar. */
  build() {
    const { run, cursor } = this, wide = this.bar.clientWidth, span = Math.max(run.end - run.start, 1e-9);
    if (!wide) return;
    const g = prepare(this.canvas, wide, HIGH);
    Object.assign(this, { wide, from: run.start, to: run.start + span });
    const bars = run.get(cursor.agent, "route")?.spans(run.end).map(({ from, to, value }) => ({ from, to, fill: value })) ?? [];
    this.bars(g, { y: 10, high: 16, bars });
    this.points(g, { y: 0, high: 10, marks: marks(run, cursor.agent) });
    this.bar.setAttribute("aria-valuemax", run.end.toFixed(2));
    this.update();
  }

  update() {
    const { t } = this.cursor;
    put(this.clock, seconds(t));
    this.bar.setAttribute("aria-valuenow", t.toFixed(2));
    this.line.style.transform = `translateX(${this.wide ? this.x(t) : 0}px)`;
  }
}
