"""`rocs-bt report`: summary and report of a recording."""

from __future__ import annotations

from pathlib import Path

import click

from .content import open_recording
from .outcome import outcome_text
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Output folder; by default that of RUN.")
def command(run: Path, out: Path | None) -> None:
    """Make summary.json and report.html of RUN, a run's folder or its run.mcap, also of one that is cut off or damaged.

    Both are computed from the recording alone. An agent without an outcome is `interrupted`; values that no event
    contains (wall time, trajectory hash, knowledge file) are null.
    """
    from .._run import report

    result = report(open_recording(run), out)
    if result.recording is not None:
        echo(outcome_text(result.summary, result.recording.parent, result.report))
