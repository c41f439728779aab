"""How planners look in figures: one colour and one kind of line each, the same everywhere on the page."""

from __future__ import annotations

from typing import Any

from ...record.page import inline_svg

LIGHT = ("#2f6db4", "#c2410d", "#1f8a5c", "#8a4fb9", "#9a7000", "#c0397d", "#2f8594", "#5f666f")
DARK = ("#7db4f6", "#ff9464", "#55c797", "#c79bf3", "#e0b84b", "#f585b6", "#6fcbd9", "#aab2be")
_LINES: tuple[Any, ...] = ("-", (0, (6, 1.5)), (0, (2, 1.2)), (0, (6, 1.5, 1.5, 1.5)))


def colour(number: int) -> str:
    """The colour of a planner, by its place among all."""
    return LIGHT[number % len(LIGHT)]


def line(number: int) -> dict[str, Any]:
    """Colour and kind of its line; two planners of one colour have other kinds, and so do neighbours."""
    return {"color": colour(number), "linestyle": _LINES[(number + number // len(LIGHT)) % len(_LINES)]}


def theme() -> str:
    """The colours as properties of a page, by theme."""
    light, dark = (" ".join(f"--planner-{i}: {value};" for i, value in enumerate(values)) for values in (LIGHT, DARK))
    return f":root {{ {light} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"


def themed(name: str, svg: str) -> str:
    """An SVG file as an element of the page, in the page's colours."""
    text = inline_svg(name, svg)
    for number, value in enumerate(LIGHT):
        text = text.replace(value, f"var(--planner-{number})")
    return text
