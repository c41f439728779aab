"""Resampling: a bootstrap that draws scenes, and tests that flip what two planners did in a scene."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from .estimate import LEVEL, SEED, Estimate
from .scenes import Floats

_RESAMPLES = 2_000
_FLIPS = 9_999
_ENUMERATED = 16  # scenes up to which all flips are tried
_CHUNK = 500
_ROUNDING = 1e-12


def cluster_bootstrap(
    values: Floats, statistic: Callable[[Floats], float | Floats], level: float = LEVEL, resamples: int = _RESAMPLES
) -> tuple[Floats, Floats, Floats]:
    """A statistic with its bootstrap interval, for which whole scenes are drawn (Davison and Hinkley, 1997, 3.8).

    Args:
        values: (n_scenes, ...) Whatever the statistic takes, scenes first.
        statistic: A number or an array of numbers, of values with as many scenes, some more than once.
        level: The interval's confidence.
        resamples: How often scenes are drawn, from a seeded generator.

    Returns:
        The statistic, and the percentiles at the interval's ends, each of its shape.
    """
    rng, n = np.random.default_rng(SEED), len(values)
    drawn = np.array([statistic(values[rng.integers(0, n, n)]) for _ in range(resamples)])
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0)
    return np.asarray(statistic(values), dtype=float), low, high


def bootstrapped(values: Floats, statistic: Callable[[Floats], float], level: float = LEVEL) -> Estimate:
    """The same for a number, as an estimate."""
    value, low, high = cluster_bootstrap(values, statistic, level)
    return Estimate(float(value), float(low), float(high), len(values))


def sign_flip_test(differences: Floats, lattice: int = 0) -> float:
    """How likely a mean as far from 0 is when in each scene either sign is as likely as the other: two-sided p.

    This is the exact McNemar test where scenes differ by -1, 0 or 1 (McNemar, Psychometrika 12, 1947). All flips are
    counted where differences are multiples of one number, or scenes are few; else some are drawn, from a seeded
    generator (Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9, 2010, on how p is then told).

    Args:
        differences: (n,) One a scene, as `paired` gives.
        lattice: Differences are multiples of 1 / lattice; 0 where they are not.

    Returns:
        p; 1 where nothing differs.
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
    """The share of all flips of whole numbers whose sum is as far from 0 as the total."""
    from scipy.stats import binom

    chances = np.ones(1)  # of the sums from -reach to reach
    for size, count in zip(*np.unique(sizes, return_counts=True), strict=True):
        of_these = np.zeros(2 * size * count + 1)
        of_these[:: 2 * size] = binom.pmf(np.arange(count + 1), count, 0.5)
        chances = np.convolve(chances, of_these)
    reach = len(chances) // 2
    far = np.abs(np.arange(-reach, reach + 1)) >= abs(total)
    return min(float(chances[far].sum()), 1.0)


def mcnemar_test(only_a: int, only_b: int) -> float:
    """The exact McNemar test: two-sided p of as unequal counts of episodes in which only one of two succeeds.

    For one seed a scene; with more, the seeds of a scene are alike and `sign_flip_test` is the one to use.
    """
    from scipy.stats import binomtest

    return float(binomtest(only_a, only_a + only_b).pvalue) if only_a + only_b else 1.0


def holm(p: Floats) -> Floats:
    """P values of several questions at once, adjusted so that any false answer is as rare as one alone.

    Holm, A Simple Sequentially Rejective Multiple Test Procedure, Scand. J. Statist. 6, 1979, 65-70.

    Args:
        p: (n,)

    Returns:
        (n,) In the same order.
    """
    order = np.argsort(p, kind="stable")
    scaled = np.asarray(p, dtype=float)[order] * (len(p) - np.arange(len(p)))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return adjusted


def superiority(a: Floats, b: Floats) -> Estimate:
    """How likely a is above b in an episode of the same scene and seed; half of the ties: an effect size.

    The probability of improvement, or stochastic superiority (Vargha and Delaney, J. Educ. Behav. Statist. 25, 2000),
    of paired episodes.

    Args:
        a: (n_scenes, n_seeds), NaN where there is none.
        b: The same scenes and seeds.
    """
    from .means import mean_difference
    from .scenes import scene_means

    found = mean_difference(scene_means(np.where(np.isnan(a - b), math.nan, np.sign(a - b))), span=1.0)
    value, low, high = (0.5 + end / 2.0 for end in (found.value, found.low, found.high))
    return Estimate(value, max(low, 0.0), min(high, 1.0), found.of)
