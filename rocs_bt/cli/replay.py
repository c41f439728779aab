"""`rocs-bt replay`: the recorded sensors to the same mind, or why something happened."""

from __future__ import annotations

from pathlib import Path

import click

from ..catalog import Catalog
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--why", metavar="T", type=float, help="Tell what was known, planned, fired and sent at T seconds.")
@click.option("--agent", help="Whose; all agents if left out.")
def command(run: Path, why: float | None, agent: str | None) -> int:
    """Feed the sensors recorded in RUN to the same mind, and compare its decisions with those recorded.

    Exits with 0 when they are the same, with 1 at the first event that differs. With --why nothing is run.
    """
    from ..record import Recording

    recording = Recording.open(run)
    if why is not None:
        from ..record import explain

        echo(explain(recording, why, agent))
        return 0
    from ..simulation import replay

    difference = replay(recording, Catalog.here(), agent=agent)
    if difference is None:
        cut = "" if recording.complete else ", as far as the recording goes: it was cut off"
        echo(f"The same decisions, event by event{cut}.")
        return 0
    echo(str(difference))
    return 1
