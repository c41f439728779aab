"""Movers: what moves around a robot, as estimated from its sensors, and the prediction of where it will be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from ..control.prediction import HYPOTHESES, Prediction, accelerated, displaced
from ..control.walls import follow
from ..control.way_field import WayField
from .signals import Array

MAX_MARGIN = 0.4
"""Maximum standard deviation of a predicted position [m]; beyond it a forecast excludes nothing and only blocks."""


@dataclass(frozen=True, eq=False)
class Movers:
    """Estimates of n movers at one time; whoever tracks them replaces the whole value, with read-only copies of arrays.

    A mover is an object that has been seen to move; it may be standing at present.

    Attributes:
        t: Time of the estimates [s].
        ids: Numbers of the movers, unique during a run, shape (n,).
        mean: x, y [m] and their velocities [m/s], world frame, shape (n, 4).
        covariance: Covariances of `mean`, shape (n, 4, 4).
        radius: Radii [m], shape (n,).
        seen: Times of the last detections [s], shape (n,).
        moves: Whether each mover moves at present, shape (n,).
        turn_rate: Rates at which the velocities turn, left positive, shape (n,) [rad/s].
        acceleration: Accelerations, shape (n, 2) [m/s2]; 0 if too small to be measured.
        top: Greatest recent speeds, shape (n,) [m/s].
        belief: Probabilities of the `HYPOTHESES`, shape (n, 4).
    """

    t: float
    ids: npt.NDArray[np.int64]
    mean: Array
    covariance: Array
    radius: Array
    seen: Array
    moves: npt.NDArray[np.bool_]
    turn_rate: Array
    acceleration: Array
    top: Array
    belief: Array

    def __post_init__(self) -> None:
        for field in fields(self):
            if isinstance(array := getattr(self, field.name), np.ndarray):
                copy = array.copy()
                copy.flags.writeable = False
                object.__setattr__(self, field.name, copy)

    def __len__(self) -> int:
        return len(self.ids)

    @classmethod
    def of(cls, t: float, mean: Array, radius: Array | float = 0.25) -> Movers:
        """Movers that are known exactly, such as those of an oracle or of a test.

        Args:
            t: Time [s].
            mean: x, y [m] and their velocities [m/s], world frame, shape (n, 4).
            radius: Radius of each or of all [m].
        """
        n = len(mean)
        speed, radii, seen = np.hypot(mean[:, 2], mean[:, 3]), np.full(n, 1.0) * radius, np.full(n, t)
        belief, still = np.tile(np.eye(len(HYPOTHESES))[0], (n, 1)), np.zeros((n, 2))
        ids, sure = np.arange(1, n + 1), np.zeros((n, 4, 4))
        return cls(t, ids, mean, sure, radii, seen, speed > 0.0, np.zeros(n), still, speed, belief)

    def predict(self, times: Array | Sequence[float], walls: WayField | None = None) -> Prediction:
        """Predict the motion of all movers, with a row for each possible hypothesis of each mover.

        Args:
            times: Times on the agent's clock, ascending, shape (k,) [s]. A time before `t` counts as `t`.
            walls: Static obstacles: a mover that would walk into one follows it, up to a corner. None for open space.
        """
        times = np.array(times, float)
        ahead = np.maximum(times - self.t, 0.0)
        velocity = self.mean[:, 2:]
        moved = np.zeros((len(HYPOTHESES), len(self), len(ahead), 2))
        moved[0] = velocity[:, None] * ahead[:, None]
        moved[1] = displaced(velocity, self.turn_rate, ahead)
        if self.acceleration.any():
            moved[3] = accelerated(velocity, self.acceleration, self.top, ahead)
        moving, standing = self._spread(ahead), self._spread(np.zeros(1))
        margin = np.minimum([moving, moving, np.broadcast_to(standing, moving.shape), moving], MAX_MARGIN)
        # A mover that turns back has no speed for a moment.
        moves = self.moves | self.acceleration.any(axis=1)
        weight = np.where(moves, self.belief.T, np.eye(len(HYPOTHESES))[:, 2:3])
        kept = weight > 0.0
        hypothesis, mover = np.nonzero(kept)
        start = self.mean[mover, :2]
        positions = start[:, None] + moved[kept]
        if walls is not None:
            follow(walls, start, positions, self.radius[mover])
        return Prediction(
            times=times,
            positions=positions,
            radius=self.radius[mover],
            margin=margin[kept],
            weight=weight[kept],
            owner=self.ids[mover],
            hypothesis=hypothesis,
        )

    def _spread(self, ahead: Array) -> Array:
        """Standard deviation of a position in its least certain direction after times ahead [s], shape (n, k) [m]."""
        c = self.covariance[:, None]
        step = ahead[:, None, None]
        spread = c[..., :2, :2] + step * (c[..., :2, 2:] + c[..., 2:, :2]) + step**2 * c[..., 2:, 2:]
        half, along = 0.5 * (spread[..., 0, 0] + spread[..., 1, 1]), 0.5 * (spread[..., 0, 0] - spread[..., 1, 1])
        largest: Array = np.sqrt(np.maximum(half + np.hypot(along, spread[..., 0, 1]), 0.0))
        return largest
