// @ts-check
// Elements, colours, and numbers as text. Names from content are always text, never markup.

/**
 * Makes an element. Properties that begin with `on` are listeners, `class` is the class, others are attributes.
 * @param {string} tag
 * @param {Record<string, any>} [properties]
 * @param {...(Node | string | null | undefined)} children
 * @returns {any}
 */
export const el = (tag, properties = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== undefined && value !== false && value !== null) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
};

/** Button with a text, and a title for the pointer and for readers of the screen. */
export const button = (text, title, act) => el("button", { title, "aria-label": title, onclick: act }, text);

/** Field to search by, of which each change asks for `act`. */
export const search = (label, act) => el("input", { type: "search", placeholder: label, "aria-label": label.replace(/ \(.*/, ""), oninput: act });

/** Steps by the arrows up and down, without scrolling. @param {KeyboardEvent} event @param {(step: number) => void} act */
export const arrows = (event, act) => {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (!step) return;
  event.preventDefault();
  event.stopPropagation();
  act(step);
};

/** @type {Map<object, () => void>} */
const later = new Map();

/** Does one thing for each owner after all panels have changed, so that the browser lays out the page once. */
export const afterwards = (owner, act) => {
  if (!later.size) setTimeout(() => { const acts = [...later.values()]; later.clear(); for (const each of acts) each(); });
  later.set(owner, act);
};

/** Sets a text, and a title if one is given, only if the text differs: most rows stay as they are when the cursor moves. */
export const put = (element, text, title = "") => {
  if (element.shown === text) return;
  element.shown = text; // faster to read than the text of an element
  element.textContent = text;
  if (title) element.title = title;
};

/** Sets a class of those names that are not empty, only if it differs. */
export const styled = (element, ...names) => {
  const name = names.filter(Boolean).join(" ");
  if (element.className !== name) element.className = name;
};

/** Scrolls a list, and not the page around it, so that an item is in view. */
export const reveal = (list, item) => {
  const { top, bottom } = list.getBoundingClientRect(), at = item.getBoundingClientRect();
  list.scrollTop += at.top < top ? at.top - top : Math.max(0, at.bottom - bottom);
};

let palette = new Map();
export const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => { palette = new Map(); });

/** Value of a colour of the style sheet, for canvases. @param {string} name */
export const color = (name) => {
  if (!palette.has(name)) {
    palette.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }
  return palette.get(name);
};

/** A value as text with three digits. @param {any} value @returns {string} */
export const shown = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    const all = Array.from(/** @type {any} */ (value));
    if (all.length === 1) return shown(all[0]);
    return all.length > 8 ? `${all.length} values` : `[${all.map(shown).join(", ")}]`;
  }
  if (typeof value === "object") return Object.entries(value).map(([name, inner]) => `${name} = ${shown(inner)}`).join(", ");
  if (typeof value !== "number") return String(value);
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const text = Math.abs(value) >= 1000 ? value.toFixed(0) : Number(value.toPrecision(3)).toString();
  return text.replace("-", "−");
};

/** Time in seconds as text. @param {number} t */
export const seconds = (t) => `${t.toFixed(2)} s`;

/** Last part of a path of a node, or of a rule of a file. @param {string} path */
export const short = (path) => path.slice(path.lastIndexOf("/") + 1);

/** Number of entries of a sorted array that are not later than t. @param {ArrayLike<number>} times @param {number} t */
export const upto = (times, t) => {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t + 1e-6) low = middle + 1; else high = middle;
  }
  return low;
};

/** Prepares a canvas for drawing in CSS pixels, at the resolution of the screen; its size must be laid out. */
export const prepare = (canvas, width, height) => {
  const ratio = devicePixelRatio || 1, g = canvas.getContext("2d"), size = [width, height].map((each) => Math.round(each * ratio));
  if (canvas.width !== size[0] || canvas.height !== size[1]) { [canvas.width, canvas.height] = size; g.face = ""; }
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, width + 1, height + 1);
  return Object.assign(g, { globalAlpha: 1, lineWidth: 1, textAlign: "start" });
};

/** Sets the font of a canvas only if it differs: setting it makes the browser compute the styles of the page. */
export const face = (g, size, weight = 400) => {
  const font = `${weight} ${size}px ${FONT}`;
  if (g.face !== font) g.font = g.face = font;
};

const widths = new Map();

/** Width of a text in the font of a canvas; measured once, since that takes long. */
export const widthOf = (g, text) => {
  const key = `${g.face} ${text}`;
  if (!widths.has(key)) widths.set(key, g.measureText(text).width);
  return widths.get(key);
};

/** Opens a dialog; it closes with its button, with escape, or with a click beside it. */
export const dialog = (title, ...children) => {
  const header = el("header", {}, el("h2", {}, title), button("×", "close", () => box.close()));
  const box = el("dialog", { "aria-label": title }, header, ...children);
  box.addEventListener("close", () => box.remove());
  box.addEventListener("click", (event) => { if (event.target === box) box.close(); });
  document.body.append(box);
  box.showModal();
  return box;
};

const FONT = "system-ui, \"Segoe UI\", Roboto, \"DejaVu Sans\", sans-serif";
