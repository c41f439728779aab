"""Verdicts that stay valid however often one looks: stop a sweep as soon as it has told.

A wealth that bets, scene by scene, on a mean above m cannot be expected to grow if the mean is at most m; that it ever
reaches 1 / alpha is then at most as likely as alpha (Ville, 1939), whenever one stops and why. Waudby-Smith and Ramdas,
Estimating Means of Bounded Random Variables by Betting, J. R. Statist. Soc. B 86, 2024. The scenes must come in an
order that does not depend on how they end.
"""

from __future__ import annotations

import math

import numpy as np

from .estimate import LEVEL, Estimate
from .scenes import Floats

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
