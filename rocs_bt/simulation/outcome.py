"""How an agent did: exactly one outcome, from the simulation's truth (docs/architecture.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from ..errors import BlockError
from ..geometry import Pose2
from .progress import ProgressWatch

OUTCOMES = ("error", "collision", "success", "failed", "stuck", "interrupted", "timeout")
"""All outcomes; an agent has the first one that applies."""


@dataclass(frozen=True)
class Goal:
    """Where an agent must truly be: a place's name, position and tolerance [m]."""

    name: str
    pose: Pose2
    tolerance: float


@dataclass(frozen=True)
class Verdict:
    """An outcome, why, and when the mission's goal was reached [s]; None if it was not."""

    outcome: str
    reason: str
    time_to_goal: float | None


class AgentState(Protocol):
    """What a judge asks an agent."""

    @property
    def status(self) -> str:
        """The mission's: RUNNING, SUCCESS or FAILURE."""
        ...

    @property
    def reason(self) -> str:
        """Why the mission failed; empty while it did not."""
        ...

    @property
    def failure(self) -> BlockError | None:
        """The block that failed; None while all is well."""
        ...

    @property
    def reflex(self) -> str:
        """Rule of the active reflex; empty while none is active."""
        ...

    @property
    def held(self) -> bool:
        """Whether an action of the plan waits for the end of that reflex."""
        ...

    def reading(self, rule: str) -> str:
        """Guard of a rule with the values of its last firing."""
        ...


class Judge:
    """Watches one agent, a control period at a time.

    Args:
        goal: The scenario's goal check; None where the mission's word is enough.
        at_end: Whether the goal check counts when the run ends, whatever the mission says: for one that never ends.
        after: Goals to be reached before, each with its deadline [s]; a missed deadline is a `timeout`.
        end_on_collision: Whether a collision decides at once.
        end_on_stuck: Whether no progress decides at once; if not, it does only if it lasts until the end of the run.

    Attributes:
        stuck: Why the robot is stuck now; empty while it is not.
        stuck_rule: Rule whose reflexes held it longest; empty if there is none.
        decided: Whether nothing that may still come can matter.
    """

    def __init__(
        self,
        goal: Goal | None = None,
        *,
        at_end: bool = False,
        after: Sequence[tuple[Goal, float]] = (),
        end_on_collision: bool = False,
        end_on_stuck: bool = True,
    ) -> None:
        self.stuck = ""
        self.stuck_rule = ""
        self._end_on_stuck = end_on_stuck
        self._goal = goal
        self._at_end = at_end
        self._after = list(after)
        self._end_on_collision = end_on_collision
        self._found: dict[str, str] = {}
        self._progress = ProgressWatch()
        self._mission = "RUNNING"
        self._distance = math.inf
        self.time_to_goal: float | None = None
        self.decided = False

    def update(
        self, t: float, pose: Pose2, agent: AgentState, *, commanded: bool, collisions: Sequence[str] = ()
    ) -> bool:
        """Look at one control period.

        Args:
            t: The time [s].
            pose: Where the robot truly is.
            agent: Its agent.
            commanded: Whether it is asked to move.
            collisions: What it ran into since the last time.

        Returns:
            Whether the outcome is decided.
        """
        self._mission = agent.status
        self._distance = math.inf if self._goal is None else pose.distance(self._goal.pose)
        self.look_for_failure(agent)
        for other in collisions:
            self._note("collision", f"it ran into {other} at {t:.2f} s", decides=self._end_on_collision)
        self._visit(t, pose)
        there = not self._after and (self._goal is None or self._at_goal)
        succeeded = there and agent.status == "SUCCESS"
        if self.time_to_goal is None and (succeeded or (there and self._at_end)):
            self.time_to_goal = t
        if succeeded and not self._at_end:
            self._note("success", "", decides=True)
        elif agent.status == "FAILURE":
            self._note("failed", f"the mission failed: {agent.reason or 'without a reason'}", decides=True)
        self._watch_progress(t, pose, agent, commanded)
        return self.decided

    def look_for_failure(self, agent: AgentState) -> None:
        """A failed block or actuator is an `error`, also one that fails when the robot is stopped at its end."""
        if agent.failure is not None:
            self._note("error", str(agent.failure), decides=True)

    def move_goal(self, name: str, pose: Pose2) -> None:
        """From now on the goal of that name is elsewhere; nothing changes for a judge of another one."""
        if self._goal is not None and self._goal.name == name:
            self._goal = replace(self._goal, pose=pose)
        self._after = [(replace(g, pose=pose) if g.name == name else g, by) for g, by in self._after]

    def fail(self, reason: str) -> None:
        """End the run as an `error` that no block of the agent answers for; a decided outcome stays."""
        if not self.decided:
            self._note("error", reason, decides=True)

    def interrupt(self, reason: str) -> None:
        """End the run early, as a signal or a person does; a decided outcome stays."""
        if not self.decided:
            self._note("interrupted", reason, decides=True)

    def verdict(self) -> Verdict:
        """The outcome as things stand."""
        found = {"stuck": self.stuck, **self._found} if self.stuck else self._found
        for outcome in OUTCOMES:
            if outcome in found:
                return Verdict(outcome, found[outcome], self.time_to_goal)
        if self._at_end and self._at_goal and not self._after:
            return Verdict("success", "", self.time_to_goal)
        return Verdict("timeout", self._why_not(), None)

    @property
    def _at_goal(self) -> bool:
        return self._goal is not None and self._distance <= self._goal.tolerance

    def _note(self, outcome: str, reason: str, *, decides: bool) -> None:
        self._found.setdefault(outcome, reason)
        self.decided = self.decided or decides

    def _visit(self, t: float, pose: Pose2) -> None:
        """Strike off the goals that are reached; a missed deadline decides."""
        self._after = [(goal, by) for goal, by in self._after if pose.distance(goal.pose) > goal.tolerance]
        for goal, by in self._after:
            if t > by:
                self._note("timeout", f"it was not at '{goal.name}' by {by:g} s", decides=True)

    def _watch_progress(self, t: float, pose: Pose2, agent: AgentState, commanded: bool) -> None:
        """Decide where the robot makes no progress; it needs none where only its place at the end counts."""
        arrived = self._at_end and not self._after and self._at_goal
        watch, held = self._progress, agent.held and not arrived
        stuck = watch.update(t, pose, commanded=commanded and not arrived, reflex=agent.reflex, held=held)
        self.stuck, self.stuck_rule = (watch.reason(pose, agent.reading), watch.rule) if stuck else ("", "")
        if stuck and self._end_on_stuck:
            self._note("stuck", self.stuck, decides=True)

    def _why_not(self) -> str:
        if self._goal is None:
            return f"the mission is still {self._mission}"
        if self._after:
            return f"it never was at {', '.join(repr(goal.name) for goal, _ in self._after)}"
        where = f"{self._distance:.2f} m from '{self._goal.name}'"
        if self._at_end and self.time_to_goal is not None:
            return f"it came to '{self._goal.name}' at {self.time_to_goal:.1f} s, but at the end it is {where}"
        if self._mission == "SUCCESS":
            return f"the mission says SUCCESS, but it is {where}, whose tolerance is {self._goal.tolerance:g} m"
        return f"the mission is still {self._mission}, {where}"
