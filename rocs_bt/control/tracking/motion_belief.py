"""MotionBelief: how movers turn, and the probabilities of how they go on, from how they moved just now."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..locomotion import Array
from ..prediction import HYPOTHESES, PRIOR, accelerated, displaced

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


CHANGES = HYPOTHESES.index("changes speed")
"""The hypothesis that a mover has only while it accelerates or brakes."""

CHANGE_OVER, LEAST_CHANGE = 0.3, 0.8
"""Time over which an acceleration is measured [s], and the least one that counts [m/s2]."""


class Motion(NamedTuple):
    """How n movers move.

    Attributes:
        turn_rate: Turn rates, shape (n,) [rad/s].
        acceleration: Accelerations, shape (n, 2) [m/s2]; 0 if too small to be measured.
        top: Greatest recent speeds, shape (n,) [m/s].
        belief: Probabilities of the hypotheses, shape (n, 4).
    """

    turn_rate: Array
    acceleration: Array
    top: Array
    belief: Array


class _Past(NamedTuple):
    t: float
    ids: npt.NDArray[np.int64]
    mean: Array
    motion: Motion

    def among(self, ids: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Indices of those of some movers, with ascending numbers, that were stored, and their indices here."""
        at = np.searchsorted(self.ids, ids)
        now = np.flatnonzero(self.ids.take(at, mode="clip") == ids) if len(self.ids) else np.zeros(0, np.intp)
        return now, at[now]

    def of(self, rows: npt.NDArray[np.intp]) -> _Past:
        return _Past(self.t, self.ids[rows], self.mean[rows], Motion(*(column[rows] for column in self.motion)))


class MotionBelief:
    """Memory of the most recent estimates."""

    def __init__(self) -> None:
        self._past: deque[_Past] = deque()

    def update(self, t: float, ids: npt.NDArray[np.int64], mean: Array) -> Motion:
        """Add the present estimates of n movers, and return how they move.

        Args:
            t: Present time [s].
            ids: Numbers of the movers, ascending, shape (n,).
            mean: x, y [m] and their velocities [m/s], shape (n, 4).
        """
        acceleration, score = self._changes(t, ids, mean), np.zeros((len(ids), len(PRIOR)))
        changes = np.abs(acceleration).max(axis=1) > 0.0
        top = self._tops(ids, mean)
        for lag, spread in zip(LAGS, SPREAD, strict=True):
            now, past = self._matched(t - lag, ids)
            if not len(now):
                continue
            ahead, velocity, motion = np.array([t - past.t]), past.mean[:, 2:], past.motion
            straight, turned = np.zeros(len(now)), motion.turn_rate
            for k, moved in enumerate(
                (
                    displaced(velocity, straight, ahead),
                    displaced(velocity, turned, ahead),
                    displaced(velocity, straight, np.zeros(1)),
                    accelerated(velocity, motion.acceleration, motion.top, ahead),
                )
            ):
                error = np.hypot(*(mean[now, :2] - past.mean[:, :2] - moved[:, 0]).T) / spread
                score[now, k] -= 0.5 * np.minimum(error, WORST) ** 2
        belief = np.array(PRIOR) * np.exp(score)
        belief[~changes, CHANGES] = 0.0
        belief /= belief.sum(axis=1, keepdims=True)
        least = np.full((len(ids), len(PRIOR)), LEAST)
        least[~changes, CHANGES] = 0.0
        belief = least + (1.0 - least.sum(axis=1, keepdims=True)) * belief
        found = Motion(self._turns(t, ids, mean), acceleration, top, belief)
        if not self._past or t - self._past[-1].t >= EVERY - 1e-9:
            self._past.append(_Past(t, ids.copy(), mean.copy(), found))
        while t - self._past[0].t > LAGS[-1] + EVERY:
            self._past.popleft()
        return found

    def _turns(self, t: float, ids: npt.NDArray[np.int64], mean: Array) -> Array:
        rates = np.zeros(len(ids))
        now, past = self._matched(t - TURN_OVER, ids)
        (ax, ay), (bx, by) = past.mean[:, 2:].T, mean[now, 2:].T
        sure = (np.hypot(ax, ay) > SLOW) & (np.hypot(bx, by) > SLOW)
        angle = np.where(sure, np.arctan2(ax * by - ay * bx, ax * bx + ay * by), 0.0)
        rates[now] = np.clip(angle / max(t - past.t, EVERY), -MAX_TURN, MAX_TURN)
        return rates

    def _changes(self, t: float, ids: npt.NDArray[np.int64], mean: Array) -> Array:
        """Accelerations along the motion, shape (n, 2) [m/s2]; 0 if small. Those across it are turns."""
        found = np.zeros((len(ids), 2))
        now, past = self._matched(t - CHANGE_OVER, ids)
        before, after = past.mean[:, 2:], mean[now, 2:]
        along = np.where((np.hypot(*before.T) > np.hypot(*after.T))[:, None], before, after)
        along = along / np.maximum(np.hypot(*along.T), 1e-6)[:, None]
        change = ((after - before) * along).sum(axis=1) / max(t - past.t, EVERY)
        found[now] = np.where(np.abs(change) > LEAST_CHANGE, change, 0.0)[:, None] * along
        return found

    def _tops(self, ids: npt.NDArray[np.int64], mean: Array) -> Array:
        top: Array = np.hypot(*mean[:, 2:].T)
        for past in self._past:
            now, before = past.among(ids)
            top[now] = np.maximum(top[now], np.hypot(*past.mean[before, 2:].T))
        return top

    def _matched(self, t: float, ids: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.intp], _Past]:
        """Indices of the present movers that were stored nearest to a time, and what was stored of them."""
        nearest = min(self._past, key=lambda one: abs(one.t - t), default=None)
        if nearest is None or abs(nearest.t - t) > EVERY:
            none = Motion(np.zeros(0), np.zeros((0, 2)), np.zeros(0), np.zeros((0, len(PRIOR))))
            return np.zeros(0, np.intp), _Past(t, np.zeros(0, np.int64), np.zeros((0, 4)), none)
        now, before = nearest.among(ids)
        return now, nearest.of(before)
