// @ts-check
// Editor of a content file. The text is the truth: tree, palette, form and faults are views of it.
import { Code } from "./code.js";
import { dialog, el, put } from "./dom.js";
import { Nodes } from "./nodes.js";
import { copy, edit, post, start } from "./server.js";

const REST = 180; // [ms] after which a text that rests is checked
const file = new URLSearchParams(location.search).get("file") ?? "";

const page = Math.random(); // of two pages with this file, neither replaces the questions of the other
const ask = (name, body) => post(`edit/${name}`, { file, page, ...body });

class Editor {
  constructor(given) {
    this.given = given;
    this.saved = given.text;
    this.hash = given.hash;
    this.marks = [];
    this.looked = 0;
    this.past = [];
    this.future = [];
    this.last = given.text;
    this.code = new Code({ change: () => this.change(), moved: () => this.follow(), ask: async (at) => (await this.quiet("complete", at))?.items ?? [] });
    const choose = (row) => { this.code.select(row.start, row.inner); this.look(false); };
    this.nodes = new Nodes({ edit: (asked) => this.edit(asked), choose, write: () => this.redraw() });
    this.mission = given.kind === "mission" && file.endsWith(".xml");
    this.state = el("output", { role: "status" });
    this.faults = el("ol", { class: "faults", "aria-label": "faults" });
    const wait = el("p", { class: "empty" }, "Tests run …");
    this.tests = el("section", { class: "tests", "aria-label": "tests", hidden: given.kind !== "rules" }, wait);
    this.about = el("p", { class: "about", "aria-live": "polite" });
    this.scenario = el("select", { "aria-label": "scenario to run" }, ...given.scenarios.map((name) => el("option", {}, name)));
    const button = (text, title, action, shown = true) => el("button", { title, hidden: !shown, onclick: action }, text);
    this.keep = button("Save", "save (ctrl s)", () => this.save(), !given.reason);
    const runs = given.scenarios.length > 0, own = () => copy(given.kind, given.shipped, (text) => this.tell(text));
    this.scenario.hidden = !runs;
    document.title = `${file}: rocs_bt editor`;
    const header = el(
      "header", {}, el("a", { href: "./", title: "the project" }, "←"), el("h1", {}, file),
      given.reason ? el("span", { class: "badge muted" }, "read only") : null,
      button("Copy into my project", "makes a file of your own, and opens it", own, Boolean(given.shipped)), this.keep,
      button("Undo", "undo (ctrl z)", () => this.step(this.past, this.future), !given.reason),
      button("Redo", "redo (ctrl y)", () => this.step(this.future, this.past), !given.reason),
      button("▶ Run", "save and run (ctrl enter)", () => this.run(), runs), this.scenario, this.state,
    );
    this.box = document.getElementById("editor") ?? el("main");
    this.box.classList.toggle("text", !this.mission);
    this.box.classList.toggle("alone", !this.mission && given.kind !== "rules");
    this.box.replaceChildren(
      header, el("section", { class: "left" }, this.nodes.palette, this.nodes.tree, this.nodes.form, this.tests),
      el("section", { class: "code" }, this.code.box, el("div", { class: "below" }, this.about, this.faults)),
    );
    this.code.area.readOnly = Boolean(given.reason);
    this.code.set(given.text);
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("beforeunload", (event) => { if (this.code.text !== this.saved) event.preventDefault(); });
    this.code.marks([]);
    this.tell();
    const learn = (found) => { this.nodes.learn(found.nodes); this.look(); };
    if (this.mission) ask("palette", { text: given.text }).then(learn, (error) => this.tell(error.message)); else this.look();
  }

  tell(text = "") {
    const changed = this.code.text !== this.saved;
    this.keep.disabled = !changed;
    put(this.state, text || this.given.reason || (changed ? "not saved" : "saved"));
  }

  /** Answer about a place; null if there is none, since typing asks for no error. */
  async quiet(name, at) {
    try { return await ask(name, { text: this.code.text, at }); } catch { return null; }
  }

  change() {
    const { text } = this.code;
    if (text === this.last) return;
    const now = performance.now();
    if (now - (this.typed ?? -1e9) > 600 || Math.abs(text.length - this.last.length) > 1) this.past.push(this.last); // a word is one step
    this.typed = now;
    this.last = text;
    this.future = [];
    this.tell();
    this.code.marks([]);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.look(), REST);
  }

  /** Another text, by an edit or by undo. */
  put(text) {
    this.code.set(text);
    this.last = text;
    this.typed = undefined;
    this.tell();
    return this.look();
  }

  step(from, to) {
    const text = from.pop();
    if (text === undefined || this.given.reason) return;
    to.push(this.code.text);
    this.put(text);
  }

  async edit(asked) {
    if (this.given.reason) return this.tell(this.given.reason);
    const before = this.code.text;
    if (this.drawn !== before) return; // the tree on the screen is that of an older text
    try {
      const { text, path, tree } = await ask("edit", { text: before, ...asked });
      if (this.code.text !== before || text === before) return;
      this.past.push(before);
      this.future = [];
      this.nodes.chosen = path;
      this.found = { ...this.found, tree, marks: [] };
      this.drawn = text;
      const looked = this.put(text);
      this.redraw();
      await looked;
      const row = this.nodes.row(path);
      if (row) this.code.select(row.start, row.inner);
    } catch (error) { this.tell(error.message); }
  }

  /** Checks the text and draws what it is; an answer about an older text, or an older place, is dropped. */
  async look(check = true) {
    const { text, at } = this.code, number = this.looked += 1, node = this.mission ? this.quiet("form", at) : null;
    try {
      const found = check ? await ask("look", { text }) : this.found;
      if ((check && !found) || text !== this.code.text) return;
      if (check) { this.found = found; this.drawn = text; this.redraw(); }
      const form = await node;
      if (!form || number !== this.looked || text !== this.code.text) return;
      const typing = this.nodes.form.contains(document.activeElement);
      if (!typing || form.path === this.nodes.chosen) this.refill(form);
      if (form.node && !this.nodes.tree.contains(document.activeElement)) this.nodes.choose(form.path, false);
    } catch (error) {
      if (text !== this.code.text) return;
      this.tell("not checked");
      this.faults.replaceChildren(el("li", { class: "warning" }, error.message));
    }
  }

  /** Fills the form again and leaves the cursor in its field. */
  refill(form) {
    const active = document.activeElement, name = this.nodes.form.contains(active) ? /** @type {any} */ (active).name : "";
    this.nodes.fill(form);
    if (name) /** @type {any} */ (this.nodes.form.elements.namedItem(name))?.focus();
  }

  redraw() {
    if (!this.found) return;
    const { marks, tree, tests } = this.found, errors = marks.filter((mark) => mark.level === "error").length;
    this.code.marks(marks);
    if (tree) this.nodes.show(tree, marks);
    const place = (mark) => el("b", {}, mark.file ? mark.level : `${mark.line}:${mark.column} ${mark.level}`);
    const line = (mark) => el(
      "li", { class: mark.level }, el("button", { onclick: () => this.go(mark) }, place(mark), ` ${mark.message} ${mark.hint}`),
      mark.instead && !this.given.reason ? el("button", { class: "fix", onclick: () => this.fix(mark) }, ` → ${mark.instead}`) : null,
    );
    this.faults.replaceChildren(...(marks.length ? marks.map(line) : [el("li", { class: "muted" }, "No fault found.")]));
    const failed = tests.filter((test) => !test.passed), name = file.replace(/^.*\//, "");
    const none = errors ? "Tests run when the file has no error." : `No tests. Those in rules/tests/${name} run here as you type.`;
    const row = (test) => el(
      "li", { class: test.passed ? "passed" : "failed", onclick: () => test.line && this.go({ line: test.line, column: 1, end: 1 }) },
      el("b", {}, test.passed ? "✓ " : "✗ "), `${test.rule}: ${test.test} (${test.robot})`, test.passed ? null : el("div", {}, test.message),
    );
    const passed = tests.filter((test) => test.passed), open = this.tests.querySelector("details")?.open ?? false;
    this.tests.replaceChildren(...(!tests.length ? [el("p", { class: "empty" }, none)] : [
      el("h3", {}, `${passed.length} of ${tests.length} tests pass`), el("ul", {}, ...failed.map(row)),
      el("details", { open }, el("summary", {}, `${passed.length} that pass`), el("ul", {}, ...passed.map(row))),
    ]));
    document.body.dataset.errors = String(errors);
  }

  go(mark) {
    if (mark.file) return;
    this.code.select(this.code.offset(mark.line, mark.column), this.code.offset(mark.line, mark.end), true);
    this.follow();
  }

  fix(mark) {
    const start = this.code.offset(mark.line, 1), row = this.code.text.slice(start).split("\n", 1)[0];
    const wrong = /'([^']*)'/.exec(mark.message.slice(mark.message.lastIndexOf("named")))?.[1] ?? /'([^']*)'/.exec(mark.message)?.[1] ?? "";
    const at = wrong ? row.indexOf(wrong, Math.max(0, mark.column - 1)) : -1;
    if (at >= 0) this.code.replace(start + at, start + at + wrong.length, mark.instead);
  }

  /** What is at the cursor: its description, and the form of its node. */
  follow() {
    clearTimeout(this.asking);
    this.asking = setTimeout(async () => {
      const { at } = this.code, about = await this.quiet("describe", at);
      if (at !== this.code.at) return;
      const { title, detail, doc } = about?.about ?? {}, to = about?.definition;
      this.about.replaceChildren(title ? el("b", {}, title) : "", title ? ` ${detail}${doc ? ". " + doc : ""} ` : "", to?.file ? this.link(to) : "");
      if (this.mission) this.look(false);
    }, 150);
  }

  link(to) {
    const here = to.file === file;
    if (!here) return el("a", { href: edit(to.file) }, `→ ${to.file}`);
    const go = (event) => { event.preventDefault(); this.go({ line: to.line, column: 1, end: 1 }); };
    return el("a", { href: "#", onclick: go }, `→ line ${to.line}`);
  }

  async save(hash = this.hash) {
    if (this.given.reason) return false;
    const { text } = this.code;
    try {
      const reply = await ask("save", { text, hash });
      if (reply.conflict) { this.differ(reply.conflict); return false; }
      this.hash = reply.hash;
      this.saved = text;
      this.tell();
      return true;
    } catch (error) { this.tell(error.message); return false; }
  }

  /** The file has changed on disk: both texts, and the choice. */
  differ({ text, hash }) {
    this.tell("the file has changed on disk; it was not overwritten");
    const rows = (own, other) => {
      const known = new Set(other.split("\n"));
      return own.split("\n").flatMap((row) => [known.has(row) ? row : el("ins", {}, row || " "), "\n"]);
    };
    const mine = this.code.text, take = () => { box.close(); this.past.push(mine); Object.assign(this, { hash, saved: text }); this.put(text); };
    const keep = () => { box.close(); this.save(hash); };
    const box = dialog(
      "The file has changed on disk", el("div", { class: "both" },
        el("section", {}, el("h3", {}, "on disk"), el("pre", {}, ...rows(text, mine)), el("button", { onclick: take }, "Take that of the disk")),
        el("section", {}, el("h3", {}, "here"), el("pre", {}, ...rows(mine, text)), el("button", { onclick: keep }, "Overwrite the disk"))),
    );
  }

  async run() {
    if (this.code.text !== this.saved && !this.given.reason && !(await this.save())) return;
    try {
      await start({ scenario: this.scenario.value });
    } catch (error) { this.tell(error.message); }
  }

  key(event) {
    if (!event.ctrlKey && !event.metaKey) return;
    const undo = () => this.step(this.past, this.future), redo = () => this.step(this.future, this.past);
    const own = { s: () => this.save(), Enter: () => this.run(), z: event.shiftKey ? redo : undo, y: redo };
    const act = own[event.key] ?? own[event.key.toLowerCase()];
    if (act && !(document.activeElement instanceof HTMLInputElement && event.key !== "s" && event.key !== "Enter")) { event.preventDefault(); act(); }
  }
}

ask("open", {}).then((given) => { /** @type {any} */ (globalThis).editor = new Editor(given); }, (error) => {
  document.getElementById("editor")?.replaceChildren(el("p", { class: "empty" }, `This file cannot be opened: ${error.message}`));
});
