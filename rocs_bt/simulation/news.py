"""News: facts that a scenario's agents are told during the run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ..agent import Agent, tell_facts
from ..catalog import FactSpec, ScenarioSpec
from ..geometry import Pose2
from .outcome import Goal, Judge
from .stage import Stage

_SAME = 1e-9  # [s]


class News:
    """Tells one agent each fact when its time has come.

    Args:
        agent: Who is told.
        facts: What, in the order of their times.
        placed: Called with each node that was told of and where it is from then on.
    """

    def __init__(
        self, agent: Agent, facts: Sequence[FactSpec], placed: Callable[[str, Pose2], None] = lambda node, pose: None
    ) -> None:
        self._agent = agent
        self._coming = deque(facts)
        self._placed = placed

    def step(self, t: float) -> None:
        """Tell what is due at time t [s]."""
        due = []
        while self._coming and self._coming[0].at <= t + _SAME:
            due.append(self._coming.popleft())
        if not due:
            return
        tell_facts(self._agent.knowledge, due)
        for fact in due:
            if (pose := self._agent.knowledge.world.pose_of(fact.node)) is not None:
                self._placed(fact.node, pose)


def news_of(scenario: ScenarioSpec, agents: Sequence[Agent], stage: Stage | None = None) -> list[News]:
    """The news of all agents that are told something during the run.

    Args:
        scenario: What they are told.
        agents: Who may be told.
        stage: Where goals are from then on to be entered; None where nobody judges, as in a replay.
    """
    found = []
    for agent in agents:
        later = sorted((fact for fact in scenario.facts_of(agent.name) if fact.at), key=lambda fact: fact.at)
        if later and stage is None:
            found.append(News(agent, later))
        elif later and stage is not None:
            goals: Mapping[str, list[Goal]] = stage.goals
            found.append(News(agent, later, _mover(stage.judges[agent.name], goals[agent.name])))
    return found


def _mover(judge: Judge, goals: list[Goal]) -> Callable[[str, Pose2], None]:
    """What tells the simulation where the goals of one agent are."""

    def move(node: str, pose: Pose2) -> None:
        for i, goal in enumerate(goals):
            if goal.name == node and pose != goal.pose:
                goals[i] = replace(goal, pose=pose)
                judge.move_goal(node, pose)

    return move
