"""Localisation error: pose estimates of a robot compared with the simulation's ground truth.

Only this metric reads the ground truth; agents do not. Consistency is the normalised estimation error squared (NEES),
e' P^-1 e / 3. Its mean is 1 for a consistent estimate, larger for an overconfident one, smaller for an underconfident
one. Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 5.4.
"""

from __future__ import annotations

import math

from ..event import BodyMoved, SignalsWritten
from ..geometry import wrap_angle
from ..record import Localisation

COVARIANCE, POSE = "pose_covariance", "pose"
"""Signals of a robot that localises: covariance of the pose estimate, and the estimate."""


class LocalisationError:
    """Localisation errors of one agent over a run."""

    def __init__(self) -> None:
        self._ground_truth: BodyMoved | None = None
        self._position_errors: list[float] = []  # [m]
        self._heading_errors: list[float] = []  # [rad]
        self._consistency: list[float] = []

    def moved(self, event: BodyMoved) -> None:
        """Store the ground-truth pose of the robot."""
        self._ground_truth = event

    def estimated(self, event: SignalsWritten) -> None:
        """Compare a pose estimate of the agent with the ground truth; estimates without a covariance are ignored."""
        if COVARIANCE not in event.signals or (truth := self._ground_truth) is None:
            return
        values = event.values
        (x, y, yaw), covariance = values[POSE], values[COVARIANCE]
        error = (x - truth.x, y - truth.y, wrap_angle(yaw - truth.yaw))
        self._position_errors.append(math.hypot(error[0], error[1]))
        self._heading_errors.append(abs(error[2]))
        self._consistency.append(_squared(error, covariance) / 3.0)

    def result(self) -> Localisation | None:
        """Error statistics of the run; None for a robot that does not localise."""
        if not self._position_errors:
            return None
        return Localisation(
            position_rms=_rms(self._position_errors),
            position_max=max(self._position_errors),
            heading_rms=_rms(self._heading_errors),
            heading_max=max(self._heading_errors),
            nees=sum(self._consistency) / len(self._consistency),
        )


def _rms(values: list[float]) -> float:
    return math.sqrt(sum(v * v for v in values) / len(values))


def _squared(error: tuple[float, float, float], covariance: list[float]) -> float:
    """Squared Mahalanobis distance e' P^-1 e.

    Args:
        error: Error e: x [m], y [m], yaw [rad].
        covariance: Upper triangle of the covariance P, row by row, 6 values.
    """
    import numpy as np

    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = covariance
    matrix += np.triu(matrix, 1).T
    return float(np.array(error) @ np.linalg.solve(matrix, np.array(error)))
