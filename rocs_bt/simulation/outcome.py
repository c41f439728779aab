"""Outcome of an agent: exactly one per run, such as `success` or `collision` (docs/architecture.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from ..base.errors import BlockError
from ..base.geometry import Pose2
from .fall import FallWatch
from .progress import ProgressWatch
from .reflex_time import ReflexTime

OUTCOMES = ("error", "collision", "fell", "success", "failed", "stuck", "interrupted", "timeout")
"""All outcomes in order of precedence: the outcome of an agent is the first that applies."""

HELD = 0.25
"""Share of the time in which reflexes held the robot, from which the reason of a timeout or failure names the rule."""


@dataclass(frozen=True)
class Goal:
    """Goal that an agent must reach, according to the ground truth.

    Attributes:
        name: Name of the place.
        pose: Pose of the place, world frame.
        tolerance: Maximum distance from the place at which the goal counts as reached [m].
        z: Height of the place, world frame [m]; None to measure distances in the plane.
        height_tolerance: Maximum height difference from the place [m]; `tolerance` then refers to the distance in the
            plane. None if `tolerance` refers to the distance in space.
    """

    name: str
    pose: Pose2
    tolerance: float
    z: float | None = None
    height_tolerance: float | None = None

    def reached(self, pose: Pose2, z: float) -> bool:
        """Whether a robot is at the place; arguments as for `distance`."""
        if self.height_tolerance is None or self.z is None or math.isnan(z):
            return self.distance(pose, z) <= self.tolerance
        return pose.distance(self.pose) <= self.tolerance and abs(z - self.z) <= self.height_tolerance

    @property
    def limits(self) -> str:
        """Tolerances in words."""
        height = f", in height {self.height_tolerance:g} m" if self.height_tolerance is not None else ""
        return f"tolerance {self.tolerance:g} m{height}"

    def distance(self, pose: Pose2, z: float) -> float:
        """Distance of a robot from the place [m], in space if the place has a height.

        Args:
            pose: Pose of the robot, world frame.
            z: Height of the robot's base, world frame [m]; NaN if unknown.
        """
        planar = pose.distance(self.pose)
        return planar if self.z is None or math.isnan(z) else math.hypot(planar, z - self.z)


@dataclass(frozen=True)
class AgentOutcome:
    """Outcome of an agent.

    Attributes:
        outcome: One of `OUTCOMES`.
        reason: Reason of the outcome; empty for `success`.
        time_to_goal: Time at which the goal was reached [s]; None if the goal was not reached.
        fell: Whether the robot fell, also if `outcome` is one of higher precedence.
    """

    outcome: str
    reason: str
    time_to_goal: float | None
    fell: bool = False


class AgentState(Protocol):
    """State of an agent, from which a judge determines the outcome of its run."""

    @property
    def status(self) -> str:
        """Status of the mission: RUNNING, SUCCESS or FAILURE."""

    @property
    def reason(self) -> str:
        """Reason of the mission's failure; empty if it has not failed."""

    @property
    def failure(self) -> BlockError | None:
        """First block failure; None if no block failed."""

    @property
    def running(self) -> str:
        """What the mission is doing and for how long; empty if unknown."""

    @property
    def reflex(self) -> str:
        """Rule of the active reflex; empty if no reflex is active."""

    @property
    def held(self) -> bool:
        """Whether an action of the plan waits for the end of the active reflex."""

    @property
    def waiting(self) -> bool:
        """Whether the active reflex waits for something outside of the robot, such as a person."""

    def reading(self, rule: str) -> str:
        """Guard values of a rule's last firing."""


class Judge:
    """Determines the outcome of one agent, such as `success` or `collision`; updated once per control period.

    Args:
        goal: Goal that the robot must reach for success; None if the status of the mission is sufficient.
        at_end: Whether success means that the robot is at the goal at the end of the run, whatever the mission's
            status; for missions that never end.
        after: Goals to reach before `goal`, each with its deadline [s]; a missed deadline is a `timeout`.
        end_on_collision: Whether a collision decides the outcome immediately.
        end_on_stuck: Whether a lack of progress decides the outcome immediately. If not, a lack of progress counts only
            if it lasts until the end of the run.
        start: Time of the start of the run, from which `time_to_goal` counts [s].

    Attributes:
        running: Leaf that ran at the end, with its duration, for the reason of a timeout; empty if unknown.
        stuck: Reason why the robot counts as stuck now; empty if it is not stuck.
        stuck_rule: Rule with the reflexes that held the stuck robot longest; empty if there is none.
        time_to_goal: Time from the start at which the goal was reached [s]; None before that.
        decided: Whether the outcome is final.
    """

    def __init__(
        self,
        goal: Goal | None = None,
        *,
        at_end: bool = False,
        after: Sequence[tuple[Goal, float]] = (),
        end_on_collision: bool = False,
        end_on_stuck: bool = True,
        start: float = 0.0,
    ) -> None:
        self._start = start
        self.running = ""
        self.stuck = ""
        self.stuck_rule = ""
        self._end_on_stuck = end_on_stuck
        self._goal = goal
        self._at_end = at_end
        self._after = list(after)
        self._end_on_collision = end_on_collision
        self._found: dict[str, str] = {}
        self._progress = ProgressWatch()
        self._reflexes = ReflexTime()
        self._reading: Callable[[str], str] = lambda rule: ""
        self._now = start
        self._fall = FallWatch()
        self._mission = "RUNNING"
        self._distance = math.inf
        self._at_goal = False
        self.time_to_goal: float | None = None
        self.decided = False

    def update(
        self,
        t: float,
        pose: Pose2,
        agent: AgentState,
        *,
        commanded: bool,
        collisions: Sequence[str] = (),
        tilt: float = 0.0,
        ground: str = "",
        z: float = math.nan,
        paused: bool = False,
    ) -> bool:
        """Process one control period.

        Args:
            t: Time [s].
            pose: True pose of the robot, world frame.
            agent: State of the agent.
            commanded: Whether the robot is commanded to move.
            collisions: Names of the obstacles that the robot ran into since the last update.
            tilt: True tilt of the robot [rad].
            ground: Geom of the robot that touches the ground and should not; empty if there is none.
            z: True height of the robot's base, world frame [m]; NaN if unknown.
            paused: Whether the robot is held in neutral, such as by an emergency stop, so that no progress is due.

        Returns:
            Whether the outcome is decided.
        """
        self._watch_reflexes(t, agent)
        self._mission = agent.status
        self._distance = math.inf if self._goal is None else self._goal.distance(pose, z)
        self._at_goal = self._goal is not None and self._goal.reached(pose, z)
        self.check_failure(agent)
        for other in collisions:
            self._note("collision", f"it ran into {other} at {t:.2f} s", decides=self._end_on_collision)
        if self._fall.update(t, tilt, ground):
            self._note("fell", self._fall.reason, decides=True)
        self._visit(t, pose, z)
        there = not self._after and (self._goal is None or self._at_goal)
        succeeded = there and agent.status == "SUCCESS"
        if self.time_to_goal is None and (succeeded or (there and self._at_end)):
            self.time_to_goal = t - self._start
        if succeeded and not self._at_end:
            self._note("success", "", decides=True)
        elif agent.status == "FAILURE":
            reason = f"the mission failed: {agent.reason or 'without a reason'}"
            self._note("failed", _joined(reason, self._held()), decides=True)
        self._watch_progress(t, pose, z, agent, commanded, paused)
        return self.decided

    def check_failure(self, agent: AgentState) -> None:
        """If a block or actuator of the agent has failed, set the outcome `error`; call it after the final stop too."""
        if agent.failure is not None:
            self._note("error", str(agent.failure), decides=True)

    def move_goal(self, name: str, pose: Pose2) -> None:
        """Move the goal of this name; a judge without such a goal ignores the call.

        Args:
            name: Name of the goal.
            pose: New pose, world frame.
        """
        if self._goal is not None and self._goal.name == name:
            self._goal = replace(self._goal, pose=pose)
        self._after = [(replace(g, pose=pose) if g.name == name else g, by) for g, by in self._after]

    def fail(self, reason: str) -> None:
        """Set the outcome `error` for a failure outside of the agent's blocks; a decided outcome remains."""
        if not self.decided:
            self._note("error", reason, decides=True)

    def interrupt(self, reason: str) -> None:
        """Set the outcome `interrupted` for a run that a signal or a person ends early; a decided outcome remains."""
        if not self.decided:
            self._note("interrupted", reason, decides=True)

    def verdict(self) -> AgentOutcome:
        """Outcome at the present time."""
        lasting = {outcome: why for outcome, why in (("stuck", self.stuck), ("fell", self._fall.reason)) if why}
        found = {**lasting, **self._found}
        for outcome in OUTCOMES:
            if outcome in found:
                return AgentOutcome(outcome, found[outcome], self.time_to_goal, "fell" in found)
        if self._at_end and self._at_goal and not self._after:
            return AgentOutcome("success", "", self.time_to_goal)
        return AgentOutcome("timeout", _joined(self._why_not(), self._held(), self.running), None)

    def _note(self, outcome: str, reason: str, *, decides: bool) -> None:
        self._found.setdefault(outcome, reason)
        self.decided = self.decided or decides

    def _visit(self, t: float, pose: Pose2, z: float) -> None:
        """Remove reached goals from `after`; a missed deadline decides the outcome."""
        self._after = [(goal, by) for goal, by in self._after if not goal.reached(pose, z)]
        for goal, by in self._after:
            if t > by:
                late = f"it was not at '{goal.name}' by {by:g} s"
                self._note("timeout", _joined(late, self._held()), decides=True)

    def _watch_reflexes(self, t: float, agent: AgentState) -> None:
        passed, self._now, self._reading = t - self._now, t, agent.reading
        if agent.held:
            self._reflexes.add(agent.reflex, passed)

    def _held(self) -> str:
        """Part of a reason about the reflexes that held the robot, if they did for a large part of the time."""
        took, total = self._now - self._start, self._reflexes.total
        if total <= HELD * took:
            return ""
        rules = self._reflexes.text(self._reading)
        return f"reflexes held it for {total:.1f} s of {took:.1f} s ({100.0 * total / max(took, 1e-9):.0f} %): {rules}"

    def _watch_progress(
        self, t: float, pose: Pose2, z: float, agent: AgentState, commanded: bool, paused: bool
    ) -> None:
        """Check the progress of the robot.

        None is required while a rule waits as planned, and at the goal if success means staying there (`at_end`).
        """
        due = not paused and not agent.waiting and not (self._at_end and not self._after and self._at_goal)
        watch, held = self._progress, agent.held and due
        stuck = watch.update(t, pose, z, commanded=commanded and due, reflex=agent.reflex, held=held)
        self.stuck, self.stuck_rule = (watch.reason(pose, agent.reading), watch.rule) if stuck else ("", "")
        if stuck and self._end_on_stuck:
            self._note("stuck", self.stuck, decides=True)

    def _why_not(self) -> str:
        if self._goal is None:
            return f"the mission is still {self._mission}"
        if self._after:
            return f"it never reached {', '.join(repr(goal.name) for goal, _ in self._after)}"
        away = f"{self._distance:.2f} m from '{self._goal.name}'"
        if self._at_end and self.time_to_goal is not None:
            return f"it reached '{self._goal.name}' at {self.time_to_goal:.1f} s, but at the end it is {away}"
        if self._mission == "SUCCESS":
            return f"the mission returned SUCCESS, but it is {away} ({self._goal.limits})"
        return f"the mission is still {self._mission}, {away}"


def _joined(*parts: str) -> str:
    return "; ".join(filter(None, parts))
