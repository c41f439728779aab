"""Curves over episodes: what has ended by which cause until when, and performance profiles.

A collision is no censoring: an episode that collided will never succeed, and to leave it out of those at risk, as the
estimate of Kaplan and Meier does, flatters whoever crashes early. Only an episode that its time limit ended before the
moment in question says nothing of that moment.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .estimates import Floats


def cumulative_incidence(times: Floats, causes: npt.NDArray[np.int_], cause: int, at: Floats) -> Floats:
    """The share of episodes that have ended by a cause until each moment.

    Aalen and Johansen, An Empirical Transition Matrix for Non-homogeneous Markov Chains, Scand. J. Statist. 5, 1978.

    Args:
        times: (n,) When each episode ended [s].
        causes: (n,) By what; 0 where it was cut off with nothing decided.
        cause: Which of them.
        at: (m,) The moments, ascending [s].

    Returns:
        (m,)
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
    """The mean time until a cause, where what has not come to it by the horizon counts as the horizon (RMST) [s].

    It is the area above the curve of `cumulative_incidence` (Royston and Parmar, BMC Med. Res. Methodol. 13, 2013). The
    mean over successes alone would reward whoever gives up where it takes long.

    Args:
        times: (n,) When each episode ended [s].
        causes: (n,) By what; 0 where it was cut off with nothing decided.
        cause: Which of them.
        horizon: [s]
    """
    ends = np.unique(times[times < horizon])
    edges = np.concatenate([[0.0], ends, [horizon]])
    reached = cumulative_incidence(times, causes, cause, edges[:-1])
    return float(((1.0 - reached) * np.diff(edges)).sum())


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
    known = values[~np.isnan(values)]
    if (count := len(known)) == 0:
        return math.nan
    cut = count // 4
    # As scipy.stats.trim_mean, whose checks take ten times as long as the mean: a bootstrap asks thousands of times.
    return float(np.partition(known, (cut, count - cut - 1))[cut : count - cut].mean())
