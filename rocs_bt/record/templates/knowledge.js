"use strict";
(() => {
  const run = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);
  const svg = document.querySelector("svg.knowledge"), slider = find("slider"), strip = find("strip"), play = find("play");
  const dots = [...svg.querySelectorAll("[data-n]")], lines = [...svg.querySelectorAll("[data-e]")];
  const NEW = 0.5; // [s] for which a node that changed is marked
  let now = run.end, at = 0, nodes = [], edges = [], chosen = null, playing = false, last = 0;

  // State at a time: changes are applied in order, and from the start when time goes back.
  const restart = () => { at = 0; nodes = run.nodes.map(() => null); edges = run.edges.map(() => null); };
  const apply = ([t, code, i, name, value]) => {
    if (code === 0) nodes[i] = { since: t, t, values: new Map() };
    else if (code === 1) nodes[i] = null;
    else if (code === 2) { if (nodes[i]) { nodes[i].t = t; nodes[i].values.set(name, [value, t]); } }
    else edges[i] = code === 3 ? { t, values: name } : null;
  };
  const advance = (t) => {
    if (at > 0 && run.changes[at - 1][0] > t + 1e-9) restart();
    while (at < run.changes.length && run.changes[at][0] <= t + 1e-9) apply(run.changes[at++]);
  };

  const text = (value) => {
    if (value === null || value === undefined) return "unknown";
    if (value === true || value === false) return value ? "yes" : "no";
    if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(4)));
    if (Array.isArray(value)) return "(" + value.map(text).join(", ") + ")";
    return typeof value === "object" ? value.float || value.int : String(value);
  };
  const make = (tag, inside = "", kind = "") => {
    const made = document.createElement(tag);
    made.append(inside);
    if (kind) made.className = kind;
    return made;
  };
  const button = (label, act) => {
    const made = make("button", label, "t");
    made.type = "button"; made.addEventListener("click", act);
    return made;
  };

  // Card of one node, beside the drawing.
  const rows = (list) => {
    const table = make("table"), body = make("tbody");
    for (const cells of list) { const row = make("tr"); row.append(...cells.map((c) => make("td", c))); body.append(row); }
    table.append(body);
    return table;
  };
  const showCard = () => {
    const card = find("card");
    if (chosen === null) return;
    const [name, kind] = run.nodes[chosen], held = nodes[chosen], title = make("h3", name);
    title.append(make("i", kind));
    card.replaceChildren(title);
    if (!held) { card.append(make("p", "Unknown at this time.")); return; }
    const units = run.units[kind] || {};
    const known = [...held.values].filter(([, [value]]) => value !== null);
    if (known.length) card.append(rows(known.map(([a, [value, t]]) => [a, `${text(value)} ${units[a] || ""}`, button(t.toFixed(2) + " s", () => show(t))])));
    for (const [label, mine, other] of [["outgoing relations", 0, 2], ["incoming relations", 2, 0]]) {
      const found = run.edges.map((edge, i) => [edge, i]).filter(([edge, i]) => edges[i] && edge[mine] === name);
      if (found.length) card.append(make("h4", label));
      for (const [edge, i] of found) {
        const line = make("p", edge[1] + " "), values = Object.entries(edges[i].values).map(([a, v]) => `${a} ${text(v)}`).join(", ");
        line.append(button(edge[other], () => choose(numbers.get(edge[other]))), values ? ` (${values})` : "");
        card.append(line);
      }
    }
  };
  const numbers = new Map(run.nodes.map(([name], i) => [name, i]));
  const choose = (i) => { chosen = i ?? null; draw(); };

  // The drawing.
  const shown = new Set([...document.querySelectorAll("[data-kind]")].map((box) => box.dataset.kind));
  const visible = (i) => nodes[i] && shown.has(run.nodes[i][1]);
  const draw = () => {
    const counts = new Map();
    let count = 0;
    dots.forEach((dot, i) => {
      const there = visible(i);
      if (nodes[i]) counts.set(run.nodes[i][1], (counts.get(run.nodes[i][1]) || 0) + 1);
      count += there ? 1 : 0;
      dot.classList.toggle("gone", !there);
      dot.classList.toggle("chosen", i === chosen);
      dot.classList.toggle("new", Boolean(there) && nodes[i].t > run.begin && now - nodes[i].t < NEW);
    });
    lines.forEach((line, i) => {
      const [source, , target] = run.edges[i], ends = [numbers.get(source), numbers.get(target)];
      line.classList.toggle("gone", !edges[i] || !ends.every(visible));
      line.classList.toggle("of", chosen !== null && ends.includes(chosen));
    });
    svg.dataset.count = count;
    for (const box of document.querySelectorAll("[data-kind]")) box.parentElement.querySelector("span").textContent = counts.get(box.dataset.kind) || 0;
    search();
    showCard();
  };
  const show = (t) => {
    now = Math.min(run.end, Math.max(run.begin, t));
    advance(now);
    slider.value = now;
    find("time").textContent = now.toFixed(2);
    draw();
  };

  const search = () => {
    const wanted = find("search").value.trim().toLowerCase(), hits = [];
    svg.classList.toggle("searching", wanted !== "");
    dots.forEach((dot, i) => {
      const fits = wanted !== "" && visible(i) && [run.nodes[i][0], run.nodes[i][1], ...[...nodes[i].values].map(([a, [v]]) => `${a} ${text(v)}`)]
        .some((part) => part.toLowerCase().includes(wanted));
      dot.classList.toggle("hit", Boolean(fits));
      if (fits) hits.push(i);
    });
    const result = find("hits");
    result.replaceChildren(wanted === "" ? "" : `${hits.length} of ${svg.dataset.count}: `);
    for (const i of hits.slice(0, 8)) result.append(button(run.nodes[i][0], () => choose(i)));
    return hits;
  };

  // Number of changes over time, under the slider.
  const drawStrip = () => {
    const dpr = window.devicePixelRatio || 1, g = strip.getContext("2d");
    const style = getComputedStyle(document.documentElement), bins = new Array(Math.max(1, Math.round(strip.clientWidth / 3))).fill(0);
    strip.width = strip.clientWidth * dpr; strip.height = strip.clientHeight * dpr;
    const span = Math.max(run.end - run.begin, 1e-9);
    for (const [t] of run.changes) if (t > run.begin) bins[Math.min(bins.length - 1, Math.floor((t - run.begin) / span * bins.length))] += 1;
    const most = Math.max(1, ...bins), wide = strip.width / bins.length;
    g.fillStyle = style.getPropertyValue("--line"); g.fillRect(0, 0, strip.width, strip.height);
    g.fillStyle = style.getPropertyValue("--reactive");
    bins.forEach((count, i) => { g.globalAlpha = count ? 0.25 + 0.75 * count / most : 0; g.fillRect(i * wide, 0, wide, strip.height); });
    g.globalAlpha = 1;
  };

  // Pan and zoom.
  const whole = svg.viewBox.baseVal, home = [whole.x, whole.y, whole.width, whole.height];
  let view = [...home], drag = null;
  const look = () => {
    svg.setAttribute("viewBox", view.join(" "));
    svg.classList.toggle("near", view[2] * view[3] / (home[2] * home[3]) * run.nodes.length < 60);
  };
  const scale = () => 1 / Math.min(svg.clientWidth / view[2], svg.clientHeight / view[3]);
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const factor = Math.exp(event.deltaY * 0.0015), box = svg.getBoundingClientRect(), s = scale();
    const x = view[0] + view[2] / 2 + (event.clientX - box.left - box.width / 2) * s;
    const y = view[1] + view[3] / 2 + (event.clientY - box.top - box.height / 2) * s;
    view = [x + (view[0] - x) * factor, y + (view[1] - y) * factor, view[2] * factor, view[3] * factor];
    look();
  }, { passive: false });
  svg.addEventListener("pointerdown", (event) => { drag = [event.clientX, event.clientY, ...view]; });
  window.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const s = scale();
    svg.classList.add("drag");
    view = [drag[2] - (event.clientX - drag[0]) * s, drag[3] - (event.clientY - drag[1]) * s, view[2], view[3]];
    look();
  });
  window.addEventListener("pointerup", () => { drag = null; svg.classList.remove("drag"); });
  find("whole").addEventListener("click", () => { view = [...home]; look(); });
  dots.forEach((dot, i) => dot.addEventListener("click", () => choose(i)));

  const setPlaying = (on) => {
    playing = on; last = 0;
    play.textContent = on ? "❚❚" : "▶";
    if (on) { if (now >= run.end - 1e-6) show(run.begin); requestAnimationFrame(frame); }
  };
  const frame = (stamp) => {
    if (!playing) return;
    const step = last ? (stamp - last) / 1000 * Math.max(1, (run.end - run.begin) / 30) : 0;
    last = stamp;
    show(now + step);
    if (now >= run.end) setPlaying(false); else requestAnimationFrame(frame);
  };
  slider.min = run.begin; slider.max = Math.max(run.end, run.begin + 1e-6);
  slider.addEventListener("input", () => { setPlaying(false); show(Number(slider.value)); });
  play.addEventListener("click", () => setPlaying(!playing));
  find("search").addEventListener("input", search);
  find("search").addEventListener("keydown", (event) => { if (event.key === "Enter") { const [first] = search(); if (first !== undefined) choose(first); } });
  for (const box of document.querySelectorAll("[data-kind]")) {
    box.addEventListener("change", () => { if (box.checked) shown.add(box.dataset.kind); else shown.delete(box.dataset.kind); draw(); });
  }
  for (const made of document.querySelectorAll("button.t[data-t]")) {
    made.addEventListener("click", () => { setPlaying(false); show(Number(made.dataset.t)); find("run").scrollIntoView({ behavior: "smooth" }); });
  }
  for (const made of document.querySelectorAll("button.node-link")) {
    made.addEventListener("click", () => { choose(numbers.get(made.dataset.name)); find("run").scrollIntoView({ behavior: "smooth" }); });
  }
  document.addEventListener("keydown", (event) => {
    if (/^(INPUT|SELECT|BUTTON|SUMMARY)$/.test(event.target.tagName)) return;
    if (event.key === " ") { event.preventDefault(); setPlaying(!playing); }
    if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
      event.preventDefault(); setPlaying(false); show(now + (event.key === "ArrowRight" ? 1 : -1) * (run.end - run.begin) / 200);
    }
  });
  window.addEventListener("resize", drawStrip);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawStrip);
  restart();
  drawStrip();
  show(run.end);
})();
