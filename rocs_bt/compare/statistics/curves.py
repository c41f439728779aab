"""Curves over episodes: cumulative incidence of outcomes, and performance profiles.

A collision is a competing event, not censoring: an episode with a collision never succeeds. The Kaplan-Meier estimate
would remove such an episode from the set at risk, and so favour planners that crash early. Only an episode that its
time limit ended is censored.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .estimates import Floats


def cumulative_incidence(times: Floats, causes: npt.NDArray[np.int_], cause: int, at: Floats) -> Floats:
    """Share of episodes that have ended by a given cause, over time.

    Aalen and Johansen, An Empirical Transition Matrix for Non-homogeneous Markov Chains, Scand. J. Statist. 5, 1978.

    Args:
        times: End time of each episode [s], shape (n,).
        causes: Cause of the end of each episode, shape (n,); 0 if censored.
        cause: The cause of interest.
        at: Times at which to compute the share, ascending [s], shape (m,). The result has this shape too.
    """
    ends, inverse = np.unique(times, return_inverse=True)
    decided = np.bincount(inverse, causes != 0, len(ends))
    ours = np.bincount(inverse, causes == cause, len(ends))
    at_risk = len(times) - np.concatenate([[0], np.cumsum(np.bincount(inverse, minlength=len(ends)))[:-1]])
    undecided = np.cumprod(1.0 - decided / at_risk)  # after each end
    before = np.concatenate([[1.0], undecided[:-1]])
    incidence = np.concatenate([[0.0], np.cumsum(before * ours / at_risk)])
    reached: Floats = incidence[np.searchsorted(ends, at, side="right")]
    return reached


def performance_profile(costs: Floats, ratios: Floats) -> Floats:
    """Share of episodes in which a planner's cost is at most a ratio times that of the best planner.

    Dolan and More, Benchmarking optimization software with performance profiles, Math. Program. 91, 2002.

    Args:
        costs: Positive costs, such as times, shape (n_planners, n_episodes); +inf for failures.
        ratios: Ratios, at least 1, shape (m,).

    Returns:
        Shares, shape (n_planners, m): at ratio 1 the share of wins, at large ratios the success rate.
    """
    best = costs.min(axis=0)
    with np.errstate(invalid="ignore"):  # inf / inf if no planner succeeded: within no ratio
        relative = costs / best
    within: Floats = (relative[:, :, None] <= ratios * (1.0 + 1e-12)).mean(axis=1)
    return within


def interquartile_mean(values: Floats) -> float:
    """Mean of the middle half of all episodes.

    Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice, 2021.

    It describes typical episodes. Because it ignores failures if they are less than a quarter of the episodes, report
    it together with the mean, not in place of it.
    """
    known = values[~np.isnan(values)]
    if (count := len(known)) == 0:
        return math.nan
    cut = count // 4
    # Equals scipy.stats.trim_mean, which takes ten times as long because of its checks; a bootstrap calls it often.
    return float(np.partition(known, (cut, count - cut - 1))[cut : count - cut].mean())
