"""A tree as a page: its picture, its keys and what a check finds, in one file that needs nothing else."""

from __future__ import annotations

from pathlib import Path

from ..trees.draw.picture import Picture
from ..trees.draw.svg import svg


def page(picture: Picture) -> str:
    """A picture as HTML, in the style of a run's report."""
    import jinja2

    loader = jinja2.FileSystemLoader(Path(__file__).parent / "templates")
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = environment.get_template("tree.html")
    return template.render(picture=picture, drawing=svg(picture), stand_ins=sum(c.stand_in for c in picture.cards))
