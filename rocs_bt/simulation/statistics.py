"""What many episodes say: shares and means, each with how sure it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEVEL = 0.95
"""The confidence of every interval."""

_RESAMPLES = 10_000
_SEED = 20260101  # of the bootstrap: the same episodes give the same interval


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval.

    Attributes:
        value: The share or the mean.
        low: The interval's lower end; NaN where one episode alone says nothing of it.
        high: The interval's upper end.
        of: From how many episodes.
    """

    value: float
    low: float
    high: float
    of: int


def share(hits: int, of: int) -> Estimate:
    """A share of episodes with its exact interval (Clopper and Pearson, 1934).

    Args:
        hits: In how many it was so.
        of: Of how many; at least one.
    """
    from scipy.stats import binomtest

    interval = binomtest(hits, of).proportion_ci(LEVEL, method="exact")
    return Estimate(hits / of, float(interval.low), float(interval.high), of)


def mean(values: Sequence[float]) -> Estimate:
    """A mean over episodes with its bootstrap interval (percentiles), from a seeded generator.

    Args:
        values: At least one.
    """
    from scipy.stats import bootstrap

    average = float(np.mean(values))
    if len(values) < 2:
        return Estimate(average, np.nan, np.nan, len(values))
    drawn = bootstrap(
        (values,),
        np.mean,
        confidence_level=LEVEL,
        n_resamples=_RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(_SEED),
    )
    interval = drawn.confidence_interval
    return Estimate(average, float(interval.low), float(interval.high), len(values))
