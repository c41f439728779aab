"""Localisation error: pose estimates of a robot compared with the simulation's ground truth.

Only this metric reads the ground truth; agents do not. Consistency is the normalised estimation error squared (NEES),
e' P^-1 e / 3. Its mean is 1 for a consistent estimate, larger for an overconfident one, smaller for an underconfident
one. Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 5.4.
"""

from __future__ import annotations

import math

from ..geometry import wrap_angle
from ..record import Localisation
from ..record.track import Curve
from ..record.tracks import Tracks

SIGNALS = ("pose_covariance", "pose")
"""Signals of a robot that localises: covariance of the pose estimate, and the estimate."""


def localisation(tracks: Tracks, agent: str) -> Localisation | None:
    """Errors of the pose estimates of an agent over a run; None for a robot that does not localise.

    Args:
        tracks: Tracks of the run, with the poses and these signals.
        agent: Name of the agent.
    """
    covariances, estimates = (tracks.get(agent, "signal", name) for name in SIGNALS)
    poses = tracks.get(agent, "pose")
    if not (isinstance(covariances, Curve) and isinstance(estimates, Curve) and isinstance(poses, Curve)):
        return None
    distances, angles, consistency = list[float](), list[float](), list[float]()
    for t, covariance in zip(covariances.t, covariances.rows().tolist(), strict=True):
        estimate, truth = estimates.last(t), poses.last(t)
        if estimate is not None and truth is not None:
            (x, y, yaw), (true_x, true_y, true_yaw) = estimate[1], truth[1][:3]
            error = (x - true_x, y - true_y, wrap_angle(yaw - true_yaw))
            distances.append(math.hypot(error[0], error[1]))
            angles.append(abs(error[2]))
            consistency.append(_squared(error, covariance) / 3.0)
    if not distances:
        return None
    return Localisation(
        position_rms=_rms(distances),
        position_max=max(distances),
        heading_rms=_rms(angles),
        heading_max=max(angles),
        nees=sum(consistency) / len(consistency),
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
