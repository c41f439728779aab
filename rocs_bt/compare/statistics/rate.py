"""Shares over scenes and seeds: an interval that covers, and bounds that hold whatever the scenes are like."""

from __future__ import annotations

import math

import numpy as np

from .estimate import LEVEL, Estimate
from .scenes import Floats, sample_size, scene_means

_DOUBT = 0.5  # scenes: the weight of "all seeds alike" against what the scenes show


def rate(values: Floats, level: float = LEVEL) -> Estimate:
    """A share of episodes over scenes, with an interval that knows that a scene's seeds are alike.

    Wilson's score interval (1927) at the effective number of episodes, with Student's quantile for the scenes (Korn and
    Graubard, Survey Methodology 24, 1998, do so with the exact interval, which covers too much). How alike seeds are is
    known badly where nearly all episodes end the same way, and is then taken to be nearly 1: the estimate is drawn
    towards it with the weight of half a scene against those scenes that have both endings, or the rarer one.

    Args:
        values: (n_scenes, n_seeds), 0 or 1, NaN where there is none.
        level: The interval's confidence.
    """
    from scipy.special import stdtrit

    means = scene_means(values)
    n = len(means)
    if n == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    size, share = sample_size(values), float(means.mean())
    if n < 2:
        return Estimate(share, math.nan, math.nan, n)
    telling = min(int((means > 0.0).sum()), int((means < 1.0).sum()))
    alike = (telling * size.alike + _DOUBT) / (telling + _DOUBT)
    worth = size.episodes / (1.0 + (size.episodes / n - 1.0) * alike)
    z2 = float(stdtrit(n - 1, 0.5 + level / 2.0)) ** 2
    centre = (share + z2 / (2.0 * worth)) / (1.0 + z2 / worth)
    half = math.sqrt(z2 * (share * (1.0 - share) / worth + z2 / (4.0 * worth**2))) / (1.0 + z2 / worth)
    return Estimate(share, max(centre - half, 0.0), min(centre + half, 1.0), n)


def upper_bound(values: Floats, level: float = LEVEL) -> float:
    """What the true share is at most, with a confidence that does not depend on how alike a scene's seeds are.

    With one seed a scene this is the exact bound of Clopper and Pearson (1934). With several, each scene counts as one
    trial with its mean as the count: exact where all seeds of a scene end alike, and wider than need be where they do
    not, but never too narrow as it would be if seeds counted as trials. Nothing in n scenes gives about 3 / n.

    Args:
        values: (n_scenes, n_seeds), 0 or 1, NaN where there is none.
        level: The confidence that the true share is not above the bound.

    Returns:
        The bound; 1 where there is no episode.
    """
    from scipy.special import betaincinv

    means = scene_means(values)
    count, n = float(means.sum()), len(means)
    return 1.0 if n == 0 or count >= n else float(betaincinv(count + 1.0, n - count, level))


def lower_bound(values: Floats, level: float = LEVEL) -> float:
    """What the true share is at least: `upper_bound` of the opposite."""
    return 1.0 - upper_bound(1.0 - np.asarray(values, dtype=float), level)
