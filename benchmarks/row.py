"""Row type and size selection of all benchmarks."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TypeVar

QUICK = "ROCS_BT_BENCH_QUICK"
"""Environment variable that selects the quick sizes; `python benchmarks --quick` sets it."""

T = TypeVar("T")


def size(full: T, quick: T) -> T:
    """Size of a benchmark, such as rounds, seeds or nodes.

    Args:
        full: Size for meaningful figures.
        quick: Smallest size that executes every line; its figures are meaningless.
    """
    return quick if os.environ.get(QUICK) else full


@dataclass(frozen=True)
class Row:
    """One output line of `make bench`. The function `run` of every `bench_*.py` yields rows.

    Attributes:
        name: Name of the measured quantity.
        value: Figure.
        unit: Unit of the figure.
        baseline: Name of the baseline of `ratio`; empty for none.
        ratio: Ratio of the figure to the baseline's, measured in the same process.
        budget: Budget of docs/architecture.md as text; empty for none.
        holds: Whether the figure meets the budget; None without a budget.
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
