"""Metrics of following: distance of a robot from its leader (paper, 6.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..record import Following

DRIVES = 0.02
"""The speed of a wheel's rim above which a robot drives [m/s]; one that is pushed while it stands does not."""


class FollowMetrics:
    """The true distance between a follower and its leader, as a run goes on.

    What is asked of a follower are its own parameters: it is within its band, `distance` +- (`distance` - `safety`),
    and never drives nearer than `safety`. It counts from when it is first near enough for its band until the leader has
    reached its goal; how near it drives counts all the time.

    Args:
        parameters: FollowRobot's: `leader`, `distance` and `safety` [m].

    Attributes:
        leader: Whom it follows.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.leader = str(parameters["leader"])
        self._distance = float(parameters["distance"])
        self._safety = float(parameters["safety"])
        self._rows: list[tuple[float, float]] = []
        self._least_driving = math.inf

    def note(self, t: float, own: tuple[float, float], leader: tuple[float, float], rim: float = 0.0) -> None:
        """Note where both are [m] at a time [s], and how fast the follower's fastest rim goes [m/s]."""
        distance = math.dist(own, leader)
        if self._rows or distance <= 2.0 * self._distance - self._safety:
            self._rows.append((t, distance))
        if rim > DRIVES:
            self._least_driving = min(self._least_driving, distance)

    def result(self, until: float | None) -> Following:
        """The metrics.

        Args:
            until: Time at which the leader reached its goal [s]; None if it did not.
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
