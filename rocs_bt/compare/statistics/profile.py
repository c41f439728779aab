"""What a mean hides: performance profiles, and a mean without the best and the worst quarter."""

from __future__ import annotations

import numpy as np

from .scenes import Floats


def performance_profile(costs: Floats, ratios: Floats) -> Floats:
    """In what share of episodes a planner is within a ratio of the best one (Dolan, More, Math. Program. 91, 2002).

    Args:
        costs: (n_planners, n_episodes) Such as the time, greater than 0; +inf where it failed.
        ratios: (m,) At least 1.

    Returns:
        (n_planners, m) At ratio 1 how often it is the best; towards the right how often it succeeds.
    """
    best = costs.min(axis=0)
    with np.errstate(invalid="ignore"):  # nobody succeeded: inf / inf, which is within no ratio
        relative = costs / best
    within: Floats = (relative[:, :, None] <= ratios * (1.0 + 1e-12)).mean(axis=1)
    return within


def interquartile_mean(values: Floats) -> float:
    """The mean of the middle half of all episodes.

    Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice, 2021.

    It says how a planner mostly does, and nothing of how it fails: where three of four episodes are perfect it is
    perfect. So it stands beside the mean, never in its place.
    """
    from scipy.stats import trim_mean

    return float(trim_mean(values[~np.isnan(values)], 0.25))
