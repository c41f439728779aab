"""Metrics from ground-truth poses: distance of a robot from its leader (paper, 6.5), and error of its own estimate.

Agents do not read the ground truth. Consistency is the normalised estimation error squared (NEES), e' P^-1 e / 3. Its
mean is 1 for a consistent estimate, larger for an overconfident one, smaller for an underconfident one. Source:
Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 5.4.
"""

from __future__ import annotations

import math

import numpy as np

from ..base.geometry import wrap_angle
from ..event import TicketChanged
from ..record import Following, Localisation
from ..record.tracks import Tracks

LOCOMOTIONS = 0.02
"""Wheel linear speed above which a robot counts as driving [m/s]; a robot that is pushed does not count."""


def following(tracks: Tracks, ticket: TicketChanged, until: float | None) -> Following:
    """Ground-truth distance between a follower and its leader over a run.

    The follow band is the interval `distance` +- (`distance` - `safety`), from the parameters of FollowRobot. Distances
    are counted from the time at which the follower first is not beyond the band, until the leader reaches its goal. The
    minimum distance while driving is that of the whole run.

    Args:
        tracks: Tracks of the run, with the poses.
        ticket: First ticket of FollowRobot, with its parameters `leader`, `distance` [m] and `safety` [m].
        until: Time at which the leader reached its goal [s]; None if the leader did not.
    """
    leader, wanted, safety = (ticket.parameters[name] for name in ("leader", "distance", "safety"))
    wanted, slack = float(wanted), float(wanted) - float(safety)  # type: ignore[arg-type]  # numbers, by their action
    kept, driving = list[float](), math.inf
    begun = False
    for t, distance, speed in _distances(tracks, ticket.agent, str(leader), ticket.t):
        begun = begun or distance <= wanted + slack
        if begun and (until is None or t <= until):
            kept.append(distance)
        if speed > LOCOMOTIONS:
            driving = min(driving, distance)
    return Following(
        leader=str(leader),
        periods=len(kept),
        mean_distance=_mean(kept),
        distance_error=_mean([abs(d - wanted) for d in kept]),
        in_band=_mean([abs(d - wanted) <= slack for d in kept]),
        too_far=_mean([d > wanted + slack for d in kept]),
        least_distance=min(kept, default=None),
        least_driving=driving if math.isfinite(driving) else None,
        safe=driving >= float(safety),  # type: ignore[arg-type]
    )


def _distances(tracks: Tracks, agent: str, leader: str, after: float) -> list[tuple[float, float, float]]:
    """Times [s], distances from the leader [m] and largest wheel linear speeds [m/s] of a follower after a time."""
    own, other, wheels = (tracks.curve(*key) for key in ((agent, "pose"), (leader, "pose"), (agent, "wheels")))
    found: list[tuple[float, float, float]] = []
    for t, (x, y, *_) in zip(own.t, own.rows().tolist(), strict=True):
        if t > after and (pose := other.last(t)) is not None:
            speeds = wheels.last(t)
            speed = 0.0 if speeds is None else max(map(abs, speeds[1]), default=0.0)
            found.append((t, math.dist((x, y), pose[1][:2]), speed))
    return found


def _mean(values: list[float] | list[bool]) -> float | None:
    return sum(values) / len(values) if values else None


SIGNALS = ("pose_covariance", "pose")
"""Signals of a robot that localises: covariance of the pose estimate, and the estimate."""


def localisation(tracks: Tracks, agent: str) -> Localisation | None:
    """Errors of the pose estimates of an agent over a run; None for a robot that does not localise."""
    covariances, estimates = (tracks.curve(agent, "signal", name) for name in SIGNALS)
    poses = tracks.curve(agent, "pose")
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
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = covariance
    matrix += np.triu(matrix, 1).T
    return float(np.array(error) @ np.linalg.solve(matrix, np.array(error)))
