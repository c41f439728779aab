"""Scheduled facts: knowledge that a scenario gives its agents during the run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ..agent import Agent, add_facts
from ..base.geometry import Pose2
from ..catalog import FactSpec, ScenarioSpec
from ..event import EventSink, NullSink, ScriptActed
from .outcome import Goal, Judge
from .simulated_world import SimulatedWorld

_SAME = 1e-9  # [s]


class FactSchedule:
    """Writes each scheduled fact to the Knowledge of one agent when its time has come."""

    def __init__(
        self,
        agent: Agent,
        facts: Sequence[FactSpec],
        placed: Callable[[str, Pose2], None] = lambda node, pose: None,
        sink: EventSink | None = None,
    ) -> None:
        self._sink = sink or NullSink()
        self._agent = agent
        self._coming = deque(facts)
        self._placed = placed

    def step(self, t: float) -> None:
        """Write the facts that are due at time t [s]."""
        due = []
        while self._coming and self._coming[0].at <= t + _SAME:
            due.append(self._coming.popleft())
        if not due:
            return
        add_facts(self._agent.knowledge, due)
        for fact in due:
            what, name = f"the agent is given the fact {fact.node}", self._agent.name
            self._sink.emit(ScriptActed(t=t, agent=name, topic="fact", name=fact.node, what=what))
            if (pose := self._agent.knowledge.world.pose_of(fact.node)) is not None:
                self._placed(fact.node, pose)


def fact_schedules(
    scenario: ScenarioSpec, agents: Sequence[Agent], simulated: SimulatedWorld | None = None
) -> list[FactSchedule]:
    """Create the schedules of the agents to which the scenario gives facts during the run.

    Args:
        scenario: The scenario.
        agents: Agents of the scenario.
        simulated: Simulated world. If a fact gives a goal a new pose, the judge of the outcome uses the new pose too.
            None if no outcome is determined, as in a replay.
    """
    found = []
    for agent in agents:
        later = sorted((fact for fact in scenario.facts_of(agent.name) if fact.at), key=lambda fact: fact.at)
        if later and simulated is None:
            found.append(FactSchedule(agent, later))
        elif later and simulated is not None:
            goals: Mapping[str, list[Goal]] = simulated.goals
            mover = _mover(simulated.judges[agent.name], goals[agent.name])
            found.append(FactSchedule(agent, later, mover, simulated.sink))
    return found


def _mover(judge: Judge, goals: list[Goal]) -> Callable[[str, Pose2], None]:
    """Create a function that gives a goal of one agent a new pose, in the simulation and for the agent's judge."""

    def move(node: str, pose: Pose2) -> None:
        for i, goal in enumerate(goals):
            if goal.name == node and pose != goal.pose:
                goals[i] = replace(goal, pose=pose)
                judge.move_goal(node, pose)

    return move
