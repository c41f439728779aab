"""`rocs-bt report`: summary and report of a recording."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..errors import RecordingError
from .outcome import outcome_text
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Where to write; beside RUN if left out.")
def command(run: Path, out: Path | None) -> None:
    """Make summary.json and report.html of RUN, a run's folder or its run.mcap; also of one that was cut off.

    They are computed from the recording alone. An agent without an outcome is `interrupted` there, and what no event
    holds (wall time, trajectory hash, file of knowledge) is null.
    """
    from ..record import Recording, write_report, write_whole
    from ..simulation import REPORT, SUMMARY, summary_of

    recording = Recording.open(run)
    folder = out or recording.path.parent
    summary, report = summary_of(recording), folder / REPORT
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / SUMMARY, json.dumps(summary, indent=2) + "\n")
    except OSError as error:
        hint = "Name another folder with --out."
        raise RecordingError(f"the summary '{folder / SUMMARY}' cannot be written: {error.strerror}. {hint}") from error
    write_report(recording, summary, report)
    echo(outcome_text(summary, recording.path.parent, report))
