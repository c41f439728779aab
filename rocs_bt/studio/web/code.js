// @ts-check
// The text of a file: line numbers, underlined faults, completion.
import { el } from "./dom.js";

const LINE = 19; // [px] height of a line, as in edit.css

/** Text area with marks below its text and a list of proposals above it. */
export class Code {
  /** @param {{change: () => void, moved: () => void, ask: (at: number) => Promise<any[]>}} on */
  constructor(on) {
    this.on = on;
    this.items = [];
    this.chosen = 0;
    this.numbers = el("pre", { "aria-hidden": "true" });
    this.under = el("div", { class: "under", "aria-hidden": "true" });
    this.list = el("ul", { class: "proposals", role: "listbox", id: "proposals", hidden: true });
    this.area = el("textarea", {
      spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off", "aria-label": "text of the file", "aria-controls": "proposals",
      oninput: (event) => { this.on.change(); this.typed(event); }, onkeydown: (event) => this.key(event),
      onkeyup: () => this.on.moved(), onclick: () => { this.hide(); this.on.moved(); }, onscroll: () => { this.scroll(); this.hide(); },
      onblur: () => setTimeout(() => this.hide(), 150),
    });
    this.box = el("div", { class: "page" }, this.numbers, el("div", { class: "sheet" }, this.under, this.area, this.list));
  }

  get text() { return this.area.value; }
  get at() { return this.area.selectionStart; }

  /** Shows a text; the place on the screen stays. */
  set(text) {
    const { scrollTop, scrollLeft } = this.area;
    if (this.area.value !== text) this.area.value = text;
    Object.assign(this.area, { scrollTop, scrollLeft });
  }

  /** Replaces a span and leaves the cursor at the sign $1, or behind it. The browser's own undo knows of it. */
  replace(start, end, text) {
    const cursor = text.indexOf("$1"), plain = text.replace("$1", "");
    this.area.focus();
    this.area.setSelectionRange(start, end);
    if (!document.execCommand("insertText", false, plain)) { this.area.setRangeText(plain, start, end, "end"); this.on.change(); }
    const at = start + (cursor < 0 ? plain.length : cursor);
    this.area.setSelectionRange(at, at);
  }

  select(start, end, focus = false) {
    const { area } = this, top = LINE * (this.text.slice(0, start).split("\n").length - 1);
    if (focus) area.focus();
    area.setSelectionRange(start, end);
    if (top < area.scrollTop || top > area.scrollTop + area.clientHeight - 2 * LINE) area.scrollTop = Math.max(0, top - 5 * LINE);
  }

  offset(line, column) {
    return this.text.split("\n").slice(0, line - 1).reduce((sum, row) => sum + row.length + 1, 0) + column - 1;
  }

  scroll() {
    this.numbers.scrollTop = this.area.scrollTop;
    this.under.style.transform = `translate(${-this.area.scrollLeft}px, ${-this.area.scrollTop}px)`;
  }

  /** Underlines faults. */
  marks(marks) {
    const rows = this.text.split("\n"), level = new Map();
    for (const mark of [...marks].reverse()) {
      if (!mark.file && mark.level !== "note" && level.get(mark.line) !== "error") level.set(mark.line, mark.level);
    }
    this.numbers.replaceChildren(...rows.flatMap((_, i) => [level.has(i + 1) ? el("span", { class: level.get(i + 1) }, `● ${i + 1}`) : String(i + 1), "\n"]));
    const found = marks.filter((mark) => !mark.file && mark.line <= rows.length).sort((a, b) => a.line - b.line || a.column - b.column);
    const parts = [];
    let line = 1, column = 1;
    for (const mark of found) {
      if (mark.line < line || (mark.line === line && mark.column < column)) continue;
      if (mark.line > line) { parts.push(rows[line - 1].slice(column - 1) + "\n" + "\n".repeat(mark.line - line - 1)); [line, column] = [mark.line, 1]; }
      const row = rows[line - 1];
      parts.push(row.slice(column - 1, mark.column - 1), el("mark", { class: mark.level }, row.slice(mark.column - 1, mark.end - 1) || " "));
      column = mark.end;
    }
    this.under.replaceChildren(...parts);
    this.scroll();
  }

  typed(event) {
    if (event.inputType === "insertText" && /[\w<"'{[ =.]/.test(event.data ?? "")) this.complete(event.data);
    else if (event.inputType === "deleteContentBackward" && !this.list.hidden) this.complete("");
    else this.hide();
  }

  /** Asks for proposals; those that do not begin like the word are left out. */
  async complete(why) {
    const { at, text } = this;
    clearTimeout(this.timer);
    await new Promise((done) => { this.timer = setTimeout(done, why === null ? 0 : 120); });
    const items = await this.on.ask(at);
    if (this.at !== at || this.text !== text) return;
    const fits = (item) => item.label.toLowerCase().includes(text.slice(item.start, at).toLowerCase());
    const first = (item) => (item.label.toLowerCase().startsWith(text.slice(item.start, at).toLowerCase()) ? 0 : 1);
    this.items = items.filter(fits).sort((a, b) => first(a) - first(b)).slice(0, 60);
    if (!this.items.length || (why === " " && this.items[0].kind !== "port")) return this.hide();
    this.chosen = 0;
    const take = (i) => (event) => { event.preventDefault(); this.take(i); };
    this.list.replaceChildren(...this.items.map((item, i) => (
      el("li", { role: "option", onmousedown: take(i) }, el("span", {}, item.label), el("small", {}, item.detail), el("p", {}, item.doc))
    )));
    const before = text.slice(0, this.items[0].start).split("\n"), width = 7.83;
    this.list.style.top = `${before.length * LINE + 8 - this.area.scrollTop}px`;
    this.list.style.left = `${Math.max(0, Math.min((before.at(-1) ?? "").length * width - this.area.scrollLeft, this.area.clientWidth - 230))}px`;
    this.list.hidden = false;
    this.choose(0);
  }

  choose(i) {
    this.chosen = (i + this.items.length) % this.items.length;
    [...this.list.children].forEach((row, k) => row.setAttribute("aria-selected", String(k === this.chosen)));
    this.list.children[this.chosen].scrollIntoView({ block: "nearest" });
  }

  take(i) {
    const item = this.items[i];
    this.hide();
    this.replace(item.start, Math.max(item.end, this.at), item.new);
    if (item.new.includes("$1") && item.kind !== "Control" && item.kind !== "Decorator") this.complete("");
  }

  hide() { this.list.hidden = true; }

  key(event) {
    if (event.key === " " && event.ctrlKey) { event.preventDefault(); this.complete(null); return; }
    if (!this.list.hidden) {
      const take = () => this.take(this.chosen), by = (step) => () => this.choose(this.chosen + step);
      const act = { ArrowDown: by(1), ArrowUp: by(-1), Enter: take, Tab: take, Escape: () => this.hide() }[event.key];
      if (act) { event.preventDefault(); event.stopPropagation(); act(); }
    } else if (event.key === "Enter" && !event.ctrlKey && !event.metaKey) { // the next line begins where this one does
      const indent = /^[ \t]*/.exec(this.text.slice(this.text.lastIndexOf("\n", this.at - 1) + 1, this.at))?.[0] ?? "";
      if (indent) { event.preventDefault(); this.replace(this.at, this.area.selectionEnd, "\n" + indent); }
    }
  }
}
