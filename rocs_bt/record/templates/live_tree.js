// Tree of a mission: a map of all nodes, and rows, of which only the visible ones are drawn.
const HEIGHT = 28, FEW = 24;  // height of a row [px]; number of nodes up to which no map is shown
const makeTree = (map, rows, follow) => {
  const sheet = rows.firstElementChild, folded = new Set();
  let nodes = [], by = new Map(), shown = [], statuses = {}, at = null, deepest = 0, leaves = 1, stale = true;

  const set = (tree) => {
    const raw = new Map(tree.map((n) => [n.path, n]));
    nodes = []; by = new Map(); deepest = 0; leaves = 0;
    const todo = tree.length ? [[tree[0], 0, null]] : [];
    while (todo.length) {
      const [n, depth, parent] = todo.pop();
      const cut = parent === null ? n.path : n.path.slice(parent.path.length + 1);
      const node = { path: n.path, name: cut, ports: n.ports || "", type: n.type, depth, parent, children: n.children.length, first: leaves, last: leaves };
      nodes.push(node); by.set(n.path, node); deepest = Math.max(deepest, depth);
      if (!node.children) leaves += 1;
      for (const child of [...n.children].reverse()) if (raw.has(child)) todo.push([raw.get(child), depth + 1, node]);
    }
    for (const node of nodes) if (!node.children) for (let up = node; up; up = up.parent) up.last = Math.max(up.last, node.first + 1);
    at = nodes[0] || null;
    lay();
  };
  const lay = () => {
    shown = [];
    let under = Infinity;
    for (const node of nodes) {
      if (node.depth > under) continue;
      under = folded.has(node.path) ? node.depth : Infinity;
      shown.push(node);
    }
    sheet.style.height = shown.length * HEIGHT + "px";
    stale = true;
  };
  const of = (node) => (statuses[node.path] ? statuses[node.path][0] : "INVALID");

  const drawRow = (node, i) => {
    const row = document.createElement("div"), status = document.createElement("span"), name = document.createElement("b");
    const entry = statuses[node.path];
    row.className = `row ${of(node)}${node === at ? " at" : ""}${node.children ? "" : " leaf"}`;
    row.style.top = i * HEIGHT + "px";
    row.id = rows.id + "-" + i;
    row.setAttribute("role", "treeitem"); row.setAttribute("aria-level", node.depth + 1);
    row.dataset.node = node.path;
    status.className = "status " + of(node); status.textContent = of(node) === "INVALID" ? "idle" : of(node);
    const space = document.createElement("span");
    space.style.paddingLeft = Math.min(node.depth, 24) * 1.1 + "em";
    row.append(status, space);
    if (node.children) {
      const fold = document.createElement("button"), open = !folded.has(node.path);
      fold.type = "button"; fold.tabIndex = -1; fold.textContent = open ? "▾" : "▸"; fold.setAttribute("aria-hidden", "true");
      fold.addEventListener("click", () => toggle(node, !open));
      row.setAttribute("aria-expanded", open); row.append(fold);
    }
    name.textContent = node.name; row.append(name);
    if (node.ports) { const text = document.createElement("span"); text.className = "ports"; text.textContent = node.ports; row.append(text); }
    const type = document.createElement("i");
    type.textContent = " " + node.type; row.append(type);
    if (entry && entry[1]) { const text = document.createElement("span"); text.className = "feedback"; text.textContent = "  " + entry[1]; row.append(text); }
    row.addEventListener("click", () => go(node));
    return row;
  };
  const drawRows = () => {
    const begin = Math.max(0, Math.floor(rows.scrollTop / HEIGHT) - 4);
    const end = Math.min(shown.length, begin + Math.ceil(rows.clientHeight / HEIGHT) + 8);
    sheet.replaceChildren(...shown.slice(begin, end).map((node, i) => drawRow(node, begin + i)));
    const i = shown.indexOf(at);
    if (i >= begin && i < end) rows.setAttribute("aria-activedescendant", rows.id + "-" + i); else rows.removeAttribute("aria-activedescendant");
  };
  const tints = () => ({ RUNNING: color("reactive"), SUCCESS: color("good"), FAILURE: color("bad"), INVALID: color("line") });
  const drawMap = () => {
    map.hidden = nodes.length <= FEW;
    if (map.hidden) return;
    const dpr = window.devicePixelRatio || 1, width = map.clientWidth, tall = Math.max(2, Math.min(16, 190 / (deepest + 1)));
    map.style.height = tall * (deepest + 1) + "px";
    map.width = width * dpr; map.height = tall * (deepest + 1) * dpr;
    const g = map.getContext("2d"), tint = tints(), gap = tall > 5 ? 1 : 0;
    g.setTransform(dpr, 0, 0, dpr, 0, 0);
    // The most important status is drawn last, since a pixel may represent many nodes.
    for (const status of ["INVALID", "SUCCESS", "FAILURE", "RUNNING"]) {
      g.fillStyle = tint[status];
      for (const n of nodes) {
        if (of(n) !== status) continue;
        const x = n.first / leaves * width, wide = (n.last - n.first) / leaves * width;
        g.fillRect(x, n.depth * tall, Math.max(1, wide - (wide > 3 ? 1 : 0)), tall - gap);
      }
    }
  };
  const draw = () => {
    if (!stale) return;
    stale = false;
    if (follow.checked) {
      const i = shown.findIndex((n) => of(n) === "RUNNING" && (!n.children || folded.has(n.path)));
      if (i >= 0 && (i * HEIGHT < rows.scrollTop || (i + 1) * HEIGHT > rows.scrollTop + rows.clientHeight)) rows.scrollTop = (i - 3) * HEIGHT;
    }
    drawRows(); drawMap();
  };
  const toggle = (node, fold) => {
    if (fold) folded.add(node.path); else folded.delete(node.path);
    lay(); draw();
  };
  const go = (node) => {
    at = node;
    for (let up = node.parent; up; up = up.parent) folded.delete(up.path);
    lay();
    const i = shown.indexOf(node), top = i * HEIGHT;
    if (top < rows.scrollTop) rows.scrollTop = top;
    if (top + HEIGHT > rows.scrollTop + rows.clientHeight) rows.scrollTop = top + HEIGHT - rows.clientHeight;
    drawRows();
  };

  rows.addEventListener("scroll", drawRows);
  for (const kind of ["wheel", "touchmove"]) rows.addEventListener(kind, () => { follow.checked = false; }, { passive: true });
  rows.addEventListener("keydown", (event) => {
    const i = shown.indexOf(at), page = Math.floor(rows.clientHeight / HEIGHT) - 1;
    const to = { ArrowDown: i + 1, ArrowUp: i - 1, PageDown: i + page, PageUp: i - page, Home: 0, End: shown.length - 1 }[event.key];
    if (to !== undefined) go(shown[Math.max(0, Math.min(shown.length - 1, to))]);
    else if (event.key === "ArrowLeft") { if (at.children && !folded.has(at.path)) toggle(at, true); else if (at.parent) go(at.parent); }
    else if (event.key === "ArrowRight") { if (folded.has(at.path)) toggle(at, false); }
    else return;
    event.preventDefault(); follow.checked = false;
  });
  map.addEventListener("click", (event) => {
    const box = map.getBoundingClientRect(), leaf = (event.clientX - box.left) / box.width * leaves;
    const depth = Math.floor((event.clientY - box.top) / box.height * (deepest + 1));
    const found = nodes.find((n) => n.depth === depth && n.first <= leaf && leaf < n.last);
    if (found) { follow.checked = false; go(found); }
  });
  return {
    set, draw, size: () => nodes.length,
    setStatuses: (all) => { statuses = all; stale = true; },
    resize: () => { stale = true; draw(); },
    running: () => nodes.filter((n) => !n.children && of(n) === "RUNNING").map((n) => n.name + n.ports),
  };
};
