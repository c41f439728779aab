"use strict";
// Arena from above on a canvas, in the colours of the page.
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const makeArena = (picture) => {
  const g = picture.getContext("2d");
  let scale = 1, left = 0, top = 0, width = 0, height = 0, labels = [];
  const X = (x) => left + x * scale, Y = (y) => top - y * scale;
  const fit = ([x0, y0, x1, y1]) => {
    const dpr = window.devicePixelRatio || 1, pad = 18;
    width = Math.max(picture.parentElement.clientWidth, 3 * pad);  // a page that is not laid out yet has no width
    // The controls below the picture stay on the first screen, unless little of the picture would be left.
    const above = picture.getBoundingClientRect().top + window.scrollY, screen = Math.max(window.innerHeight, 480);
    height = Math.min(width * (y1 - y0) / (x1 - x0), Math.max(screen - above - 72, 0.5 * screen));
    picture.style.height = height + "px";
    picture.width = width * dpr; picture.height = height * dpr;
    g.setTransform(dpr, 0, 0, dpr, 0, 0);
    scale = Math.min((width - 2 * pad) / (x1 - x0), (height - 2 * pad) / (y1 - y0));
    left = width / 2 - scale * (x0 + x1) / 2;
    top = height / 2 + scale * (y0 + y1) / 2;
  };
  const outline = (points) => {
    g.beginPath();
    points.forEach(([x, y], i) => (i ? g.lineTo(X(x), Y(y)) : g.moveTo(X(x), Y(y))));
    g.closePath();
  };
  const placed = (pose, [x, y]) => [
    pose.x + Math.cos(pose.yaw) * x - Math.sin(pose.yaw) * y, pose.y + Math.sin(pose.yaw) * x + Math.cos(pose.yaw) * y,
  ];
  const high = (h) => (h < 1 ? `${+(100 * h).toPrecision(3)} cm` : `${+h.toPrecision(3)} m`);  // as in figures/arena.py
  // A label right of and below a point: left of it at the frame, and lower if it would cover another one.
  const write = (text, x, y, gap = 4, line = 13) => {
    const wide = g.measureText(text).width;
    const at = Math.max(4, x + gap + wide > width - 4 ? x - gap - wide : x + gap);
    const covers = (b) => at < b.x + b.wide && b.x < at + wide && Math.abs(b.y - y) < line;
    for (let i = 0; i < 4 && labels.some(covers); i++) y += line;
    y = Math.min(Math.max(y, line), height - 4);
    labels.push({ x: at, y, wide });
    g.fillText(text, at, y);
  };
  const drawWorld = ({ outlines, places, grounds = [] }) => {
    g.clearRect(0, 0, width, height); labels = [];
    g.lineWidth = 1; g.fillStyle = g.strokeStyle = color("muted"); g.setLineDash([4, 4]);
    g.font = "11px " + getComputedStyle(document.body).fontFamily;
    for (const o of grounds) {
      outline(o.points); g.stroke();
      g.globalAlpha = 0.12; g.fill(); g.globalAlpha = 1;
      const x = Math.min(...o.points.map((p) => p[0])), y = Math.max(...o.points.map((p) => p[1]));
      write(`${o.name}, ${high(o.height)}`, X(x), Y(y) + 13);
    }
    g.setLineDash([]);
    g.lineWidth = 1; g.fillStyle = color("wall"); g.strokeStyle = color("muted");
    for (const o of outlines) {
      if (o.radius > 0) { g.beginPath(); g.arc(X(o.points[0][0]), Y(o.points[0][1]), o.radius * scale, 0, 7); }
      else outline(o.points);
      g.fill(); g.stroke();
    }
    g.strokeStyle = g.fillStyle = color("place"); g.lineWidth = 1.5;
    g.font = "13px " + getComputedStyle(document.body).fontFamily;
    for (const p of places) {
      const r = Math.max(p.radius * scale, 5);
      g.beginPath(); g.arc(X(p.x), Y(p.y), r, 0, 7); g.stroke();
      g.beginPath(); g.moveTo(X(p.x) - 4, Y(p.y)); g.lineTo(X(p.x) + 4, Y(p.y)); g.moveTo(X(p.x), Y(p.y) - 4); g.lineTo(X(p.x), Y(p.y) + 4); g.stroke();
      if (p.known !== false) write(p.name, X(p.x), Y(p.y) + r + 10, r + 4);
    }
  };
  // Each beam is [x, y, yaw, reach, cone, elevation]; an echo is a range [m], null for no echo, -1 for an invalid value.
  // A beam is projected on the plane; one that is steeper than 60 degrees, such as downward, is not drawn.
  const drawBeams = (beams, echoes, pose) => {
    beams.forEach(([bx, by, yaw, reach, cone, elevation], k) => {
      const echo = echoes[k], flat = Math.cos(elevation);
      if (echo === -1 || flat < 0.5) return;
      const [x, y] = placed(pose, [bx, by]), angle = pose.yaw + yaw, r = Math.min(echo ?? reach, reach) * flat * scale;
      g.globalAlpha = echo === null ? 0.09 : 0.55;
      g.fillStyle = g.strokeStyle = echo === null ? color("muted") : color("beam");
      g.beginPath(); g.moveTo(X(x), Y(y));
      if (cone > 0) { g.arc(X(x), Y(y), r, -angle - cone / 2, -angle + cone / 2); g.closePath(); g.fill(); }
      else { g.lineTo(X(x) + r * Math.cos(angle), Y(y) - r * Math.sin(angle)); g.stroke(); }
    });
    g.globalAlpha = 1;
  };
  // A scan's fan is [x, y, yaw of the first ray, step from ray to ray, reach]; its echoes are drawn as dots, with the free space before them.
  const drawScan = ([fx, fy, first, step, reach], echoes, pose) => {
    const eye = placed(pose, [fx, fy]);
    const ends = echoes.map((echo, k) => {
      const angle = pose.yaw + first + k * step, r = echo === -1 ? 0 : Math.min(echo ?? reach, reach);
      return [eye[0] + r * Math.cos(angle), eye[1] + r * Math.sin(angle)];
    });
    outline([eye, ...ends]);
    g.fillStyle = color("beam"); g.globalAlpha = 0.07; g.fill(); g.globalAlpha = 0.9;
    ends.forEach(([x, y], k) => { if (echoes[k] > 0) g.fillRect(X(x) - 1.3, Y(y) - 1.3, 2.6, 2.6); });
    g.globalAlpha = 1;
  };
  const drawLine = (points, style, thick) => {
    g.strokeStyle = style; g.lineWidth = thick; g.lineJoin = g.lineCap = "round";
    g.beginPath();
    points.forEach(([x, y], i) => (i ? g.lineTo(X(x), Y(y)) : g.moveTo(X(x), Y(y))));
    g.stroke();
  };
  const drawBody = (hull, name, pose, tint) => {
    if (hull.length) {
      outline(hull.map((p) => placed(pose, p)));
      g.fillStyle = color("paper"); g.globalAlpha = 0.85; g.fill(); g.globalAlpha = 1;
      g.strokeStyle = tint; g.lineWidth = 2; g.stroke();
    }
    const nose = hull.length ? Math.max(...hull.map((p) => p[0])) : 0.2;
    const size = Math.min(nose, 0.3), tip = nose * 0.85, back = tip - size * 0.5;
    outline([[tip, 0], [back, size * 0.3], [back, -size * 0.3]].map((p) => placed(pose, p)));
    g.fillStyle = tint; g.fill();
    g.fillStyle = color("ink"); g.font = "600 13px " + getComputedStyle(document.body).fontFamily;
    const space = (pose.z === undefined ? "" : `, ${pose.z.toFixed(2)} m high`) + (pose.tilt > 0.09 ? `, ${(pose.tilt * 180 / Math.PI).toFixed(0)}°` : "");
    write(name + space, X(pose.x), Y(pose.y) - 0.16 * scale - 2, 0.24 * scale + 4);
  };
  return { g, X, Y, fit, drawWorld, drawBeams, drawScan, drawLine, drawBody };
};
