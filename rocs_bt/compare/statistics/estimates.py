"""Estimates over scenes and seeds: means, shares and differences, with intervals that are valid for few scenes.

Scenes are the sample units, since episodes of one scene with different seeds are correlated. Functions take arrays
values[scene, seed], with NaN for missing episodes. They use the scene means, which are independent of each other
(ultimate clusters: Hansen, Hurwitz and Madow, Sample Survey Methods and Theory, 1953).

Bootstrap percentile intervals are too narrow for few scenes, and a bootstrap of Student's t fails if most scenes have
the same value; tests/compare/calibration.py prints the coverage of each. The intervals of means are therefore computed
without a bootstrap; `cluster_bootstrap` is meant for other statistics.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LEVEL = 0.95
"""Confidence level of all intervals."""

_ROUNDING = 1e-12
SEED = 20260101  # fixed seed of all resampling: the same episodes give the same interval


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval.

    Attributes:
        value: Estimated value.
        low: Lower end of the interval; NaN if the sample size is less than 2, or if equal values say nothing of others.
        high: Upper end of the interval; NaN like the lower end.
        of: Sample size: number of scenes, or of episodes of one scenario.
    """

    value: float
    low: float
    high: float
    of: int


def equal(values: npt.ArrayLike) -> bool:
    """Whether all values are equal; no bootstrap and no standard deviation then gives an interval."""
    return float(np.ptp(values)) <= _ROUNDING * float(np.max(np.abs(values)))


def scene_means(values: Floats) -> Floats:
    """Mean of the values of each scene, over its seeds; scenes without any value are omitted.

    Args:
        values: Values, shape (n_scenes, n_seeds); NaN if missing.

    Returns:
        Means, shape (n,) with n <= n_scenes.
    """
    known = values[~np.isnan(values).all(axis=1)]
    return known[:, 0].copy() if known.shape[1] == 1 else np.nanmean(known, axis=1)


@dataclass(frozen=True)
class SampleSize:
    """Actual and effective size of a sample of scenes and seeds.

    Attributes:
        scenes: Number of scenes with a value.
        episodes: Number of episodes with a value.
        intraclass_correlation: Correlation of the seeds of one scene, 0 (independent) to 1 (identical); estimated by
            analysis of variance and clipped.
        design_effect: Variance of the mean, divided by the variance that the mean of as many independent episodes would
            have (Kish, Survey Sampling, 1965).
        effective: Equivalent number of independent episodes.
    """

    scenes: int
    episodes: int
    intraclass_correlation: float
    design_effect: float
    effective: float


def sample_size(values: Floats) -> SampleSize:
    """Actual and effective size of a sample.

    Args:
        values: Values, shape (n_scenes, n_seeds); NaN if missing.
    """
    known = values[~np.isnan(values).all(axis=1)]
    scenes, episodes = len(known), int((~np.isnan(known)).sum())
    if scenes < 2:
        return SampleSize(scenes, episodes, 1.0, float(episodes or 1), float(scenes))
    spread = float(np.nanvar(known)) * episodes / (episodes - 1)
    between = float(scene_means(known).var(ddof=1)) / scenes
    seeds = episodes / scenes
    effect = between * episodes / spread if spread > 0.0 else seeds
    effect = min(max(effect, 1.0), seeds)
    correlation = (effect - 1.0) / (seeds - 1.0) if seeds > 1.0 else 1.0
    return SampleSize(scenes, episodes, correlation, effect, episodes / effect)


def mean_over_scenes(values: Floats, *, unseen: Sequence[float] = ()) -> Estimate:
    """Mean over scenes with Student's interval, which is widened on the side of a skewed distribution's long tail.

    Student's interval knows nothing of values that no episode has shown, such as that of a failure if all episodes
    succeed. At most the share `most_unseen` of the scenes has them. The interval includes what this would do to the
    mean.

    Args:
        values: Values, shape (n_scenes, n_seeds); NaN if missing.
        unseen: Values that no episode shows although others may. Without them, equal values have no interval.
    """
    means = scene_means(values)
    n = len(means)
    if n < 2:
        return Estimate(float(means[0]) if n else math.nan, math.nan, math.nan, n)
    centre, low, high = float(means.mean()), math.nan, math.nan
    if not equal(means):
        low, high = _ends(means, float(means.std(ddof=1)) / math.sqrt(n), LEVEL)
    elif unseen:
        low = high = centre
    most = most_unseen(values)
    low = min([low, *((1.0 - most) * low + most * value for value in unseen)])
    high = max([high, *((1.0 - most) * high + most * value for value in unseen)])
    return Estimate(centre, low, high, n)


def _ends(sample: Floats, error: float, level: float) -> tuple[float, float]:
    """Ends of Student's interval of a mean, the end on the long tail's side with a skewness correction.

    Times and lengths are skewed, and so are differences if one planner fails more often; a plain interval is then too
    short on one side. The correction is the first-order term of Johnson (Modified t Tests, JASA 73, 1978) and Hall (On
    the Removal of Skewness by Transformation, J. R. Statist. Soc. B 54, 1992). It is not applied to the other end,
    which preserves the coverage for few scenes. Hall's full transformation fails for few scenes.

    Args:
        sample: Values, one per scene, shape (n,).
        error: Standard error of the mean.
        level: Confidence level.
    """
    from scipy.special import stdtrit

    n, centre, spread = len(sample), float(sample.mean()), float(sample.std(ddof=1))
    quantile = float(stdtrit(n - 1, 0.5 + level / 2.0))
    third = float((((sample - centre) / spread) ** 3).mean()) if spread > 0.0 else 0.0
    shift = third * spread * (1.0 + 2.0 * quantile**2) / (6.0 * n)
    half = quantile * error
    return centre - half + min(shift, 0.0), centre + half + max(shift, 0.0)


def paired(a: Floats, b: Floats) -> Floats:
    """Mean difference a - b in each scene, over the seeds for which both have a value.

    Args:
        a: Values, shape (n_scenes, n_seeds); NaN if missing.
        b: Values for the same scenes and seeds, same shape.

    Returns:
        Differences, shape (n,): one for each scene with at least one common seed.
    """
    return scene_means(np.asarray(a, dtype=float) - np.asarray(b, dtype=float))


def mean_difference(differences: Floats, level: float = LEVEL, span: float = math.nan) -> Estimate:
    """Mean of paired differences, with Student's interval over scenes.

    The variance includes one additional, fictitious scene; its squared difference is the mean of the nonzero squared
    differences. The reason is that a few differing scenes do not show well how often new scenes will differ. For single
    episodes this is close to Agresti and Min, Biostatistics 6, 2005, who add such pairs to the counts.

    Args:
        differences: Differences, one per scene, from `paired`, shape (n,).
        level: Confidence level.
        span: Greatest possible difference, which bounds the interval. It is also the difference of the additional scene
            if all differences are 0. NaN if unbounded; if all differences are 0, there is then no interval.
    """
    n = len(differences)
    if n < 2:
        return Estimate(float(differences[0]) if n else math.nan, math.nan, math.nan, n)
    centre, different = float(differences.mean()), differences[differences != 0.0]
    if not len(different) and math.isnan(span):
        return Estimate(centre, math.nan, math.nan, n)
    more = float((different**2).mean()) if len(different) else span**2
    error = math.sqrt((float((differences**2).sum() + more) / n - centre**2) / (n - 1))
    low, high = _ends(differences, error, level)
    return Estimate(centre, float(np.fmax(low, -span)), float(np.fmin(high, span)), n)


_PRIOR_SCENES = 0.5  # [scenes] weight of the prior "all seeds of a scene are equal"


def rate(values: Floats) -> Estimate:
    """Rate of an event, such as success, over scenes, with an interval that accounts for correlated seeds.

    The interval is Wilson's score interval (1927), computed with the effective number of episodes and Student's
    quantile for the number of scenes. Korn and Graubard (Survey Methodology 24, 1998) use the exact interval instead,
    which is too wide. The intra-class correlation is hard to estimate if nearly all episodes end the same way. Its
    estimate is therefore shrunk towards 1, with the weight of half a scene against the number of scenes with the rarer
    outcome.

    Args:
        values: Values 0 or 1, shape (n_scenes, n_seeds); NaN if missing.
    """
    from scipy.special import stdtrit

    means = scene_means(values)
    n = len(means)
    if n == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    size, share = sample_size(values), float(means.mean())
    if n < 2:
        return Estimate(share, math.nan, math.nan, n)
    informative = min(int((means > 0.0).sum()), int((means < 1.0).sum()))
    correlation = (informative * size.intraclass_correlation + _PRIOR_SCENES) / (informative + _PRIOR_SCENES)
    effective = size.episodes / (1.0 + (size.episodes / n - 1.0) * correlation)
    z2 = float(stdtrit(n - 1, 0.5 + LEVEL / 2.0)) ** 2
    centre = (share + z2 / (2.0 * effective)) / (1.0 + z2 / effective)
    half = math.sqrt(z2 * (share * (1.0 - share) / effective + z2 / (4.0 * effective**2))) / (1.0 + z2 / effective)
    return Estimate(share, max(centre - half, 0.0), min(centre + half, 1.0), n)


def most_unseen(values: Floats) -> float:
    """Upper end of the interval of the rate of an event that occurred in none of the episodes.

    Args:
        values: Any values of the episodes, shape (n_scenes, n_seeds); NaN if missing.
    """
    return rate(np.where(np.isnan(values), np.nan, 0.0)).high


def widened(episodes: Floats, shares: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Band of shares between 0 and 1 from a bootstrap, with `most_unseen` where all resamples are equal.

    Args:
        episodes: Any values of the episodes, shape (n_scenes, n_seeds); NaN if missing.
        shares: Estimated shares, shape (n,).
        low: Lower end of each share's interval, shape (n,).
        high: Upper end of each share's interval, shape (n,).
    """
    most, flat = most_unseen(episodes), high - low <= _ROUNDING
    return np.where(flat, (1.0 - most) * shares, low), np.where(flat, (1.0 - most) * shares + most, high)


def upper_bound(values: Floats, level: float = LEVEL) -> float:
    """One-sided upper confidence bound of a rate, valid for any correlation between the seeds of a scene.

    With one seed per scene this is the exact bound of Clopper and Pearson (1934). With several seeds, each scene counts
    as one trial, and the mean of its values as the number of hits. This is exact if all episodes of a scene end the
    same way, and conservative otherwise. Counting each seed as a trial would give a bound that is too low. If all
    values of n scenes are 0, the bound is about 3 / n.

    Args:
        values: Values 0 or 1, shape (n_scenes, n_seeds); NaN if missing.
        level: Confidence level.

    Returns:
        The bound; 1 without episodes.
    """
    from scipy.special import betaincinv

    means = scene_means(values)
    count, n = float(means.sum()), len(means)
    return 1.0 if n == 0 or count >= n else float(betaincinv(count + 1.0, n - count, level))


def lower_bound(values: Floats, level: float = LEVEL) -> float:
    """One-sided lower confidence bound of a rate; see `upper_bound`."""
    return 1.0 - upper_bound(1.0 - np.asarray(values, dtype=float), level)
