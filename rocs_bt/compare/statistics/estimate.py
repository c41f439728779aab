"""Estimate: a number with its interval; and what the episodes of a single scenario say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

LEVEL = 0.95
"""The confidence of every interval."""

RESAMPLES = 10_000
SEED = 20260101  # of every resampling: the same episodes give the same interval


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval.

    Attributes:
        value: The share, the mean, or whatever is estimated.
        low: The interval's lower end; NaN where one episode, or one scene, alone says nothing of it.
        high: The interval's upper end.
        of: From how many; episodes of one scenario, scenes of several.
    """

    value: float
    low: float
    high: float
    of: int

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it, which knows no NaN."""
        return {key: None if math.isnan(value) else value for key, value in vars(self).items()}


def share(hits: int, of: int) -> Estimate:
    """A share of episodes with its exact interval (Clopper and Pearson, 1934).

    The episodes are of one scenario, so that nothing but their seeds tells them apart; over several scenes: `rate`.

    Args:
        hits: In how many it was so.
        of: Of how many; at least one.
    """
    from scipy.stats import binomtest

    interval = binomtest(hits, of).proportion_ci(LEVEL, method="exact")
    return Estimate(hits / of, float(interval.low), float(interval.high), of)


def mean(values: Sequence[float]) -> Estimate:
    """A mean over episodes of one scenario with its bootstrap interval (percentiles), from a seeded generator.

    Args:
        values: At least one; over several scenes: `mean_over_scenes`.
    """
    from scipy.stats import bootstrap

    average = float(np.mean(values))
    if len(values) < 2:
        return Estimate(average, np.nan, np.nan, len(values))
    drawn = bootstrap(
        (values,),
        np.mean,
        confidence_level=LEVEL,
        n_resamples=RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(SEED),
    )
    interval = drawn.confidence_interval
    return Estimate(average, float(interval.low), float(interval.high), len(values))
