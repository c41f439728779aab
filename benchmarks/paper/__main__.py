"""`python -m benchmarks.paper`: EXP1 to EXP3 over many seeds, with figures next to the paper's results.

Draws the counterparts of the paper's Figures 5b, 7b, 8 and 9a to 9e as SVG, PDF and PNG, and an HTML page.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rocs_bt.cli.progress import ProgressBar

from .experiments import EXPERIMENTS, make_paper


def main(words: Sequence[str] | None = None) -> int:
    """Run the experiments, write figures and page, and print their location."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.paper", description=__doc__)
    parser.add_argument("--seeds", type=int, default=50, help="runs of each experiment, at least 2")
    parser.add_argument("--out", type=Path, default=Path("runs/paper"), help="output folder")
    parser.add_argument("--jobs", "-j", type=int, default=2, help="number of worker processes")
    given = parser.parse_args(words)
    if given.seeds < 2 or given.jobs < 1:
        parser.error("--seeds must be at least 2, and --jobs at least 1")
    runs = len(EXPERIMENTS) * given.seeds
    with ProgressBar("EXP1 to EXP3", runs, "runs") as progress:
        page, *figures = make_paper(given.out, seeds=given.seeds, processes=given.jobs, progress=progress)
    print(f"{len(figures)} files of {runs} runs in {given.out}")
    print(f"Page: {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
