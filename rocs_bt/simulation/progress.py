"""Detection of a robot that makes no progress (docs/architecture.md, outcomes)."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..base.geometry import Pose2
from .reflex_time import ReflexTime

PROGRESS = 0.05
"""Distance from the position of the last progress that counts as progress [m]."""

PATIENCE = 15.0
"""Time without progress after which a robot counts as stuck [s]; time in which it does not try to move is ignored."""

_SLACK = 1e-9  # [s] rounding tolerance of summed periods


class ProgressWatch:
    """Timer of the time without progress, reset whenever the robot has moved by `PROGRESS`.

    The timer runs while the robot is commanded to move, or while a reflex holds an action of the plan. The timer pauses
    while the plan itself waits, even if a reflex is active.
    """

    def __init__(self) -> None:
        self._anchor: tuple[Pose2, float] | None = None  # with the height [m]
        self._last: float | None = None
        self._trying = 0.0
        self._reflexes = ReflexTime()  # since the last progress

    def update(self, t: float, pose: Pose2, z: float, *, commanded: bool, reflex: str, held: bool) -> bool:
        """Process one control period; returns True if the robot is stuck.

        Args:
            t: Time [s].
            pose: Pose of the robot, world frame; NaN if unknown.
            z: Height of the robot [m]; NaN for progress in the plane.
            commanded: Whether the robot is commanded to move.
            reflex: Rule of the active reflex; empty if none is active.
            held: Whether an action of the plan waits for the end of that reflex.
        """
        passed, self._last = 0.0 if self._last is None else t - self._last, t
        if not math.isfinite(pose.x):  # on hardware the pose may be unknown, and so is the progress
            return False
        if self._anchor is None or _distance(self._anchor, pose, z) >= PROGRESS:
            self._anchor, self._trying = (pose, z), 0.0
            self._reflexes.clear()
        elif commanded or held:
            self._trying += passed
            self._reflexes.add(reflex, passed)
        return self._trying >= PATIENCE - _SLACK

    @property
    def rule(self) -> str:
        """Name of the rule that was active for the longest time since the last progress; empty if none was."""
        return self._reflexes.rule

    def reason(self, pose: Pose2, reading: Callable[[str], str]) -> str:
        """Explain why the robot counts as stuck, with its position and the rule that held it."""
        where = f"it moved less than {PROGRESS} m in {PATIENCE:g} s near x = {pose.x:.2f} m, y = {pose.y:.2f} m"
        held = self._reflexes.text(reading)
        return f"{where}, held by {held}" if held else where


def _distance(anchor: tuple[Pose2, float], pose: Pose2, z: float) -> float:
    """Distance from an anchor [m], in space if both heights are known."""
    planar, rise = pose.distance(anchor[0]), z - anchor[1]
    return planar if math.isnan(rise) else math.hypot(planar, rise)
