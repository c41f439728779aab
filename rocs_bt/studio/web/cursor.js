// @ts-check
// The one time, and the one selection. All panels listen to them. The address of the page contains both, and what the
// panels keep in it: a link, a bookmark, and a step back of the browser show the same picture.

const given = () => new URLSearchParams(location.hash.slice(1));

/**
 * A part of the page. `update` shows what holds at the cursor, while the part is visible; `build` makes what belongs to
 * the shown robot; `grow` takes what is new in a run that goes on, and is told whether new tracks began.
 */
export class View {
  constructor(run, cursor, /** @type {any} */ box = null) {
    this.run = run;
    this.cursor = cursor;
    this.box = box;
    for (const name of ["move", "shown"]) cursor.addEventListener(name, () => { if (!this.box?.hidden) this.update(); });
    cursor.addEventListener("agent", () => this.build());
    cursor.addEventListener("grow", ({ detail }) => this.grow(detail));
  }

  update() { /* nothing depends on the time */ }

  build() { this.update(); }

  grow(fresh) { if (fresh) this.build(); }
}

export class Cursor extends EventTarget {
  constructor(run) {
    super();
    const now = given(), moment = run.moment, wanted = now.get("select") ?? (now.has("agent") ? "" : moment.address);
    this.run = run;
    /** @type {{name: string, give: () => string[], take: (texts: string[]) => void}[]} */
    this.kept = [];
    /** @type {Set<string>} what an address names and the run does not have */
    this.lost = new Set();
    this.pushes = false;
    this.playing = false;
    this.pace = 1;
    this.selected = this.known(wanted);
    this.follows = run.going && !now.has("t");
    /** @type {Set<string>} addresses of nodes and rules at whose failing or firing the page pauses */
    this.stops = new Set();
    /** @type {Map<string, number>} how often it has happened at each of them while the page follows */
    this.counted = new Map();
    this.agent = this.robot(now, wanted);
    this.t = this.limited(Number(now.get("t") ?? (this.follows ? run.end : moment.t)));
    onhashchange = () => this.read();
  }

  /** An address of the run; empty for one that it does not have. @param {string} address */
  known(address) {
    if (this.run.going || this.run.has(address)) return address;
    this.lost.add(address.replaceAll(/[|\n]+/g, " ").trim());
    return "";
  }

  /** Robot that an address names, else that of the selected thing, else the first. */
  robot(now, selected) {
    const { agents } = this.run, agent = now.get("agent") ?? selected.split("|")[0];
    if (agent && agents.length && !agents.includes(agent)) this.lost.add(agent);
    return agents.includes(agent) ? agent : agents[0];
  }

  /** Keeps a part of the view in the address: `give` returns its texts, and `take` shows those of an address. */
  keep(name, give, take) {
    this.kept.push({ name, give, take });
    const texts = given().getAll(name);
    if (texts.length) take(texts);
  }

  /** Shows what the address says, such as after a step back. */
  read() {
    this.lost.clear();
    const now = given(), t = Number(now.get("t") ?? this.t), selected = this.known(now.get("select") ?? ""), agent = this.robot(now, selected);
    if (agent !== this.agent) this.show(agent);
    for (const { name, take } of this.kept) take(now.getAll(name));
    if (selected !== this.selected) this.select(selected, t); else this.move(t);
    this.pushes = false;
    this.say("lost");
  }

  /** Address of the page for a time and a selection. */
  address(t = this.t, selected = this.selected, agent = this.agent) {
    const parts = new URLSearchParams({ t: String(Number(t.toFixed(4))), agent: agent ?? "", ...(selected && { select: selected }) });
    for (const { name, give } of this.kept) for (const text of give()) parts.append(name, text);
    return `#${parts}`;
  }

  limited(t) { return Number.isFinite(t) ? Math.min(this.run.end, Math.max(this.run.start, t)) : this.run.start; }

  say(name, detail = null) { this.dispatchEvent(new CustomEvent(name, { detail })); }

  /** Stays at the head of a run that goes on, until the cursor is moved. */
  follow(on = true) {
    this.follows = on;
    this.say("follow");
    this.news();
    if (on) this.lead();
  }

  /** First time that is new at a stop; what has come until now is new no more. The head does not tell: events may come late. */
  news() {
    const fresh = [...this.stops].flatMap((address) => {
      const hits = this.run.tracks.get(address)?.hits ?? [], count = this.counted.get(address) ?? hits.length;
      this.counted.set(address, hits.length);
      return hits.slice(count, count + 1);
    });
    return fresh.length ? Math.min(...fresh) : undefined;
  }

  lead() {
    const hit = this.news();
    this.t = this.run.end;
    if (hit !== undefined) this.move(hit); else this.say("move");
  }

  /** Sets or removes a stop: playing, and following a run that goes on, ends when this node fails or this rule fires. */
  stop(address) {
    if (!this.stops.delete(address)) this.stops.add(address);
    this.counted.delete(address);
    this.news();
    this.say("stops");
    this.say("move");
  }

  /** First time after `from` and until `to` at which something with a stop happens; undefined if nothing does. Intervals in a row leave no gap. */
  stopped(from, to) {
    const times = [...this.stops].flatMap((address) => this.run.tracks.get(address)?.hits.find((t) => t > from && t <= to) ?? []);
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
    this.pushes ||= address !== this.selected;
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

  /** Writes the address; another selection is a step of the browser's history. */
  write() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (location.protocol !== "about:" && this.address() !== location.hash) history[this.pushes ? "pushState" : "replaceState"](null, "", this.address());
      this.pushes = false;
    }, 150);
  }
}
