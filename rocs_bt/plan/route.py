"""Route planners: ways from here to there, around what is known to stand there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ..geometry import Pose2
from ..knowledge import Knowledge

Point = tuple[float, float]
"""x and y in the world frame [m]."""


class NoRoute(Exception):
    """There is no way; the message tells what is in it, as a planner raises it."""


class RoutePlanner(ABC):
    """Finds ways for one robot. A file in `planners/routes` holds one such class, and missions name the file.

        class Straight(RoutePlanner):
            def route(self, start, goal, clearance):
                return [start[:2], goal[:2]]

    Args:
        knowledge: All that the robot knows.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.knowledge = knowledge

    @abstractmethod
    def route(self, start: Pose2, goal: Pose2, clearance: float) -> Sequence[Point]:
        """The corners of a way, the first of them the start's position and the last the goal's. Must not block.

        Args:
            start: In the world frame.
            goal: In the world frame.
            clearance: What to keep at least between the robot's hull, however it turns, and what is known [m].

        Raises:
            NoRoute: There is none.
        """
