"use strict";
(() => {
  const run = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);
  const picture = find("picture"), strip = find("strip"), slider = find("slider"), clock = find("time");
  const play = find("play"), pace = find("pace");
  let now = run.start, playing = false, last = 0;

  // Index of the last time that is not later; -1 before the first.
  const before = (rows, t, key) => {
    let low = 0, high = rows.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (key(rows[middle]) <= t + 1e-6) low = middle + 1; else high = middle;
    }
    return low - 1;
  };
  const itself = (row) => row, first = (row) => row[0];
  const routeAt = (agent, t) => {
    const i = before(agent.routes, t, (r) => r[1]);
    return i < 0 ? "idle" : agent.routes[i][0];
  };
  const turn = (from, to) => Math.atan2(Math.sin(to - from), Math.cos(to - from));
  const poseAt = (body, t) => {
    const n = body.t.length, i = Math.max(0, before(body.t, t, itself)), j = Math.min(i + 1, n - 1);
    const part = j > i ? Math.min(1, Math.max(0, (t - body.t[i]) / (body.t[j] - body.t[i]))) : 0;
    return {
      i, x: body.x[i] + part * (body.x[j] - body.x[i]), y: body.y[i] + part * (body.y[j] - body.y[i]),
      yaw: body.yaw[i] + part * turn(body.yaw[i], body.yaw[j]), z: body.z?.[i], tilt: body.tilt?.[i],
    };
  };

  const arena = makeArena(picture), { g, X, Y } = arena;
  const fit = () => {
    arena.fit(run.bounds);
    const dpr = window.devicePixelRatio || 1;
    strip.width = strip.clientWidth * dpr; strip.height = strip.clientHeight * dpr;
  };
  const drawScans = (agent, body) => {
    for (const { fan, t, ranges } of agent.scans) {
      const i = before(t, now, itself);
      if (i >= 0) arena.drawScan(fan, ranges[i], poseAt(body, t[i]));  // from the pose at the time of the scan
    }
  };
  const drawBeams = (agent, pose) => {
    for (const set of agent.beams) {
      const i = before(set.t, now, itself);
      if (i >= 0) arena.drawBeams(set.beams, set.ranges[i], pose);
    }
  };
  const stretch = (body, from, to, style, thick) => {
    if (to < from) return;
    const a = poseAt(body, from), z = poseAt(body, to), points = [[a.x, a.y]];
    for (let i = a.i + 1; i <= z.i; i++) points.push([body.x[i], body.y[i]]);
    arena.drawLine([...points, [z.x, z.y]], style, thick);
  };
  const drawTrail = (body, agent) => {
    if (!agent) { stretch(body, body.t[0], now, color("other"), 1.2); return; }
    const end = run.end;
    g.globalAlpha = 0.22; stretch(body, body.t[0], end, color("muted"), 1.2); g.globalAlpha = 1;
    for (const [name, from, to] of agent.routes) if (from <= now) stretch(body, from, Math.min(to, now), color(name), 2.4);
    for (const [t, , route] of agent.atomic) {
      if (t > now) break;
      const p = poseAt(body, t);
      g.fillStyle = color(route); g.beginPath(); g.arc(X(p.x), Y(p.y), 2.4, 0, 7); g.fill();
    }
    g.lineWidth = 1.8;
    for (const t of agent.switches) {
      if (t > now) break;
      const p = poseAt(body, t);
      g.strokeStyle = color(routeAt(agent, t)); g.strokeRect(X(p.x) - 5.5, Y(p.y) - 5.5, 11, 11);
    }
  };
  const drawPicture = () => {
    const agents = Object.fromEntries(run.agents.map((a) => [a.name, a]));
    arena.drawWorld(run);
    for (const body of run.bodies) drawTrail(body, agents[body.name]);
    for (const body of run.bodies) {
      const pose = poseAt(body, now), agent = agents[body.name];
      if (agent) { drawScans(agent, body); drawBeams(agent, pose); }
      arena.drawBody(body.hull, body.name, pose, agent ? color(routeAt(agent, now)) : color("other"));
    }
  };
  const drawStrip = () => {
    const g = strip.getContext("2d"), span = Math.max(run.end - run.start, 1e-9), rows = run.agents.length || 1;
    g.clearRect(0, 0, strip.width, strip.height);
    g.fillStyle = color("line"); g.fillRect(0, 0, strip.width, strip.height);
    run.agents.forEach((agent, row) => {
      for (const [name, from, to] of agent.routes) {
        g.fillStyle = color(name);
        g.fillRect((from - run.start) / span * strip.width, row * strip.height / rows, (to - from) / span * strip.width, strip.height / rows);
      }
    });
  };

  // State of each agent, beside the animation.
  const states = run.agents.map((agent) => {
    const box = document.createElement("div"), title = document.createElement("h3"), route = document.createElement("span");
    const list = document.createElement("dl"), cells = {};
    box.className = "state"; title.append(agent.name, route); box.append(title, list);
    for (const name of ["node", "action", "rule", "motion", "pose"]) {
      const term = document.createElement("dt");
      term.textContent = name; cells[name] = document.createElement("dd"); cells[name].dataset.is = name;
      list.append(term, cells[name]);
    }
    find("states").append(box);
    return { agent, route, cells, nodes: [...document.querySelectorAll(`.tree li`)].filter((e) => e.dataset.agent === agent.name) };
  });
  const latest = (rows, key) => {
    const found = new Map();
    for (const row of rows) { if (row[0] > now + 1e-6) break; found.set(key(row), row); }
    return found;
  };
  const showState = ({ agent, route, cells, nodes }) => {
    const name = routeAt(agent, now), body = run.bodies.find((b) => b.name === agent.name);
    route.textContent = name; route.style.setProperty("--c", color(name));
    const leaves = new Map(agent.leaves), statuses = latest(agent.tree, (r) => r[1]);
    const running = [...statuses.values()].filter((r) => r[2] === "RUNNING" && leaves.has(r[1])).map((r) => r[1]);
    for (const node of nodes) node.classList.toggle("now", running.includes(node.dataset.node));
    const open = [...latest(agent.tickets, (r) => r[1]).values()].filter((r) => r[3] === "RUNNING");
    const waits = before(agent.waits, now, first);  // where the mission waits and what for, unless an action runs
    const waiting = open.length || waits < 0 ? "" : agent.waits[waits][1];
    cells.node.textContent = waiting || running.map((p) => leaves.get(p)).join(", ") || "–";
    cells.action.textContent = open.map((r) => r[2]).join(", ") || "–";
    const active = [...latest(agent.rules, (r) => r[1]).values()].filter((r) => r[2] !== "ended" && r[2] !== "released");
    cells.rule.textContent = active.map((r) => r[1].split("/").pop() + (r[3] ? ": " + r[3] : "")).join("; ") || "–";
    const i = before(agent.motion, now, first), values = i < 0 ? [] : agent.motion[i].slice(1).map((v) => v.toFixed(2));
    const twist = agent.axes.length === values.length ? values.map((v, k) => agent.axes[k] + " " + v).join(", ") : "";
    cells.motion.textContent = i < 0 ? "–" : twist || values.join(" / ") + " m/s";
    const pose = body && poseAt(body, now);
    cells.pose.textContent = pose ? `${pose.x.toFixed(2)}, ${pose.y.toFixed(2)} m, ${(pose.yaw * 180 / Math.PI).toFixed(0)}°` : "–";
  };

  const show = (t) => {
    now = Math.min(run.end, Math.max(run.start, t));
    slider.value = now;
    clock.textContent = now.toFixed(2);
    drawPicture();
    states.forEach(showState);
  };
  const frame = (stamp) => {
    if (!playing) return;
    const step = last ? (stamp - last) / 1000 * Number(pace.value) : 0;
    last = stamp;
    show(now + step);
    if (now >= run.end) setPlaying(false); else requestAnimationFrame(frame);
  };
  const setPlaying = (on) => {
    playing = on; last = 0;
    play.textContent = on ? "❚❚" : "▶";
    if (on) { if (now >= run.end - 1e-6) show(run.start); requestAnimationFrame(frame); }
  };
  const redraw = () => { fit(); drawStrip(); show(now); };

  slider.min = run.start; slider.max = run.end; slider.step = "any";
  slider.addEventListener("input", () => { setPlaying(false); show(Number(slider.value)); });
  play.addEventListener("click", () => setPlaying(!playing));
  document.addEventListener("keydown", (event) => {
    if (/^(SELECT|BUTTON|SUMMARY)$/.test(event.target.tagName)) return;
    if (event.key === " ") { event.preventDefault(); setPlaying(!playing); }
    if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
      event.preventDefault(); setPlaying(false); show(now + (event.key === "ArrowRight" ? 0.1 : -0.1));
    }
  });
  for (const button of document.querySelectorAll("button.t")) {
    button.addEventListener("click", () => {
      setPlaying(false); show(Number(button.dataset.t));
      find("run").scrollIntoView({ behavior: "smooth" });
    });
  }
  window.addEventListener("resize", redraw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  window.addEventListener("beforeprint", redraw);
  // Initially the whole path is shown.
  now = run.end;
  redraw();
})();
