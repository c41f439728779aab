"""How well a robot that localises knows where it is: its own estimates beside the simulation's truth.

The truth is read here and never by the mind. Consistency is the normalised estimation error squared, e' P^-1 e / 3:
its mean is 1 for an estimate that is as sure as it should be, above for one that is too sure, below for one that is
not sure enough. Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation
(2001), 5.4.
"""

from __future__ import annotations

import math

from ..event import BodyMoved, SignalsWritten
from ..geometry import wrap_angle
from ..record import Localisation

COVARIANCE, POSE = "pose_covariance", "pose"
"""The signals that tell of a robot that it localises, and where it thinks it is."""


class LocalisationError:
    """Collects one agent's errors, an estimate at a time."""

    def __init__(self) -> None:
        self._truth: BodyMoved | None = None
        self._away: list[float] = []  # [m]
        self._aside: list[float] = []  # [rad]
        self._consistency: list[float] = []

    def moved(self, event: BodyMoved) -> None:
        """Where the robot truly is."""
        self._truth = event

    def estimated(self, event: SignalsWritten) -> None:
        """What its mind wrote; only estimates with a covariance count."""
        if COVARIANCE not in event.signals or (truth := self._truth) is None:
            return
        values = event.values
        (x, y, yaw), covariance = values[POSE], values[COVARIANCE]
        error = (x - truth.x, y - truth.y, wrap_angle(yaw - truth.yaw))
        self._away.append(math.hypot(error[0], error[1]))
        self._aside.append(abs(error[2]))
        self._consistency.append(_squared(error, covariance) / 3.0)

    def result(self) -> Localisation | None:
        """The errors; None for a robot that does not localise."""
        if not self._away:
            return None
        return Localisation(
            position_rms=_rms(self._away),
            position_max=max(self._away),
            heading_rms=_rms(self._aside),
            heading_max=max(self._aside),
            nees=sum(self._consistency) / len(self._consistency),
        )


def _rms(values: list[float]) -> float:
    return math.sqrt(sum(v * v for v in values) / len(values))


def _squared(error: tuple[float, float, float], covariance: list[float]) -> float:
    """The squared error over the covariance P, e' P^-1 e, with P given by its upper half."""
    import numpy as np

    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = covariance
    matrix += np.triu(matrix, 1).T
    return float(np.array(error) @ np.linalg.solve(matrix, np.array(error)))
