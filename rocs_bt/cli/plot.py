"""`rocs-bt plot`: figures of a run as PNG and SVG."""

from __future__ import annotations

from pathlib import Path

import click

from .content import open_recording
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.argument("other", required=False, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Output folder; by default in the run's folder.")
def command(run: Path, other: Path | None, out: Path | None) -> None:
    """Draw the figures of RUN, a run's folder or its run.mcap.

    With OTHER, both runs are drawn over each other, and both.html is the page of both with their first differences.
    """
    from ..record import Tracks, first_differences, write_figures
    from ..record.pages import write_report

    recordings = [open_recording(path) for path in (run, other) if path is not None]
    folder = out or (run if run.is_dir() else run.parent) / ("figures" if other is None else "overlay")
    for path in write_figures(recordings, folder):
        echo(str(path))
    if other is not None:
        page = folder / "both.html"
        write_report(recordings[0], recordings[0].summary, page, recordings[1])
        echo(str(page))
        differences = first_differences(*map(Tracks.of_recording, recordings))
        echo("\n".join(map(str, differences)) or "No decision, knowledge, command or pose differs.")
