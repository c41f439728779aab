"""Means over scenes, and paired differences of means, with intervals that cover for few scenes too.

Percentiles of a bootstrap are too narrow for few scenes, and a bootstrap of Student's t breaks down where most scenes
say the same (docs/statistics.md has the coverage of each); so means have intervals of their own, and resampling is for
what has none (`cluster_bootstrap`).
"""

from __future__ import annotations

import math

import numpy as np

from .estimate import LEVEL, Estimate
from .scenes import Floats, scene_means


def mean_over_scenes(values: Floats, level: float = LEVEL) -> Estimate:
    """A mean over scenes, with Student's interval, widened on the side to which the scenes are skewed.

    Args:
        values: (n_scenes, n_seeds), NaN where there is none.
        level: The interval's confidence.
    """
    means = scene_means(values)
    n = len(means)
    if n < 2:
        return Estimate(float(means[0]) if n else math.nan, math.nan, math.nan, n)
    error = float(means.std(ddof=1)) / math.sqrt(n)
    return Estimate(float(means.mean()), *_ends(means, error, level), n)


def _ends(sample: Floats, error: float, level: float) -> tuple[float, float]:
    """Student's interval, with each end where it reaches furthest with and without a correction for skewness.

    Times and lengths are skewed, and so are differences where one planner fails more often; a plain interval then
    misses on one side. The correction moves the interval by its first-order term (Johnson, Modified t Tests, JASA 73,
    1978; Hall, On the Removal of Skewness by Transformation, J. R. Statist. Soc. B 54, 1992); to take nothing away on
    the other side keeps the confidence for few scenes, too. Hall's whole transformation breaks down for few.

    Args:
        sample: (n,)
        error: The mean's standard error.
        level: The confidence.
    """
    from scipy.special import stdtrit

    n, centre, spread = len(sample), float(sample.mean()), float(sample.std(ddof=1))
    quantile = float(stdtrit(n - 1, 0.5 + level / 2.0))
    third = float((((sample - centre) / spread) ** 3).mean()) if spread > 0.0 else 0.0
    shift = third * spread * (1.0 + 2.0 * quantile**2) / (6.0 * n)
    half = quantile * error
    return centre - half + min(shift, 0.0), centre + half + max(shift, 0.0)


def paired(a: Floats, b: Floats) -> Floats:
    """How much a is above b in each scene, over the seeds that both have.

    Args:
        a: (n_scenes, n_seeds), NaN where there is none.
        b: The same scenes and seeds.

    Returns:
        (n,) For each scene in which both have an episode of the same seed.
    """
    return scene_means(np.asarray(a, dtype=float) - np.asarray(b, dtype=float))


def mean_difference(differences: Floats, level: float = LEVEL, span: float = math.nan) -> Estimate:
    """The mean of paired differences, with Student's interval over scenes.

    The variance is that of one scene more, whose difference is as large as those that are not 0 are on average: where
    few scenes tell two planners apart, these few say little of how often others will (for single episodes this is close
    to Agresti and Min, Biostatistics 6, 2005, who add such pairs to the counts).

    Args:
        differences: (n,) One a scene, as `paired` gives.
        level: The interval's confidence.
        span: The greatest difference possible, at which the interval ends, and which stands for the scene more where
            none differs; NaN where there is no such bound: where none differs the interval is then 0 to 0, which says
            nothing of scenes not seen.
    """
    n = len(differences)
    if n < 2:
        return Estimate(float(differences[0]) if n else math.nan, math.nan, math.nan, n)
    centre, different = float(differences.mean()), differences[differences != 0.0]
    more = float((different**2).mean()) if len(different) else 0.0 if math.isnan(span) else span**2
    error = math.sqrt((float((differences**2).sum() + more) / n - centre**2) / (n - 1))
    low, high = _ends(differences, error, level)
    return Estimate(centre, float(np.fmax(low, -span)), float(np.fmin(high, span)), n)
