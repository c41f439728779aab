"""Curves over episodes: cumulative incidence of outcomes, and performance profiles.

A collision is a competing event, not censoring: an episode that collided never succeeds. The Kaplan-Meier estimate
would remove it from those at risk and so favour planners that crash early. Only an episode cut off by its time limit
is censored.
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
        times: (n,) End time of each episode [s].
        causes: (n,) Cause of each end; 0 if censored.
        cause: The cause of interest.
        at: (m,) Times of the result, ascending [s].

    Returns:
        (m,) Shares.
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


def restricted_mean_time(times: Floats, causes: npt.NDArray[np.int_], cause: int, horizon: float) -> float:
    """Restricted mean time until a cause (RMST) [s]; episodes that do not reach it count as the horizon.

    The area above the curve of `cumulative_incidence` (Royston and Parmar, BMC Med. Res. Methodol. 13, 2013). The mean
    over successes alone would reward planners that give up on slow episodes.

    Args:
        times: (n,) End time of each episode [s].
        causes: (n,) Cause of each end; 0 if censored.
        cause: The cause of interest.
        horizon: Upper limit of the times [s].
    """
    ends = np.unique(times[times < horizon])
    edges = np.concatenate([[0.0], ends, [horizon]])
    reached = cumulative_incidence(times, causes, cause, edges[:-1])
    return float(((1.0 - reached) * np.diff(edges)).sum())


def performance_profile(costs: Floats, ratios: Floats) -> Floats:
    """Share of episodes in which a planner is within a ratio of the best (Dolan, More, Math. Program. 91, 2002).

    Args:
        costs: (n_planners, n_episodes) Positive costs, such as times; +inf for failures.
        ratios: (m,) Ratios, at least 1.

    Returns:
        (n_planners, m) Shares: at ratio 1 the share of wins, for large ratios the success rate.
    """
    best = costs.min(axis=0)
    with np.errstate(invalid="ignore"):  # inf / inf if no planner succeeded: within no ratio
        relative = costs / best
    within: Floats = (relative[:, :, None] <= ratios * (1.0 + 1e-12)).mean(axis=1)
    return within


def interquartile_mean(values: Floats) -> float:
    """Mean of the middle half of all episodes.

    Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice, 2021.

    It describes typical episodes and ignores failures of up to a quarter of them; report it beside the mean, not in
    place of it.
    """
    known = values[~np.isnan(values)]
    if (count := len(known)) == 0:
        return math.nan
    cut = count // 4
    # Equals scipy.stats.trim_mean, which takes ten times as long because of its checks; a bootstrap calls it often.
    return float(np.partition(known, (cut, count - cut - 1))[cut : count - cut].mean())
