"""Losses of a cold comparison as a table of texts, for a terminal, Markdown and a report."""

from __future__ import annotations

from collections.abc import Sequence

from ..cold import Loss
from ..metric import metric
from .tables import difference, text

HEAD = ("planner", "perturbation", "metric", "warm", "cold", "loss")
"""Head of the table; a positive loss means that the planner is worse with the perturbation, in any metric."""


def cold_rows(losses: Sequence[Loss]) -> list[list[str]]:
    """Rows of the table: one for each planner, perturbation and metric."""
    return [
        [
            loss.planner,
            loss.perturbation,
            loss.verdict.metric,
            *(text(estimate, metric(loss.verdict.metric)) for estimate in (loss.warm, loss.cold)),
            difference(loss.verdict),
        ]
        for loss in losses
    ]
