"""`rocs-bt figures`: the experiments over many seeds, as figures beside what the paper reports."""

from __future__ import annotations

from pathlib import Path

import click

from .progress import Progress
from .terminal import echo


@click.command()
@click.argument("which", type=click.Choice(["paper"]))
@click.option("--seeds", type=click.IntRange(min=2), default=50, show_default=True, help="Runs of each experiment.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Where to write; runs/paper if left out.")
@click.option("--processes", type=click.IntRange(min=1), default=2, show_default=True, help="Runs at once.")
def command(which: str, seeds: int, out: Path | None, processes: int) -> None:
    """Re-run EXP1 to EXP3 and draw the counterparts of the paper's Figures 5b, 7b, 8 and 9a to 9e.

    Writes each as SVG, PDF and PNG, and a page that sets them beside what the paper reports.
    """
    from ..compare.paper import EXPERIMENTS, make_paper

    folder = out or Path("runs") / which
    with Progress("EXP1 to EXP3", len(EXPERIMENTS) * seeds, "runs") as progress:
        page, *figures = make_paper(folder, seeds=seeds, processes=processes, progress=progress)
    echo(f"{len(figures)} files of {len(EXPERIMENTS) * seeds} runs in {folder}")
    echo(f"Page: {page}")
