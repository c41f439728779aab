// @ts-check
// The one time, and the one selection. All panels listen to them, and the address of the page contains both.

export class Cursor extends EventTarget {
  constructor(run) {
    super();
    const given = new URLSearchParams(location.hash.slice(1)), moment = run.moment();
    const address = given.get("select") ?? moment.address;
    const agent = given.get("agent") ?? address.split("|")[0];
    this.run = run;
    this.playing = false;
    this.pace = 1;
    this.selected = address;
    this.follows = run.going && !given.has("t");
    /** @type {Set<string>} addresses of nodes and rules at whose failing or firing the page pauses */
    this.stops = new Set();
    this.agent = run.agents.includes(agent) ? agent : run.agents[0];
    this.t = this.limited(Number(given.get("t") ?? (this.follows ? run.end : moment.t)));
    addEventListener("hashchange", () => {
      const now = new URLSearchParams(location.hash.slice(1)), t = Number(now.get("t") ?? this.t);
      if ((now.get("select") ?? "") !== this.selected) this.select(now.get("select") ?? "", t);
      else if (Math.abs(t - this.t) > 1e-3) this.move(t);
    });
  }

  limited(t) { return Number.isFinite(t) ? Math.min(this.run.end, Math.max(this.run.start, t)) : this.run.start; }

  say(name) { this.dispatchEvent(new Event(name)); }

  /** Stays at the head of a run that goes on, until the cursor is moved. */
  follow(on = true) {
    this.follows = on;
    this.say("follow");
    if (on) this.lead();
  }

  lead() {
    const before = this.t, hit = this.stopped(before, this.run.end);
    this.t = this.run.end;
    if (hit !== undefined) this.move(hit); else this.say("move");
  }

  /** Sets or removes a stop: playing, and following a run that goes on, ends when this node fails or this rule fires. */
  stop(address) {
    if (!this.stops.delete(address)) this.stops.add(address);
    this.say("stops");
    this.say("move");
  }

  /** First time after `from` and until `to` at which something with a stop happens; undefined if nothing does. */
  stopped(from, to) {
    const times = [...this.stops].flatMap((address) => this.run.tracks.get(address)?.hits.find((t) => t > from + 1e-4 && t <= to + 1e-6) ?? []);
    return times.length ? Math.min(...times) : undefined;
  }

  /** Goes to a time. @param {number} t */
  move(t) {
    if (this.follows && t < this.run.end - 1e-6) this.follow(false);
    this.t = this.limited(t);
    this.say("move");
    this.write();
  }

  /** Selects a track, and goes to a time if one is given. @param {string} address @param {number} [t] */
  select(address, t = this.t) {
    const agent = address.split("|")[0], changes = agent !== this.agent && this.run.agents.includes(agent);
    this.selected = address;
    this.t = this.limited(t);
    if (changes) { this.agent = agent; this.say("agent"); }
    this.say("select");
    this.move(this.t);
  }

  /** Shows another robot. @param {string} agent */
  show(agent) {
    this.agent = agent;
    this.say("agent");
    this.select("");
  }

  /** Goes to the next or the previous line of the log. @param {1 | -1} sign */
  step(sign) {
    const times = this.run.log.filter(([, , level]) => level > 1).map(([t]) => t);
    const found = sign > 0 ? times.find((t) => t > this.t + 1e-4) : times.findLast((t) => t < this.t - 1e-4);
    if (found !== undefined) this.move(found);
  }

  play(on = !this.playing) {
    this.playing = on;
    this.say("play");
    if (!on) return;
    if (this.t >= this.run.end - 1e-6) this.t = this.run.start;
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const to = this.t + (Math.max(0, now - last) / 1000) * this.pace, hit = this.stopped(this.t, to);
      this.move(hit ?? to);
      last = now;
      if (hit !== undefined) this.play(false);
      else if (this.t < this.run.end) requestAnimationFrame(frame); else this.play(false);
    };
    requestAnimationFrame(frame);
  }

  write() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const parts = { t: this.t.toFixed(2), agent: this.agent, ...(this.selected && { select: this.selected }) };
      if (location.protocol !== "about:") history.replaceState(null, "", `#${new URLSearchParams(parts)}`);
    }, 150);
  }
}
