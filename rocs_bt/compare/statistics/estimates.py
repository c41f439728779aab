"""Estimates over scenes and seeds: means, shares and differences, each with an interval that covers for few scenes too.

Scenes are the sample: the seeds of one scene are alike, so they say less than as many scenes would. All functions take
values[scene, seed], with NaN where an episode has no value. The mean of a scene's seeds is what the scene says; the
scenes are independent of each other, so everything follows from these means as it does from a plain sample (ultimate
clusters: Hansen, Hurwitz and Madow, Sample Survey Methods and Theory, 1953).

Percentiles of a bootstrap are too narrow for few scenes, and a bootstrap of Student's t breaks down where most scenes
say the same (docs/statistics.md has the coverage of each); so means have intervals of their own, and resampling is for
what has none (`cluster_bootstrap`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

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


def scene_means(values: Floats) -> Floats:
    """The mean of each scene that has a value.

    Args:
        values: (n_scenes, n_seeds), NaN where there is none.

    Returns:
        (n,) With n <= n_scenes.
    """
    known = values[~np.isnan(values).all(axis=1)]
    return known[:, 0].copy() if known.shape[1] == 1 else np.nanmean(known, axis=1)


@dataclass(frozen=True)
class SampleSize:
    """How much a sample of scenes and seeds is worth.

    Attributes:
        scenes: How many scenes have a value.
        episodes: How many episodes have one.
        intraclass_correlation: Correlation of the seeds of one scene, 0 (independent) to 1 (identical); estimated by
            analysis of variance and clipped.
        design_effect: By how much the variance of the mean exceeds that of as many independent episodes (Kish, Survey
            Sampling, 1965).
        effective: How many independent episodes would say as much.
    """

    scenes: int
    episodes: int
    intraclass_correlation: float
    design_effect: float
    effective: float


def sample_size(values: Floats) -> SampleSize:
    """How much a sample of scenes and seeds is worth.

    Args:
        values: (n_scenes, n_seeds), NaN where there is none.
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
    alike = (effect - 1.0) / (seeds - 1.0) if seeds > 1.0 else 1.0
    return SampleSize(scenes, episodes, alike, effect, episodes / effect)


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


_PRIOR_SCENES = 0.5  # scenes: the weight of "all seeds alike" against what the scenes show


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
    alike = (telling * size.intraclass_correlation + _PRIOR_SCENES) / (telling + _PRIOR_SCENES)
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
