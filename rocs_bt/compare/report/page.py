"""Self-contained HTML pages: rendering of templates, and SVG figures in the colours of the page."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...record.figures import figure

if TYPE_CHECKING:
    from jinja2 import Environment

# Colours of figures are replaced by CSS variables, so that figures follow the light or dark theme.
THEME = {
    figure.INK: "var(--ink)",
    figure.MUTED: "var(--muted)",
    figure.GRID: "var(--line)",
    figure.WALL: "var(--wall)",
    figure.PLACE: "var(--place)",
    figure.OTHER: "var(--other)",
    figure.WORST: "var(--worst)",
    figure.ROUTES["deliberative"]: "var(--deliberative)",
    figure.ROUTES["reactive"]: "var(--reactive)",
    figure.ROUTES["idle"]: "var(--idle)",
    **{color: f"var(--robot-{i})" for i, color in enumerate(figure.ROBOTS, 1)},
}


def render_page(template: str, *, beside: Path | None = None, **values: Any) -> str:
    """Render a template; texts are HTML-escaped."""
    return _environment(beside).get_template(template).render(**values)


@cache
def _environment(beside: Path | None) -> Environment:
    """Environment that keeps the templates that it has compiled."""
    import jinja2

    folders = [Path(__file__).parent / "templates", *([] if beside is None else [beside])]
    loader = jinja2.FileSystemLoader(folders)
    return jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)


def inline_svg(name: str, svg: str) -> str:
    """Convert an SVG file to an element of an HTML page, with unique ids, without metadata, in the page's colours."""
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = re.sub(rf'(\bid="|href="#|url\(#)(?!{name}-)', rf"\g<1>{name}-", svg)
    for color, variable in THEME.items():
        svg = svg.replace(color, variable)
    return svg
