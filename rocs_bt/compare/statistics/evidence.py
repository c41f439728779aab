"""Tests of differences: sign-flip tests over scenes, sequential betting tests, and the number of scenes needed.

A betting test of the hypothesis that a mean is at most m starts with wealth 1 and bets, scene by scene, on a larger
mean. Under the hypothesis, the wealth is a nonnegative supermartingale. The probability that the wealth ever reaches 1
/ alpha is therefore at most alpha (Ville, 1939), for any stopping rule. The order of the scenes must not depend on
their results. Source: Waudby-Smith and Ramdas, Estimating Means of Bounded Random Variables by Betting, J. R. Statist.
Soc. B 86, 2024.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from .estimates import LEVEL, SEED, Estimate, Floats, equal, mean_difference, scene_means

_RESAMPLES = 2_000
_FLIPS = 9_999
_ENUMERATED = 16  # maximum number of scenes for which all flips are enumerated
_CHUNK = 500
_ROUNDING = 1e-12


def cluster_bootstrap(
    values: Floats, statistic: Callable[[Floats], float | Floats], level: float = LEVEL, resamples: int = _RESAMPLES
) -> tuple[Floats, Floats, Floats]:
    """Statistic with its bootstrap interval, resampling whole scenes (Davison and Hinkley, 1997, 3.8).

    Args:
        values: Input of the statistic, shape (n_scenes, ...).
        statistic: Function that returns a number or an array.
        level: Confidence level.
        resamples: Number of resamples, from a seeded generator.

    Returns:
        The statistic, and the percentiles at both ends of the interval, all of the same shape.
    """
    rng, n = np.random.default_rng(SEED), len(values)
    resampled = np.array([statistic(values[rng.integers(0, n, n)]) for _ in range(resamples)])
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(resampled, [tail, 1.0 - tail], axis=0)
    return np.asarray(statistic(values), dtype=float), low, high


def bootstrapped(values: Floats, statistic: Callable[[Floats], float]) -> Estimate:
    """`cluster_bootstrap` of a scalar statistic as an `Estimate`; without an interval if all resamples are equal."""
    value, low, high = cluster_bootstrap(values, statistic)
    if equal((low, high)):
        return Estimate(float(value), math.nan, math.nan, len(values))
    return Estimate(float(value), float(low), float(high), len(values))


def sign_flip_test(differences: Floats, lattice: int = 0) -> float:
    """Two-sided p value of the hypothesis that the mean difference is 0, by flipping the signs of whole scenes.

    If all differences are -1, 0 or 1, this is the exact McNemar test (McNemar, Psychometrika 12, 1947). The p value is
    exact if the differences are multiples of one number, or if few scenes differ. Otherwise flips are sampled from a
    seeded generator (p value after Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9, 2010).

    Args:
        differences: Differences, one per scene, from `paired`, shape (n,).
        lattice: Integer n if all differences are multiples of 1 / n; else 0.

    Returns:
        The p value; 1 if no scene differs.
    """
    different = differences[differences != 0.0]
    if len(different) == 0:
        return 1.0
    if lattice:
        return _counted(np.rint(np.abs(different) * lattice).astype(int), int(np.rint(different.sum() * lattice)))
    reached = abs(float(different.sum())) - _ROUNDING * float(np.abs(different).sum())
    if len(different) <= _ENUMERATED:
        bits = np.arange(2 ** len(different))[:, None] >> np.arange(len(different)) & 1
        return float((np.abs((1.0 - 2.0 * bits) @ different) >= reached).mean())
    rng, count = np.random.default_rng(SEED), 0
    for start in range(0, _FLIPS, _CHUNK):
        signs = 1.0 - 2.0 * rng.integers(0, 2, (min(_CHUNK, _FLIPS - start), len(different)))
        count += int((np.abs(signs @ different) >= reached).sum())
    return (count + 1.0) / (_FLIPS + 1.0)


def _counted(sizes: npt.NDArray[np.int_], total: int) -> float:
    """Share of all sign combinations of some integers that give an absolute sum of at least that of `total`."""
    from scipy.stats import binom

    chances = np.ones(1)  # probabilities of all possible sums, in ascending order
    for size, count in zip(*np.unique(sizes, return_counts=True), strict=True):
        of_these = np.zeros(2 * size * count + 1)
        of_these[:: 2 * size] = binom.pmf(np.arange(count + 1), count, 0.5)
        chances = np.convolve(chances, of_these)
    reach = len(chances) // 2
    far = np.abs(np.arange(-reach, reach + 1)) >= abs(total)
    return min(float(chances[far].sum()), 1.0)


def holm(p: Floats) -> Floats:
    """P values of several tests, adjusted to control the family-wise error rate.

    Holm, A Simple Sequentially Rejective Multiple Test Procedure, Scand. J. Statist. 6, 1979, 65-70.

    Args:
        p: P values, shape (n,). The adjusted p values have the same order.
    """
    order = np.argsort(p, kind="stable")
    scaled = np.asarray(p, dtype=float)[order] * (len(p) - np.arange(len(p)))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return adjusted


def superiority(a: Floats, b: Floats) -> Estimate:
    """Probability that the value of a is above that of b in the same scene with the same seed; ties count half.

    This effect size is the probability of improvement, or stochastic superiority, of paired episodes (Vargha and
    Delaney, J. Educ. Behav. Statist. 25, 2000).

    Args:
        a: Values, shape (n_scenes, n_seeds); NaN if missing.
        b: Values for the same scenes and seeds, same shape.
    """
    found = mean_difference(scene_means(np.where(np.isnan(a - b), math.nan, np.sign(a - b))), span=1.0)
    value, low, high = (0.5 + end / 2.0 for end in (found.value, found.low, found.high))
    return Estimate(value, max(low, 0.0), min(high, 1.0), found.of)


_BETS = np.geomspace(0.01, 0.95, 24)  # bet sizes as shares of the largest one; they share the wealth
_STEPS = 40  # number of bisection steps for one end of an interval


def log_wealth(values: Floats, mean: float) -> Floats:
    """Logarithm of the wealth of a betting test after each scene, for bets on a mean above `mean`, shape (n,).

    Args:
        values: Values, one per scene, between 0 and 1, shape (n,).
        mean: Mean of the null hypothesis, above 0.
    """
    each = np.cumsum(np.log1p(_BETS[:, None] * (values / mean - 1.0)), axis=1)
    wealth: Floats = np.logaddexp.reduce(each, axis=0) - math.log(len(_BETS))
    return wealth


def always_valid(differences: Floats, span: float, margin: float = 0.0, level: float = LEVEL) -> tuple[Estimate, float]:
    """Mean of paired differences with an interval and a p value that stay valid at every stopping time of a sweep.

    Args:
        differences: Differences, one per scene, in scene order, shape (n,).
        span: Greatest possible absolute difference.
        margin: Mean difference of the null hypothesis.
        level: Probability that the interval contains the true mean at all times.
    """
    if len(differences) == 0:
        return Estimate(math.nan, -span, span, 0), 1.0
    up = (differences / span + 1.0) / 2.0
    low = _low_end(up, math.log(2.0 / (1.0 - level)))
    high = 1.0 - _low_end(1.0 - up, math.log(2.0 / (1.0 - level)))
    at = (margin / span + 1.0) / 2.0
    evidence = max(_evidence(up, at), _evidence(1.0 - up, 1.0 - at))
    found = Estimate(float(differences.mean()), span * (2.0 * low - 1.0), span * (2.0 * high - 1.0), len(differences))
    return found, min(2.0 * math.exp(-evidence), 1.0)


def _evidence(values: Floats, mean: float) -> float:
    """Maximum of the log wealth over all scenes so far; see `log_wealth`."""
    if mean >= 1.0:
        return 0.0
    return float(log_wealth(values, mean).max()) if mean > 0.0 else math.inf


def _low_end(values: Floats, enough: float) -> float:
    """Greatest mean that the betting test rejects, found by bisection, since the wealth decreases with the mean."""
    low, high = 0.0, 1.0
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if _evidence(values, middle) >= enough else (low, middle)
    return low


POWER = 0.8
"""Probability of a verdict on a true difference with the number of scenes that is estimated to be needed."""

_NOTHING = 1e-3  # share of the spread below which a difference counts as none: it would need millions of scenes


def scenes_needed(differences: Floats, margin: float = 0.0, level: float = LEVEL) -> int | None:
    """Estimated number of scenes for distinguishing a mean difference like the observed one from a margin.

    Args:
        differences: Differences, one per scene, from `paired`, shape (n,).
        margin: Mean difference of the null hypothesis.
        level: Confidence level of the verdict.

    Returns:
        Total number of scenes; None if it cannot be estimated.
    """
    from scipy.special import ndtri

    n = len(differences)
    if n < 2:
        return None
    apart = abs(float(differences.mean()) - margin)
    spread = float(differences.std(ddof=1))
    if apart == 0.0 or apart <= _NOTHING * spread:
        return None
    least = math.ceil(1.0 - math.log2(1.0 - level) - 1e-9)  # fewer scenes have too few sign flips for such a p
    sure, likely = float(ndtri(0.5 + level / 2.0)), float(ndtri(POWER))
    # The second term corrects for Student's quantiles (Guenther, The American Statistician 35, 1981).
    return max(least, math.ceil(((sure + likely) * spread / apart) ** 2 + sure**2 / 2.0))
