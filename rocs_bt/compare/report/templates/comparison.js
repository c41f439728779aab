"use strict";
const data = JSON.parse(document.getElementById("data").textContent);

function save(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function cell(value) {
  const text = value === null ? "" : String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

const csv = (rows) => rows.map((row) => row.map(cell).join(",")).join("\n") + "\n";

const episodes = () => csv([data.columns, ...data.rows]);

const everything = () => JSON.stringify({
  episodes: data.rows.map((row) => Object.fromEntries(row.map((value, i) => [data.columns[i], value]))),
  verdicts: data.verdicts,
}, null, 1);

// A standalone SVG has no page styles, so write out its colours (light background).
function standalone(figure) {
  const svg = figure.querySelector("svg").cloneNode(true);
  svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  const style = getComputedStyle(document.documentElement);
  return svg.outerHTML.replace(/var\((--[\w-]+)\)/g, (_, name) => style.getPropertyValue(name).trim());
}

function tableCsv(table) {
  const text = (each) => each.textContent.trim().replace(/\s+/g, " ");  // includes collapsed rows
  return csv([...table.rows].map((row) => [...row.cells].map(text)));
}

for (const table of document.querySelectorAll("table[id]")) {
  const button = Object.assign(document.createElement("button"), { type: "button", className: "table-csv", textContent: "CSV" });
  button.addEventListener("click", () => save(`${table.id}.csv`, "text/csv", tableCsv(table)));
  table.closest("section").querySelector("h2").append(button);
}
for (const button of document.querySelectorAll("[data-save]")) {
  button.addEventListener("click", () => button.dataset.save === "csv"
    ? save("episodes.csv", "text/csv", episodes()) : save("comparison.json", "application/json", everything()));
}
for (const button of document.querySelectorAll("[data-svg]")) {
  const figure = document.getElementById(button.dataset.svg);
  button.addEventListener("click", () => save(`${figure.id}.svg`, "image/svg+xml", standalone(figure)));
}
for (const button of document.querySelectorAll("[data-copy]")) {
  button.addEventListener("click", async () => {
    try { await navigator.clipboard.writeText(button.dataset.copy); } catch { getSelection().selectAllChildren(button); }
    button.classList.add("copied");
    setTimeout(() => button.classList.remove("copied"), 900);
  });
}
