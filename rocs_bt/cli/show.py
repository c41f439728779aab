"""`rocs-bt show`: the tree of a mission, as text."""

from __future__ import annotations

import click

from .run import catalog_for


@click.command()
@click.argument("mission")
@click.option("--robot", default="pioneer_p3dx", show_default=True, help="The robot that the tree is built for.")
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
def command(mission: str, robot: str, no_code: bool) -> None:
    """Draw the tree of MISSION, a name or a file, and the parameters that it takes."""
    from ..check import draw_mission

    catalog = catalog_for(mission, code=not no_code)
    click.echo(draw_mission(catalog, catalog.find("mission", mission), robot))
