"""`rocs-bt palette`: write the nodes available to missions in XML, for an editor such as Groot2."""

from __future__ import annotations

from pathlib import Path

import click

from ..catalog import Catalog
from ..dialect import DIALECTS
from ..files import write_whole
from .content import no_code_option
from .terminal import echo, own_stdout


@click.command()
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write to this file.")
@click.option(
    "--nodes",
    "dialect",
    type=click.Choice(DIALECTS),
    default="rocs",
    show_default=True,
    help="Dialect of the nodes.",
)
@no_code_option
def command(out: Path | None, dialect: str, no_code: bool) -> None:
    """Write a TreeNodesModel of all actions and nodes of rocs_bt and of the project, with ports, types and defaults.

    Load the file in an editor such as Groot2, or include it in a mission.
    """
    from ..actions import action_table
    from ..plan import mission_nodes, shipped_nodes
    from ..trees.xml import palette

    click.get_current_context().with_resource(own_stdout())
    catalog = Catalog.here(code=not no_code)
    shipped = shipped_nodes(dialect)
    own = [node for node in catalog.load_nodes() if node.tag not in shipped] if catalog.code else []
    text = palette(mission_nodes(action_table(), own, dialect).values())
    if out is None:
        echo(text.rstrip("\n"))
    else:
        write_whole(out, text)
        echo(f"{out}: {text.count(' ID=')} nodes.")
