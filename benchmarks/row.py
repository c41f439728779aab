"""What every benchmark shares: the row that it yields, and its size."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TypeVar

QUICK = "ROCS_BT_BENCH_QUICK"
"""Environment variable that makes every size the quick one; `python benchmarks --quick` sets it."""

T = TypeVar("T")


def size(full: T, quick: T) -> T:
    """A benchmark's size, such as its rounds, seeds or nodes.

    Args:
        full: Size that gives a figure worth reading.
        quick: Smallest size that still runs every line. Its figures mean nothing.
    """
    return quick if os.environ.get(QUICK) else full


@dataclass(frozen=True)
class Row:
    """A line of `make bench`; every `bench_*.py` has a function `run` that yields its rows as they are known.

    Attributes:
        name: Name of the measured quantity.
        value: Figure.
        unit: Unit of the figure.
        baseline: Name of what `ratio` is relative to; empty for none.
        ratio: Ratio of the figure to the baseline's, measured in the same process.
        budget: Budget of docs/architecture.md, in words; empty for none.
        holds: Whether the figure keeps to the budget; None without one.
    """

    name: str
    value: float
    unit: str
    baseline: str = ""
    ratio: float | None = None
    budget: str = ""
    holds: bool | None = None

    def __str__(self) -> str:
        ratio = "" if self.ratio is None else f"{self.ratio:.3g}x {self.baseline}"
        holds = "" if self.holds is None else ("yes" if self.holds else "NO")
        measured = f"{self.value:.4g} {self.unit}"
        return f"{self.name:<76}  {measured:<28}  {ratio:<40}  {self.budget:<20}  {holds}".rstrip()
