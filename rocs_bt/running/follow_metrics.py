"""Metrics of following: distance of a robot from its leader (paper, 6.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..record import Following

LOCOMOTIONS = 0.02
"""Wheel linear speed above which a robot counts as driving [m/s]; a robot that is pushed does not count."""


class FollowMetrics:
    """Ground-truth distance between a follower and its leader over a run.

    The follow band is the interval `distance` +- (`distance` - `safety`), from the parameters of FollowRobot. Distances
    are counted from the time at which the follower first is not beyond the band, until the leader reaches its goal. The
    minimum distance while driving is that of the whole run.

    Args:
        parameters: Parameters of FollowRobot: `leader`, `distance` [m] and `safety` [m].

    Attributes:
        leader: Name of the leader.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.leader = str(parameters["leader"])
        self._distance = float(parameters["distance"])
        self._safety = float(parameters["safety"])
        self._rows: list[tuple[float, float]] = []
        self._least_driving = math.inf

    def note(self, t: float, own: tuple[float, float], leader: tuple[float, float], wheel_speed: float = 0.0) -> None:
        """Add a sample.

        Args:
            t: Time [s].
            own: Position of the follower [m], world frame.
            leader: Position of the leader [m], world frame.
            wheel_speed: Largest absolute wheel linear speed of the follower [m/s].
        """
        distance = math.dist(own, leader)
        if self._rows or distance <= 2.0 * self._distance - self._safety:
            self._rows.append((t, distance))
        if wheel_speed > LOCOMOTIONS:
            self._least_driving = min(self._least_driving, distance)

    def result(self, until: float | None) -> Following:
        """Metrics of the run.

        Args:
            until: Time at which the leader reached its goal [s]; None if the leader did not.
        """
        kept = [distance for t, distance in self._rows if until is None or t <= until]
        slack = self._distance - self._safety
        return Following(
            leader=self.leader,
            periods=len(kept),
            mean_distance=_mean(kept),
            distance_error=_mean([abs(d - self._distance) for d in kept]),
            in_band=_mean([abs(d - self._distance) <= slack for d in kept]),
            too_far=_mean([d > self._distance + slack for d in kept]),
            least_distance=min(kept, default=None),
            least_driving=self._least_driving if math.isfinite(self._least_driving) else None,
            safe=self._least_driving >= self._safety,
        )


def _mean(values: list[float] | list[bool]) -> float | None:
    return sum(values) / len(values) if values else None
