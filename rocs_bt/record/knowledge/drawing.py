"""Drawing of a knowledge graph as SVG: nodes coloured by kind, relations as arrows, light and dark theme.

The agent is in the middle; the other nodes are on rings around it. The number of a node's ring is the number of
relations on the shortest way between the agent and the node.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from ...knowledge import Readable

Point = tuple[float, float]
RING = 110.0  # [px] distance from one ring to the next
ROOM = 62.0  # [px] space for each node along a ring
STRETCH = 1.45  # horizontal stretch, since names are wider than high


def layout(kinds: Mapping[str, str], edges: Iterable[tuple[str, str]], root: str) -> dict[str, Point]:
    """Ring layout of a graph; deterministic.

    Returns:
        Position of each node [px], x right and y down, relative to the root.
    """
    near: dict[str, list[str]] = {name: [] for name in kinds}
    for one, other in edges:
        near[one].append(other)
        near[other].append(one)
    positions: dict[str, Point] = {}
    radius = 0.0
    for ring in _rings(kinds, near, root):
        if ring == [root]:
            positions[root] = (0.0, 0.0)
            continue
        while ring:
            radius += RING
            fit = max(6, int(math.tau * radius / ROOM))
            row, ring = (ring, []) if len(ring) <= fit else (ring[:fit], ring[fit:])
            for i, name in enumerate(row):
                angle = math.tau * (i / len(row)) - math.pi / 2.0
                positions[name] = (STRETCH * radius * math.cos(angle), radius * math.sin(angle))
    return positions


def _rings(kinds: Mapping[str, str], near: Mapping[str, list[str]], root: str) -> Iterable[list[str]]:
    """Nodes of each ring: grouped by the number of relations between them and the root, unconnected nodes last."""
    seen: set[str] = set()
    ring = [root] if root in kinds else []
    while ring:
        yield ring
        seen.update(ring)
        following: dict[str, None] = {}
        for name in ring:  # neighbours of one node are side by side
            following.update(dict.fromkeys(_together((n for n in near[name] if n not in seen), kinds)))
        ring = list(following)
    if alone := [name for name in kinds if name not in seen]:
        yield _together(alone, kinds)


def _together(names: Iterable[str], kinds: Mapping[str, str]) -> list[str]:
    """Group names by kind, with kinds in the order of their first occurrence."""
    names = list(names)
    first = {kind: i for i, kind in reversed(list(enumerate(kinds[name] for name in names)))}
    return sorted(names, key=lambda name: first[kinds[name]])


COLORS = ("robot-1", "reactive", "place", "robot-2", "robot-3", "deliberative", "worst", "good", "idle")
"""CSS colours of the kinds, in order of appearance."""
CROWD = 250
"""Number of nodes above which names are hidden, since they would overlap."""
STYLE = """
.knowledge { --ink: #1d2733; --muted: #66717f; --wall: #c3cad3; --paper: #ffffff; --robot-1: #7b3fb5;
  --reactive: #1c62c4; --place: #1d8a4e; --robot-2: #c26a00; --robot-3: #0f7a72; --deliberative: #c9302c;
  --worst: #a8610a; --good: #1d8a4e; --idle: #98a2ae; }
@media (prefers-color-scheme: dark) { .knowledge { --ink: #e4e9ef; --muted: #93a0af; --wall: #45505d;
  --paper: #12161b; --robot-1: #c79bf2; --reactive: #6ea8ff; --place: #4cc38a; --robot-2: #f0a94a;
  --robot-3: #4fc9bf; --deliberative: #ff6b63; --worst: #f0a94a; --good: #4cc38a; --idle: #7c8896; } }
.knowledge { font: 13px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif; }
.knowledge .node circle { fill: var(--c); stroke: var(--paper); stroke-width: 2; }
.knowledge .node text { fill: var(--ink); paint-order: stroke; stroke: var(--paper); stroke-width: 3.5px; }
.knowledge .edge path { fill: none; stroke: var(--wall); stroke-width: 1.4; }
.knowledge .edge text { fill: var(--muted); font-size: 10.5px; text-anchor: middle; paint-order: stroke;
  stroke: var(--paper); stroke-width: 3px; }
.knowledge marker path { fill: var(--wall); }
.knowledge.crowd .node text, .knowledge.crowd .edge text { display: none; }
"""
_MARGIN, _DOT = 40.0, 7.0
_LETTER, _LONGEST = 7.6, 28  # width of a letter [px]; maximum number of shown letters of a name
Edge = tuple[str, str, str]


def draw(graph: Readable, root: str) -> str:
    """Draw a graph as a self-contained SVG document.

    Args:
        graph: Graph to draw.
        root: Node in the middle.
    """
    return picture({name: graph.kind(name) for name in graph.nodes()}, graph.edges(), root)


def picture(kinds: Mapping[str, str], edges: Sequence[Edge], root: str) -> str:
    """Draw nodes with their kinds, and edges (source, relation, target) as SVG."""
    positions = layout(kinds, [(source, target) for source, _, target in edges], root)
    colors = {kind: COLORS[i % len(COLORS)] for i, kind in enumerate(dict.fromkeys(kinds.values()))}
    left, top, width, height = _frame(positions)
    lines = "".join(_edge(edge, positions, bend) for edge, bend in _bends(edges))
    dots = "".join(_node(name, kind, positions[name], colors[kind]) for name, kind in kinds.items())
    crowd = " crowd" if len(kinds) > CROWD else ""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="knowledge{crowd}" role="img" '
        f'aria-label="Knowledge of {_text(root)}" viewBox="{left:.0f} {top:.0f} {width:.0f} {height:.0f}">'
        f"<style>{STYLE}</style>"
        '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto-start-reverse"><path d="M0 0L8 4L0 8z"/></marker></defs>'
        f'<g class="edges">{lines}</g><g class="nodes">{dots}</g></svg>\n'
    )


def _frame(positions: Mapping[str, Point]) -> tuple[float, float, float, float]:
    """Left, top, width and height of the drawing, including names [px]."""
    wide = {name: 24.0 + _LETTER * min(len(name), _LONGEST) for name in positions}
    left = min((x - (wide[n] if x < -1.0 else 20.0) for n, (x, _) in positions.items()), default=0.0)
    right = max((x + (20.0 if x < -1.0 else wide[n]) for n, (x, _) in positions.items()), default=1.0)
    ys = [y for _, y in positions.values()] or [0.0]
    return left, min(ys) - _MARGIN, right - left, max(ys) - min(ys) + 2.0 * _MARGIN


def _bends(edges: Sequence[Edge]) -> Iterable[tuple[Edge, float]]:
    """Edges with their sideways bend [px], which separates several edges between the same nodes."""
    count: dict[frozenset[str], int] = {}
    for edge in edges:
        pair = frozenset((edge[0], edge[2]))
        number = count[pair] = count.get(pair, -1) + 1
        yield edge, 14.0 * number


def _edge(edge: Edge, positions: Mapping[str, Point], bend: float) -> str:
    source, relation, target = edge
    (x0, y0), (x1, y1) = positions[source], positions[target]
    length = math.hypot(x1 - x0, y1 - y0)
    if length < 1e-9:  # a loop
        path, x, y = f"M{x0 - 5:.1f} {y0 - 5:.1f}c-34 -34 44 -34 10 0", x0, y0 - 30.0
    else:
        along, across = (x1 - x0) / length, (y1 - y0) / length
        gap = _DOT + 3.0
        x, y = (x0 + x1) / 2.0 - across * bend, (y0 + y1) / 2.0 + along * bend
        path = (
            f"M{x0 + along * gap:.1f} {y0 + across * gap:.1f}"
            f"Q{x - across * bend:.1f} {y + along * bend:.1f} {x1 - along * gap:.1f} {y1 - across * gap:.1f}"
        )
    title = f"<title>{_text(source)} {_text(relation)} {_text(target)}</title>"
    return (
        f'<g class="edge"><path d="{path}" marker-end="url(#arrow)"/>'
        f'<text x="{x:.1f}" y="{y + 3.0:.1f}">{_text(relation)}</text>{title}</g>'
    )


def _node(name: str, kind: str, position: Point, color: str) -> str:
    x, y = position
    shown = name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…"
    beside = 'x="-11" text-anchor="end"' if x < -1.0 else 'x="11"'  # away from the middle and its edges
    return (
        f'<g class="node" style="--c: var(--{color})" transform="translate({x:.1f} {y:.1f})">'
        f'<title>{_text(name)}, {_text(kind)}</title><circle r="{_DOT:g}"/>'
        f'<text {beside} y="4.5">{_text(shown)}</text></g>'
    )


def _text(text: str) -> str:
    """Escape a text and replace characters that XML does not allow."""
    return escape(
        "".join(c if c >= " " and not "\ud800" <= c <= "\udfff" and c not in "\ufffe\uffff" else "�" for c in text)
    )
