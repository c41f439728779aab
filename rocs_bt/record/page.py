"""Pages of one HTML file each that need nothing else: their templates, and figures in the page's own colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from .figures import figure

# The figures' colours become the page's, so that they follow its light or dark theme.
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
    """A page from one of the templates; texts in it are escaped.

    Args:
        template: Its file's name.
        beside: A folder with more templates.
        values: What is filled in.
    """
    import jinja2

    folders = [Path(__file__).parent / "templates"]
    loader = jinja2.FileSystemLoader(folders if beside is None else [beside, *folders])
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(template).render(**values)


def inline_svg(name: str, svg: str) -> str:
    """An SVG file as an element of a page: its ids made its own, its metadata left out, its colours the page's."""
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = re.sub(rf'(\bid="|href="#|url\(#)(?!{name}-)', rf"\g<1>{name}-", svg)
    for color, variable in THEME.items():
        svg = svg.replace(color, variable)
    return svg
