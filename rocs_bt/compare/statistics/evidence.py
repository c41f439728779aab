"""Evidence for a difference: flips of scenes, bets that stay valid however often one looks, scenes needed to tell.

A wealth that bets, scene by scene, on a mean above m cannot be expected to grow if the mean is at most m; that it ever
reaches 1 / alpha is then at most as likely as alpha (Ville, 1939), whenever one stops and why. Waudby-Smith and Ramdas,
Estimating Means of Bounded Random Variables by Betting, J. R. Statist. Soc. B 86, 2024. The scenes must come in an
order that does not depend on how they end.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from .estimates import LEVEL, SEED, Estimate, Floats, mean_difference, scene_means

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
    found = mean_difference(scene_means(np.where(np.isnan(a - b), math.nan, np.sign(a - b))), span=1.0)
    value, low, high = (0.5 + end / 2.0 for end in (found.value, found.low, found.high))
    return Estimate(value, max(low, 0.0), min(high, 1.0), found.of)


_BETS = np.geomspace(0.01, 0.95, 24)  # shares of what may be staked; the wealth is spread over all of them
_STEPS = 40  # halvings of an interval's end


def log_wealth(values: Floats, mean: float) -> Floats:
    """The logarithm of the wealth after each scene, for bets on a mean above `mean`.

    Args:
        values: (n,) One a scene, each from 0 to 1.
        mean: The mean that is bet against, above 0.

    Returns:
        (n,)
    """
    each = np.cumsum(np.log1p(_BETS[:, None] * (values / mean - 1.0)), axis=1)
    wealth: Floats = np.logaddexp.reduce(each, axis=0) - math.log(len(_BETS))
    return wealth


def always_valid(differences: Floats, span: float, margin: float = 0.0, level: float = LEVEL) -> tuple[Estimate, float]:
    """The mean of paired differences with an interval, and a p value, that hold at every moment of a sweep.

    Args:
        differences: (n,) One a scene, in the order of the scenes.
        span: The greatest difference possible.
        margin: What the difference is to be told from.
        level: The confidence that the interval holds the mean at all moments together.

    Returns:
        The estimate, and the two-sided p of the margin.
    """
    if len(differences) == 0:
        return Estimate(math.nan, -span, span, 0), 1.0
    up = (differences / span + 1.0) / 2.0
    low = _low_end(up, math.log(2.0 / (1.0 - level)))
    high = 1.0 - _low_end(1.0 - up, math.log(2.0 / (1.0 - level)))
    at = (margin / span + 1.0) / 2.0
    told = max(_evidence(up, at), _evidence(1.0 - up, 1.0 - at))
    found = Estimate(float(differences.mean()), span * (2.0 * low - 1.0), span * (2.0 * high - 1.0), len(differences))
    return found, min(2.0 * math.exp(-told), 1.0)


def _evidence(values: Floats, mean: float) -> float:
    """The greatest logarithm of the wealth so far."""
    if mean >= 1.0:
        return 0.0
    return float(log_wealth(values, mean).max()) if mean > 0.0 else math.inf


def _low_end(values: Floats, enough: float) -> float:
    """The greatest mean that the values have told from theirs: the wealth falls as it grows."""
    low, high = 0.0, 1.0
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if _evidence(values, middle) >= enough else (low, middle)
    return low


POWER = 0.8
"""How likely a difference is to be found that is there."""

_NOTHING = 1e-3  # of the spread: a difference that would take millions of scenes is none


def scenes_needed(
    differences: Floats, margin: float = 0.0, *, effect: float | None = None, level: float = LEVEL, power: float = POWER
) -> int | None:
    """How many scenes it takes to tell a mean difference from a margin, judging by the scenes there are.

    Args:
        differences: (n,) One a scene, as `paired` gives.
        margin: What it is to be told from.
        effect: How far the true difference is thought to be from the margin; as far as that of these scenes if left
            out, which is a guess where they are few.
        level: The confidence of the verdict.
        power: How likely the verdict is to be reached.

    Returns:
        The number of scenes in all; None where these say nothing of it.
    """
    from scipy.special import ndtri

    n = len(differences)
    if n < 2:
        return None
    apart = abs(float(differences.mean()) - margin) if effect is None else abs(effect)
    spread = float(differences.std(ddof=1))
    if apart == 0.0 or apart <= _NOTHING * spread:
        return None
    least = math.ceil(1.0 - math.log2(1.0 - level) - 1e-9)  # fewer have too few flips for such a p
    sure, likely = float(ndtri(0.5 + level / 2.0)), float(ndtri(power))
    # For Student's quantiles a few more (Guenther, The American Statistician 35, 1981).
    return max(least, math.ceil(((sure + likely) * spread / apart) ** 2 + sure**2 / 2.0))


def mcnemar_power(only_a: float, only_b: float, pairs: int, level: float = LEVEL) -> float:
    """How likely the exact McNemar test is to tell two planners apart, on single episodes of as many scenes.

    Args:
        only_a: The share of scenes in which only one succeeds.
        only_b: The share in which only the other does.
        pairs: How many scenes.
        level: The confidence of the verdict.
    """
    from scipy.stats import binom

    discordant = np.arange(1, pairs + 1)
    counts = np.arange(pairs + 1)
    # Two-sided p of k of d is twice the smaller tail; both tails of each d are rejected up to the same count.
    tail = 2.0 * binom.cdf(counts[:, None], discordant, 0.5)
    critical = (tail <= 1.0 - level).sum(axis=0) - 1  # -1: not even 0 of d will do
    towards = only_a / (only_a + only_b)
    found = binom.cdf(critical, discordant, towards) + binom.sf(discordant - critical - 1, discordant, towards)
    return float((binom.pmf(discordant, pairs, only_a + only_b) * np.where(critical >= 0, found, 0.0)).sum())
