"""How a robot that follows another keeps its distance (paper, 6.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


class Leash:
    """The true distance between a follower and its leader, as a run goes on.

    It counts from when the follower is first within its band, `distance` +- (`distance` - `safety`), until the leader
    has reached its goal.

    Args:
        parameters: FollowRobot's: `leader`, `distance` and `safety` [m].

    Attributes:
        leader: Whom it follows.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.leader = str(parameters["leader"])
        self._distance = float(parameters["distance"])
        self._slack = self._distance - float(parameters["safety"])
        self._rows: list[tuple[float, float]] = []

    def note(self, t: float, own: tuple[float, float], leader: tuple[float, float]) -> None:
        """Note where both are [m] at a time [s]."""
        error = math.dist(own, leader) - self._distance
        if self._rows or error <= self._slack:
            self._rows.append((t, error))

    def figures(self, until: float | None) -> dict[str, Any]:
        """What came of it.

        Args:
            until: When the leader had reached its goal [s]; None where it did not.

        Returns:
            The leader, the mean of the distance's absolute error [m], and the share of the time within the band; None
            where the follower was never within it.
        """
        errors = [error for t, error in self._rows if until is None or t <= until]
        count = len(errors)
        return {
            "leader": self.leader,
            "distance_error": sum(map(abs, errors)) / count if count else None,
            "in_band": sum(abs(e) <= self._slack for e in errors) / count if count else None,
        }
