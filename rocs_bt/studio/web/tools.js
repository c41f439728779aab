// @ts-check
// What a reader takes along or asks for: keys, values of pinned signals, a report of a fault, raw values, a second run.
import { dialog, el, seconds, shown } from "./dom.js";
import { colours } from "./legend.js";

/** Shows a text to copy, which works without a clipboard too. */
const copied = (title, text) => {
  const area = el("textarea", { rows: 16, readonly: true, "aria-label": title });
  area.value = text;
  const copy = () => {
    area.select();
    document.execCommand("copy");
  };
  dialog(title, area, el("p", {}, el("button", { onclick: copy }, "copy")));
  area.focus();
  area.select();
};

/** Shows keys, colours and marks. @param {{key: string, text: string}[]} keys */
export const help = (keys) => {
  const rows = keys.flatMap(({ key, text }) => [el("dt", {}, el("kbd", {}, key)), el("dd", {}, text)]);
  dialog("Keys, colours and marks", el("div", { class: "guide" }, el("dl", { class: "help" }, ...rows), el("section", {}, ...colours())));
};

/** Saves the pinned signals, or those that are shown, as a table with one row for each time of a change. */
export const csv = (run, timeline) => {
  const tracks = timeline.rows.filter((row) => row.curve).map((row) => row.curve), cell = (value) => `"${String(value).replaceAll("\"", "\"\"")}"`;
  const named = (track, k) => `${track.agent} ${track.name || track.topic}${track.width > 1 ? `[${k}]` : ""}`;
  const names = tracks.flatMap((track) => Array.from({ length: track.width || 1 }, (_, k) => named(track, k)));
  const times = [...new Set(tracks.flatMap((track) => Array.from(track.t)))].sort((a, b) => a - b).filter((t) => t >= timeline.from && t <= timeline.to);
  const cells = (track, t) => (track.width ? Array.from(track.at(t) ?? Array(track.width).fill("")) : [track.at(t) ?? ""]);
  const rows = times.map((t) => [t.toFixed(3), ...tracks.flatMap((track) => cells(track, t))].join(","));
  const text = [["t [s]", ...names].map(cell).join(","), ...rows, ""].join("\n"), url = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  el("a", { href: url, download: `${run.header.scenario}-${run.header.seed}.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
  return text;
};

/** What a person needs to look into a fault: command, versions, time, selected thing, and the lines before. */
export const report = (run, cursor, said) => {
  const { header } = run, { t, agent, selected } = cursor, outcome = run.outcome(agent);
  const versions = Object.entries(header.versions ?? {}).map(([name, v]) => `${name} ${v}`);
  const lines = run.log.filter(([at, who, level]) => level > 1 && at <= t + 1e-3 && (!who || who === agent)).slice(-12);
  copied("Report of a fault", [
    `${header.scenario}, seed ${header.seed}: ${agent} ${outcome ? `${outcome.outcome}${outcome.reason ? `: ${outcome.reason}` : ""}` : "without an outcome"}`,
    `again: ${header.command}`, `versions: ${versions.join(", ")}`, `content: ${header.content_hash}`,
    `at ${seconds(t)}, selected: ${selected.replaceAll("\n", " ") || "nothing"}`, said, "", ...lines.map(([at, , , text]) => `${at.toFixed(2)}  ${text}`),
  ].filter((line) => line !== undefined && line !== null).join("\n"));
};

/** Shows a line of the log with the whole value of its track. */
export const raw = (run, [t, agent, level, text, about]) => {
  const track = run.tracks.get(about), value = track ? track.at(t) : null;
  copied("Event", JSON.stringify({ t, agent, level, text, about, value: ArrayBuffer.isView(value) ? Array.from(/** @type {any} */ (value)) : value }, null, 2));
};

/** Lets a reader choose the report of a second run on the disk; calls back with its text. */
export const chosen = (take) => {
  const input = el("input", { type: "file", accept: ".html" });
  input.addEventListener("change", async () => {
    const data = (await input.files[0].text()).match(/id="data">([^<]*)</)?.[1];
    if (data) take(data); else dialog("No report", el("p", {}, `${shown(input.files[0].name)} has no data of a run: choose the report.html of another run.`));
  });
  input.click();
};
