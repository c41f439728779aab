"""JudgePanel: determines the outcome of each agent of a run, and stops the agents at the end of the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Protocol

from ..event import EventSink, OutcomeDecided
from ..raised import describe
from ..simulation.outcome import AgentState, Judge, Verdict

END = "the end of the run"
"""Reason with which actions are cancelled when an agent's run is over."""


class EpisodeAgent(AgentState, Protocol):
    """Interface of an agent that an episode steps, stops and judges."""

    @property
    def name(self) -> str:
        """Name of the agent and of its robot in the world."""
        ...

    def step(self, count: int) -> None:
        """Run one control period in lockstep; `count` is the number of periods before it."""
        ...

    def brake(self) -> None:
        """Send all actuators to neutral permanently."""
        ...

    def stop(self, by: str = ...) -> None:
        """Send all actuators to neutral permanently and cancel all actions."""
        ...


class JudgePanel:
    """Determines the outcomes of all agents of a run, with one `Judge` for each agent.

    Args:
        agents: Agents of the run.
        judges: Judges by agent.
        sink: Sink for the outcomes.
    """

    def __init__(self, agents: Sequence[EpisodeAgent], judges: Mapping[str, Judge], sink: EventSink) -> None:
        self._agents = agents
        self._judges = judges
        self._sink = sink

    @property
    def over(self) -> bool:
        """Whether every agent's outcome is decided."""
        return all(judge.decided for judge in self._judges.values())

    def interrupt(self, why: str, *, at_once: bool) -> None:
        """End the run early, by a signal or a person: stop all agents that have no outcome yet.

        Args:
            why: Reason of the outcome.
            at_once: Whether all robots brake before the first agent is stopped, because stopping may wait for a plan
                that hangs.
        """
        going = [agent for agent in self._agents if not self._judges[agent.name].decided]
        for agent in going:
            self._judges[agent.name].interrupt(why)
        if at_once:
            brake(going)
        for agent in going:
            agent.stop(why)

    def abort(self, error: BaseException, t: float) -> dict[str, Verdict]:
        """Stop all agents and determine their outcomes after an exception outside of the agents; never raises.

        Args:
            error: The exception.
            t: Time [s].

        Returns:
            Verdicts (outcomes with reasons) by agent; empty if they cannot be determined.
        """
        known = isinstance(error, Exception)
        why = describe(error) if known else str(error) or type(error).__name__
        for agent in self._agents:
            with suppress(Exception):  # stopping may need the part that failed
                agent.stop(why)
        for judge in self._judges.values():
            judge.fail(f"the run ended by an exception: {why}") if known else judge.interrupt(why)
        with suppress(Exception):  # a part that failed may be needed here too; the error itself is reported
            return self.finish(t)
        return {}

    def finish(self, t: float) -> dict[str, Verdict]:
        """Stop the remaining agents and emit every agent's outcome.

        Args:
            t: Time of the end of the run [s].

        Returns:
            Verdicts by agent.
        """
        verdicts = {}
        for agent in self._agents:
            judge = self._judges[agent.name]
            if not judge.decided:
                judge.running = agent.running
                agent.stop(END)
            judge.check_failure(agent)
            verdict = verdicts[agent.name] = judge.verdict()
            self._sink.emit(
                OutcomeDecided(
                    t=t,
                    agent=agent.name,
                    outcome=verdict.outcome,
                    reason=verdict.reason,
                    time_to_goal=verdict.time_to_goal,
                    fell=verdict.fell,
                )
            )
        return verdicts


def brake(agents: Sequence[EpisodeAgent]) -> None:
    """Send all robots to neutral. Call it before stopping the first agent, which may wait for a plan that hangs."""
    for agent in agents:
        agent.brake()
