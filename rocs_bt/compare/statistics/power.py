"""How many scenes it takes."""

from __future__ import annotations

import math

import numpy as np

from .estimate import LEVEL
from .scenes import Floats

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
