"""One measured figure, beside what it is compared with."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A line of `make bench`.

    Attributes:
        name: What was measured.
        value: The figure.
        unit: Its unit.
        baseline: What `ratio` is relative to; empty for none.
        ratio: The figure over the baseline's, measured in the same process.
        budget: What docs/architecture.md allows, in words; empty for none.
        holds: Whether it keeps to the budget; None where there is none.
    """

    name: str
    value: float
    unit: str
    baseline: str = ""
    ratio: float | None = None
    budget: str = ""
    holds: bool | None = None
