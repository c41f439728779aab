"""SVG drawing of a tree: root at the left, each node a card with its ports; colours follow light and dark mode."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from .picture import Card, Line, Picture

GAP_X, GAP_Y = 46.0, 12.0
TITLE, LINE = 30.0, 17.0
MAX_CHARACTERS = 46
"""Maximum number of characters of a line that are shown; the full text is in the line's tooltip."""

GLYPHS = {"Control": "→", "Decorator": "◇", "Action": "▸", "Condition": "?", "SubTree": "▣"}
_CONTROLS = {"Fallback": "?", "Selector": "?", "Parallel": "⇉", "IfThenElse": "⑂", "WhileDoElse": "⑂", "Switch": "⑂"}

STYLE = """
.tree { --card: #ffffff; --edge: #c3cad3; --text: #1d2733; --dim: #66717f; --key: #1c62c4; --guard: #9a5b00;
  --control: #1c62c4; --decorator: #7b3fb5; --action: #1d8a4e; --condition: #b06a00; --subtree: #0f7a72;
  font: 12px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif; }
@media (prefers-color-scheme: dark) {
  .tree { --card: #1a2027; --edge: #45505d; --text: #e4e9ef; --dim: #93a0af; --key: #6ea8ff; --guard: #ffb454;
    --control: #6ea8ff; --decorator: #c79bf2; --action: #4cc38a; --condition: #f0a94a; --subtree: #4fc9bf; }
}
.tree .card { fill: var(--card); stroke: var(--edge); }
.tree .stub .card { stroke-dasharray: 5 4; }
.tree .link { fill: none; stroke: var(--edge); stroke-width: 1.5; }
.tree .Control { --c: var(--control); }
.tree .Decorator { --c: var(--decorator); } .tree .Action { --c: var(--action); }
.tree .Condition { --c: var(--condition); } .tree .SubTree { --c: var(--subtree); }
.tree .bar { fill: var(--c); } .tree .glyph { fill: var(--c); font-weight: 700; font-size: 13px; text-anchor: middle; }
.tree .title { fill: var(--text); font-weight: 600; font-size: 13px; }
.tree .tag { fill: var(--dim); font-weight: 400; font-size: 11.5px; }
.tree .port { fill: var(--dim); } .tree .value { fill: var(--text); }
.tree .value.key { fill: var(--key); } .tree .value.guard { fill: var(--guard); }
"""


def svg(picture: Picture) -> str:
    """Self-contained SVG document of a picture."""
    boxes, width, height = _layout(picture)
    links = "".join(_links(boxes))
    cards = "".join(_card(card, *box) for card, box in boxes.values())
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="tree" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="{escape(picture.title)}">'
        f"<style>{STYLE}</style>{links}{cards}</svg>"
    )


Box = tuple[float, float, float, float]
"""x, y, width and height [px]."""


def _layout(picture: Picture) -> tuple[dict[int, tuple[Card, Box]], float, float]:
    """Layered layout: one column per depth, each parent centred on its children."""
    columns: dict[int, float] = {}
    for card in picture.cards:
        columns[card.depth] = max(columns.get(card.depth, 0.0), _width(card))
    left, at = {}, 1.0
    for depth in sorted(columns):
        left[depth], at = at, at + columns[depth] + GAP_X
    spans = {id(card): 0.0 for card in picture.cards}
    for card in reversed(picture.cards):  # children before their parents
        below = sum(spans[id(child)] for child in card.children) + GAP_Y * max(0, len(card.children) - 1)
        spans[id(card)] = max(_height(card), below)
    tops, boxes = {id(picture.root): 1.0}, dict[int, tuple[Card, Box]]()
    for card in picture.cards:
        top, span, height = tops[id(card)], spans[id(card)], _height(card)
        boxes[id(card)] = (card, (left[card.depth], top + (span - height) / 2, _width(card), height))
        below = sum(spans[id(child)] for child in card.children) + GAP_Y * max(0, len(card.children) - 1)
        top += (span - below) / 2
        for child in card.children:
            tops[id(child)] = top
            top += spans[id(child)] + GAP_Y
    return boxes, at - GAP_X + 1.0, spans[id(picture.root)] + 2.0


def _links(boxes: dict[int, tuple[Card, Box]]) -> Iterator[str]:
    for card, (x, y, width, _) in boxes.values():
        for child in card.children:
            _, (to_x, to_y, _, _) = boxes[id(child)]
            from_x, from_y, to_y = x + width, y + TITLE / 2, to_y + TITLE / 2
            middle = (from_x + to_x) / 2
            yield (
                f'<path class="link" d="M{from_x:.1f} {from_y:.1f}C{middle:.1f} {from_y:.1f} '
                f'{middle:.1f} {to_y:.1f} {to_x:.1f} {to_y:.1f}"/>'
            )


def _card(card: Card, x: float, y: float, width: float, height: float) -> str:
    tag = f'<tspan class="tag" dx="7">{escape(card.tag)}</tspan>' if card.tag else ""
    about = " · ".join(part for part in (card.location, card.doc) if part)
    lines = "".join(_line(line, TITLE + 10 + i * LINE) for i, line in enumerate(card.lines))
    return (
        f'<g class="{card.kind}{" stub" if card.stub else ""}" transform="translate({x:.1f} {y:.1f})">'
        f"<title>{escape(about or card.title)}</title>"
        f'<rect class="card" width="{width:.1f}" height="{height:.1f}" rx="7"/>'
        f'<path class="bar" d="M4 .5H7V{height - 0.5:.1f}H4A3.5 3.5 0 0 1 .5 {height - 4:.1f}V4A3.5 3.5 0 0 1 4 .5Z"/>'
        f'<text class="glyph" x="19" y="{TITLE / 2 + 5:.1f}">{_glyph(card)}</text>'
        f'<text class="title" x="31" y="{TITLE / 2 + 5:.1f}">{escape(_short(card.title))}{tag}</text>{lines}</g>'
    )


def _line(line: Line, y: float) -> str:
    kind = " guard" if line.sign == "if" else " key" if line.comes_from else ""
    arrow = {">": "→ ", "<>": "↔ "}.get(line.sign, "")
    full = f"{line.name} = {line.value}" + (f": {line.comes_from}" if line.comes_from else "")
    return (
        f'<text x="31" y="{y:.1f}"><title>{escape(full)}</title><tspan class="port">{escape(line.name)} </tspan>'
        f'<tspan class="value{kind}">{escape(arrow + _shown(line))}</tspan>'
        f'<tspan class="port" dx="6">{escape(_note(line))}</tspan></text>'
    )


def _shown(line: Line) -> str:
    return _short(" ".join(line.value.split()))


def _note(line: Line) -> str:
    """Note after a port that has a blackboard key: the key's given value, else its blackboard; may be empty."""
    given = line.comes_from.partition("given: ")[2]
    home = line.comes_from.partition(",")[0] if line.comes_from.startswith("'") else ""
    return _short(given or home)


def _short(text: str) -> str:
    return text if len(text) <= MAX_CHARACTERS else text[: MAX_CHARACTERS - 1] + "…"


def _glyph(card: Card) -> str:
    tag = card.tag or card.title
    return next(
        (glyph for name, glyph in _CONTROLS.items() if name in tag and card.kind == "Control"), GLYPHS[card.kind]
    )


def _height(card: Card) -> float:
    return TITLE + (LINE * len(card.lines) + 4 if card.lines else 0)


def _width(card: Card) -> float:
    """Width of a card [px] that is sufficient for its texts in common fonts."""
    title = len(_short(card.title)) * 8.8 + (len(card.tag) * 7 + 7 if card.tag else 0)
    lines = [(len(line.name) + len(_shown(line)) + len(_note(line)) + 3) * 7.0 for line in card.lines]
    return 31 + 12 + max([title, *lines, 40])
