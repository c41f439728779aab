"""`rocs-bt knowledge keys`: keys of robots that share knowledge."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import click

from ..cli.terminal import echo


@click.command()
@click.argument("members", nargs=-1, required=True)
@click.option("--out", default="keys", show_default=True, type=click.Path(path_type=Path), help="Folder of the group.")
def keys(members: tuple[str, ...], out: Path) -> None:
    """Make keys for MEMBERS, such as the names of the agents, that share knowledge over a network.

    Copy each member's folder to its robot, and name it in the scenario: [share] keys = "keys/R2". The file
    authority.key signs further members; do not copy it to a robot. A group that has keys keeps them.
    """
    from .keys import make_keys

    for folder in make_keys(out, members, datetime.now(UTC)):
        echo(f"{folder}: keys of {folder.name}. Copy them to that robot only, over a trusted connection.")
    echo(f"{out / 'authority.key'}: signs further members. Keep it here and secret.")
