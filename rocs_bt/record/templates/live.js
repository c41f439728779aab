(() => {
  const find = (id) => document.getElementById(id);
  const link = find("link"), title = find("title"), arena = makeArena(find("picture"));
  const SPAN = 30, LINES = 60;  // seconds of a signal's history; lines of knowledge changes
  let run = null, t = 0, bodies = {}, agents = {}, due = false;

  const cell = (tag, text, name) => {
    const made = document.createElement(tag);
    made.textContent = text; if (name) made.className = name;
    return made;
  };
  const short = (v) => (typeof v !== "number" ? String(v) : Math.abs(v) >= 1000 ? v.toFixed(0) : String(Number(v.toPrecision(3))));
  const bounds = () => {
    const xs = [], ys = [];
    for (const o of [...run.outlines, ...(run.grounds || [])]) for (const [x, y] of o.points) { const r = o.radius || 0; xs.push(x - r, x + r); ys.push(y - r, y + r); }
    for (const b of Object.values(bodies)) for (const [x, y] of b.trail) { xs.push(x); ys.push(y); }
    return xs.length ? [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)] : [-1, -1, 1, 1];
  };

  // One agent: its state, and the elements that show it.
  const makeAgent = (info, number) => {
    const box = find("agent").content.cloneNode(true).firstElementChild, parts = {};
    for (const part of box.querySelectorAll("[data-is]")) parts[part.dataset.is] = part;
    parts.rows.id = "rows-" + number;
    box.dataset.agent = parts.name.textContent = info.name;
    parts.who.textContent = `${info.robot}, mission ${info.mission}${info.rules?.length ? ", reflexes " + info.rules.join(", ") : ""}`;
    find("agents").append(box);
    const state = document.createElement("div"), route = document.createElement("span"), list = document.createElement("dl"), cells = {};
    state.className = "state";
    const head = cell("h3", info.name); head.append(route); state.append(head, list);
    for (const name of ["node", "action", "rule", "pose"]) {
      cells[name] = document.createElement("dd"); cells[name].dataset.is = name;
      list.append(cell("dt", name), cells[name]);
    }
    find("states").append(state);
    const declared = Object.fromEntries((info.signals || []).map((s) => [s.name, s]));
    const body = run.bodies.find((b) => b.name === info.name);
    const beams = Object.fromEntries(Object.entries(body?.beams || {}).map(
      ([sensor, of]) => [sensor, of.map((b) => [b.x, b.y, b.yaw, b.reach, b.cone || 0, b.elevation || 0])]));
    const fans = Object.fromEntries(Object.entries(body?.fans || {}).map(
      ([sensor, f]) => [sensor, [f.x, f.y, f.yaw, f.step, f.reach]]));
    return {
      info, parts, route, cells, declared, beams, fans, tree: makeTree(parts.map, parts.rows, parts.follow),
      nodes: {}, signals: {}, past: {}, rules: {}, ranges: {}, tickets: {}, outcome: null, activeRoute: "idle", lines: {}, fresh: new Set(),
    };
  };
  const takeAgent = (agent, delta) => {
    if (delta.tree) {
      const paths = new Set(delta.tree.map((n) => n.path));
      agent.tree.set(delta.tree);
      for (const path of Object.keys(agent.nodes)) if (!paths.has(path)) delete agent.nodes[path];
      agent.parts.count.textContent = delta.tree.length === 1 ? "1 node" : delta.tree.length + " nodes";
    }
    if (delta.swapped) for (const path of Object.keys(agent.nodes)) if (path === delta.swapped || path.startsWith(delta.swapped + "/")) delete agent.nodes[path];
    if (delta.nodes || delta.tree) { Object.assign(agent.nodes, delta.nodes); agent.tree.setStatuses(agent.nodes); }
    for (const [name, values] of Object.entries(delta.signals || {})) {
      agent.signals[name] = values; agent.fresh.add(name);
      const past = (agent.past[name] ||= []);
      past.push([t, values[0]]);
      while (past.length && past[0][0] < t - SPAN) past.shift();
    }
    Object.assign(agent.rules, delta.rules); Object.assign(agent.ranges, delta.ranges);
    for (const [number, ticket] of Object.entries(delta.tickets || {})) {
      if (ticket[1] === "QUEUED" || ticket[1] === "RUNNING") agent.tickets[number] = ticket; else delete agent.tickets[number];
    }
    if (delta.route) agent.activeRoute = delta.route;
    if (delta.outcome) agent.outcome = delta.outcome;
    if (delta.rules) drawRules(agent);
    const { knowledge, faults } = agent.parts;
    for (const [at, what, subject, name, value] of delta.knowledge || []) {
      const line = document.createElement("li");
      line.append(cell("time", at.toFixed(2) + " s"), " ", fact(what, subject, name, value));
      knowledge.prepend(line);
    }
    while (knowledge.children.length > LINES) knowledge.lastElementChild.remove();
    for (const [at, text] of delta.faults || []) { faults.hidden = false; faults.append(cell("li", `${at.toFixed(2)} s  ${text}`)); }
  };
  const fact = (what, subject, name, value) => {
    const line = document.createElement("span"), shown = Array.isArray(value) ? value.map(short).join(", ") : short(value);
    line.append(cell("b", subject), " ");
    if (what === "attribute") line.append(`${name} = ${shown}`);
    else if (what.startsWith("edge")) line.append(`${name} ${shown}`, cell("span", ` (${what})`, "small"));
    else line.append(cell("span", `${what}, a ${name}`, "small"));
    return line;
  };

  const drawRules = (agent) => {
    const rules = Object.entries(agent.rules), { rules: table, norules } = agent.parts;
    table.hidden = !rules.length; norules.hidden = !!rules.length;
    table.tBodies[0].replaceChildren(...rules.map(([name, rule]) => {
      const row = document.createElement("tr"), first = document.createElement("td");
      first.append(cell("b", name.split("/").pop()), cell("span", rule.reading, "small reading"));
      const lamp = (on, yes, no) => { const made = cell("td", ""); made.append(cell("span", "", on ? "lamp on" : "lamp"), on ? yes : no); return made; };
      row.dataset.rule = name;
      row.append(first, lamp(rule.latched, "latched", "open"), lamp(rule.active, "acts", "rests"), cell("td", rule.refirings ? `${rule.fired} (+${rule.refirings})` : rule.fired, "n"));
      return row;
    }));
  };
  const spark = (canvas, past, values) => {
    const dpr = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight, g = canvas.getContext("2d");
    canvas.width = width * dpr; canvas.height = height * dpr; g.setTransform(dpr, 0, 0, dpr, 0, 0);
    g.strokeStyle = g.fillStyle = color("reactive"); g.lineWidth = 1.3;
    if (values.length > 3) {
      const top = Math.max(...values.filter((v) => typeof v === "number"), 1e-9), wide = width / values.length;
      values.forEach((v, i) => { const h = typeof v === "number" ? Math.max(1, v / top * height) : 0; g.fillRect(i * wide, height - h, Math.max(1, wide - 1), h); });
      return;
    }
    const numbers = past.map((p) => p[1]).filter((v) => typeof v === "number");
    const low = Math.min(...numbers), span = Math.max(Math.max(...numbers) - low, 1e-9);
    let open = false;
    g.beginPath();
    for (const [at, v] of past) {
      if (typeof v !== "number") { open = false; continue; }
      const x = width * (1 - (t - at) / SPAN), y = height - 2 - (v - low) / span * (height - 4);
      if (open) g.lineTo(x, y); else g.moveTo(x, y);
      open = true;
    }
    g.stroke();
  };
  const drawSignals = (agent) => {
    for (const name of agent.fresh) {
      let line = agent.lines[name];
      if (!line) {
        const row = agent.parts.signals.tBodies[0].insertRow();
        row.dataset.signal = name;
        row.append(cell("td", name), cell("td", "", "v"), cell("td", ""));
        const canvas = document.createElement("canvas");
        row.cells[2].append(canvas); line = agent.lines[name] = { value: row.cells[1], canvas };
      }
      const values = agent.signals[name], units = agent.declared[name]?.units || [], numbers = values.filter((v) => typeof v === "number");
      line.value.textContent = values.length > 3
        ? `min ${numbers.length ? short(Math.min(...numbers)) : values[0]} ${units[0] || ""} of ${values.length}`
        : values.map((v, i) => short(v) + (units[i] && units[i] !== units[i + 1] ? " " + units[i] : "")).join(", ");
      spark(line.canvas, agent.past[name], values);
    }
    agent.fresh.clear();
  };
  const drawState = (agent) => {
    const { cells, route } = agent, { pose, spatial } = bodies[agent.info.name] || {};
    route.textContent = agent.activeRoute; route.style.setProperty("--c", color(agent.activeRoute));
    const nodes = agent.tree.running();
    cells.node.textContent = nodes.slice(0, 3).join(", ") + (nodes.length > 3 ? ` and ${nodes.length - 3} more` : "") || "–";
    cells.action.textContent = Object.values(agent.tickets).filter((k) => k[1] === "RUNNING").map((k) => k[0]).join(", ") || "–";
    cells.rule.textContent = Object.entries(agent.rules).filter(([, r]) => r.active || r.latched).map(([n, r]) => n.split("/").pop() + (r.reading ? ": " + r.reading : "")).join("; ") || "–";
    const space = spatial ? `, ${spatial[0].toFixed(2)} m high, tilt ${(spatial[1] * 180 / Math.PI).toFixed(0)}°` : "";
    cells.pose.textContent = pose ? `${pose[0].toFixed(2)}, ${pose[1].toFixed(2)} m, ${(pose[2] * 180 / Math.PI).toFixed(0)}°${space}` : "–";
  };
  const drawTrail = (trail, agent) => {
    let from = 0;
    for (let i = 1; i <= trail.length; i++) {
      if (i < trail.length && trail[i][2] === trail[from][2]) continue;
      arena.drawLine(trail.slice(from, i + 1), color(agent ? trail[from][2] || "idle" : "other"), agent ? 2.4 : 1.2);
      from = i;
    }
  };
  const drawPicture = () => {
    arena.drawWorld(run);
    for (const [name, body] of Object.entries(bodies)) drawTrail(body.trail, agents[name]);
    for (const info of run.bodies) {
      const body = bodies[info.name], agent = agents[info.name];
      if (!body?.pose) continue;
      const [x, y, yaw] = body.pose, [z, tilt] = body.spatial || [], [low, high] = body.heights || [];
      const pose = { x, y, yaw, z: high - low > 0.1 ? z : undefined, tilt };  // the height of bodies that climb
      for (const [sensor, beams] of Object.entries(agent?.beams || {})) if (agent.ranges[sensor]) arena.drawBeams(beams, agent.ranges[sensor], pose);
      for (const [sensor, fan] of Object.entries(agent?.fans || {})) if (agent.ranges[sensor]) arena.drawScan(fan, agent.ranges[sensor], pose);
      arena.drawBody(info.hull, info.name, pose, color(agent ? agent.activeRoute : "other"));
    }
  };
  const verdict = ({ info, outcome }) => (outcome ? `${info.name}: ${outcome[0]}${outcome[1] ? ", " + outcome[1] : ""}` : `${info.name} is running`);
  const setBadge = (word, name) => { link.textContent = word; link.className = "badge " + name; };
  const ended = () => run !== null && Object.values(agents).every((a) => a.outcome);
  const draw = () => {
    due = false;
    if (run === null) return;
    find("time").textContent = t.toFixed(2);
    title.textContent = Object.values(agents).map(verdict).join("; ") || run.scenario;
    if (ended()) {
      const good = Object.values(agents).every((a) => a.outcome[0] === "success");
      setBadge("ended", good ? "success" : "failed");
    } else setBadge("live", "live");
    drawPicture();
    for (const agent of Object.values(agents)) { agent.tree.draw(); drawSignals(agent); drawState(agent); }
  };

  const take = (delta) => {
    t = delta.t ?? 0;
    for (const [name, part] of Object.entries(delta.bodies || {})) {
      const body = (bodies[name] ||= { trail: [], pose: null });
      if (part.pose) body.pose = part.pose;
      if (part.spatial) {
        const [z] = body.spatial = part.spatial, [low, high] = body.heights || [z, z];
        body.heights = [Math.min(low, z), Math.max(high, z)];
      }
      for (const point of part.trail || []) body.trail.push(point);
    }
    for (const [name, part] of Object.entries(delta.agents || {})) if (agents[name]) takeAgent(agents[name], part);
    if (!due) { due = true; requestAnimationFrame(draw); }
  };
  const begin = (whole) => {
    run = whole.run; bodies = {}; agents = {};
    find("states").replaceChildren(); find("agents").replaceChildren();
    if (!run) return;
    run.outlines = (run.outlines || []).map((o) => ({ ...o, radius: o.radius || 0 }));
    run.places = (run.places || []).map((p) => ({ ...p, radius: p.radius || 0 }));
    find("run").hidden = false;
    find("what").textContent = `rocs_bt · ${run.scenario} · seed ${run.seed} · ${run.mode}`;
    document.title = `${run.scenario}-${run.seed} live · rocs_bt`;
    run.agents.forEach((info, i) => { agents[info.name] = makeAgent(info, i); });
    take(whole);
    arena.fit(bounds());
  };
  const source = new EventSource("events");
  source.addEventListener("whole", (event) => begin(JSON.parse(event.data)));
  source.addEventListener("message", (event) => take(JSON.parse(event.data)));
  source.addEventListener("error", () => {
    if (ended()) source.close();
    else setBadge("no connection", "failed");
  });
  const redraw = () => { if (run) { arena.fit(bounds()); Object.values(agents).forEach((a) => { a.tree.resize(); Object.keys(a.signals).forEach((s) => a.fresh.add(s)); }); draw(); } };
  window.addEventListener("resize", redraw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
})();
