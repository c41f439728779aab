"""When episodes end, and how: success and what competes with it, over time.

A collision is no censoring: an episode that collided will never succeed, and to leave it out of those at risk, as the
estimate of Kaplan and Meier does, flatters whoever crashes early. Only an episode that its time limit ended before the
moment in question says nothing of that moment.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .scenes import Floats


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
