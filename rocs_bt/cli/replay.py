"""`rocs-bt replay`: re-run agents on recorded sensor data, or explain one moment of a run."""

from __future__ import annotations

from pathlib import Path

import click

from ..catalog import Catalog
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--why", metavar="SECONDS", type=float, help="Explain the decision at this time.")
@click.option("--agent", help="Name of the agent; by default all.")
@click.option("--changed-content", is_flag=True, help="Compare although robots, rules or other files have changed.")
def command(run: Path, why: float | None, agent: str | None, changed_content: bool) -> int:
    """Re-run the agents of RUN on its recorded sensor data, and compare their events with the recorded ones.

    Exits with 0 if all events are equal, with 1 at the first difference. With --why, the recording is only queried.
    With --changed-content, the agents have the present content: it shows whether a change alters their decisions.
    """
    from ..record import Recording

    recording = Recording.open(run)
    if why is not None:
        from ..record import explain

        echo(explain(recording, why, agent))
        return 0
    from ..simulation import replay

    difference = replay(recording, Catalog.here(), agent=agent, changed_content=changed_content)
    if difference is None:
        cut = "" if recording.complete else ", up to the end of the recording, which was cut off"
        echo(f"All events are equal{cut}.")
        return 0
    echo(str(difference))
    return 1
