"""Estimates over the independent episodes of one scenario, as the tables of the paper show them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rocs_bt.compare.statistics import LEVEL, Estimate, equal

RESAMPLES = 10_000
SEED = 20260101  # the same episodes give the same interval


def share(hits: int, of: int) -> Estimate:
    """Share of the episodes of one scenario that succeed, with its exact interval (Clopper and Pearson, 1934).

    The episodes must be independent, so they may differ only by seed; over several scenes use `rate`.

    Args:
        hits: Number of episodes that succeed.
        of: Number of episodes, at least one.
    """
    from scipy.stats import binomtest

    interval = binomtest(hits, of).proportion_ci(LEVEL, method="exact")
    return Estimate(hits / of, float(interval.low), float(interval.high), of)


def mean(values: Sequence[float]) -> Estimate:
    """Mean over the episodes of one scenario, with its bootstrap percentile interval from a seeded generator.

    Args:
        values: One or more values; over several scenes use `mean_over_scenes`.
    """
    from scipy.stats import bootstrap

    average = float(np.mean(values))
    if len(values) < 2 or equal(values):
        return Estimate(average, np.nan, np.nan, len(values))
    resampled = bootstrap(
        (values,),
        np.mean,
        confidence_level=LEVEL,
        n_resamples=RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(SEED),
    )
    interval = resampled.confidence_interval
    return Estimate(average, float(interval.low), float(interval.high), len(values))
