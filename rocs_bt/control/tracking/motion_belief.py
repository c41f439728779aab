"""MotionBelief: how movers turn, and the probabilities of how they go on, from how they moved just now."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

from ..locomotion import Array
from ..prediction import PRIOR, displaced

LAGS, EVERY = (0.2, 0.4), 0.1
"""Ages of the estimates from which each hypothesis predicts the present ones, and time between stored ones [s]."""

SPREAD = (0.06, 0.12)
"""Usual error of a good prediction over each of these times [m]."""

WORST = 2.0
"""Error, in usual ones, beyond which a prediction does not count as worse."""

TURN_OVER, MAX_TURN = 0.4, 1.5
"""Time over which a turn is measured [s], and the maximum turn rate [rad/s]."""

SLOW = 0.2
"""Speed below which a velocity has no direction [m/s]."""

LEAST = 0.1
"""Least probability of a hypothesis: a person may change direction at any time."""


class MotionBelief:
    """Memory of the most recent estimates."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, npt.NDArray[np.int64], Array, Array]] = deque()

    def update(self, t: float, ids: npt.NDArray[np.int64], mean: Array) -> tuple[Array, Array]:
        """Add the present estimates of n movers.

        Args:
            t: Present time [s].
            ids: Numbers of the movers, ascending, shape (n,).
            mean: x, y [m] and their velocities [m/s], shape (n, 4).

        Returns:
            Turn rates, shape (n,) [rad/s], and probabilities of the hypotheses, shape (n, 3).
        """
        turn_rate, score = self._turns(t, ids, mean), np.zeros((len(ids), len(PRIOR)))
        for lag, spread in zip(LAGS, SPREAD, strict=True):
            then, now, before, turned = self._matched(t - lag, ids)
            if not len(now):
                continue
            ahead = np.array([t - then])
            for k, (factor, time) in enumerate(((0.0, ahead), (1.0, ahead), (0.0, np.zeros(1)))):
                moved = before[:, :2] + displaced(before[:, 2:], factor * turned, time)[:, 0]
                error = np.hypot(*(mean[now, :2] - moved).T) / spread
                score[now, k] -= 0.5 * np.minimum(error, WORST) ** 2
        if not self._past or t - self._past[-1][0] >= EVERY - 1e-9:
            self._past.append((t, ids.copy(), mean.copy(), turn_rate))
        while t - self._past[0][0] > LAGS[-1] + EVERY:
            self._past.popleft()
        belief = np.array(PRIOR) * np.exp(score)
        belief /= belief.sum(axis=1, keepdims=True)
        return turn_rate, LEAST + (1.0 - LEAST * len(PRIOR)) * belief

    def _turns(self, t: float, ids: npt.NDArray[np.int64], mean: Array) -> Array:
        rates = np.zeros(len(ids))
        then, now, before, _ = self._matched(t - TURN_OVER, ids)
        (ax, ay), (bx, by) = before[:, 2:].T, mean[now, 2:].T
        sure = (np.hypot(ax, ay) > SLOW) & (np.hypot(bx, by) > SLOW)
        angle = np.where(sure, np.arctan2(ax * by - ay * bx, ax * bx + ay * by), 0.0)
        rates[now] = np.clip(angle / max(t - then, EVERY), -MAX_TURN, MAX_TURN)
        return rates

    def _matched(self, t: float, ids: npt.NDArray[np.int64]) -> tuple[float, npt.NDArray[np.intp], Array, Array]:
        """The stored estimates nearest to a time: their time, indices of present movers, means and turn rates."""
        nearest = min(self._past, key=lambda one: abs(one[0] - t), default=None)
        if nearest is None or abs(nearest[0] - t) > EVERY:
            return t, np.zeros(0, np.intp), np.zeros((0, 4)), np.zeros(0)
        then, known, mean, turns = nearest
        _, now, before = np.intersect1d(ids, known, assume_unique=True, return_indices=True)
        return then, now, mean[before], turns[before]
