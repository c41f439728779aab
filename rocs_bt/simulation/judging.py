"""Judges the agents of a run, and stopping them, however the run ends."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Protocol

from ..clock import WallClock
from ..event import EventSink, Judged
from ..raised import describe
from .outcome import AgentState, Judge, Verdict

END = "the end of the run"
"""Who cancels what is left when an agent's run is over."""

SLICE = 0.05
"""Longest wait between two looks at whether a signal ended the run, on wall time [s]."""


class EpisodeAgent(AgentState, Protocol):
    """What a run needs of an agent."""

    @property
    def name(self) -> str:
        """The agent's name, which is its robot's in the world."""
        ...

    def step(self, count: int) -> None:
        """One control period in lockstep; `count` of them have passed."""
        ...

    def brake(self) -> None:
        """Go to neutral for good, at once."""
        ...

    def stop(self, by: str = ...) -> None:
        """Go to neutral for good, and cancel everything."""
        ...


class JudgePanel:
    """The judges of a run's agents.

    Args:
        agents: The agents.
        judges: By agent.
        sink: Takes the outcomes.
    """

    def __init__(self, agents: Sequence[EpisodeAgent], judges: Mapping[str, Judge], sink: EventSink) -> None:
        self._agents = agents
        self._judges = judges
        self._sink = sink

    @property
    def over(self) -> bool:
        """Whether the outcome of every agent is decided."""
        return all(judge.decided for judge in self._judges.values())

    def interrupt(self, why: str, *, at_once: bool) -> None:
        """A signal or a person ends the run: stop all agents whose outcome is open.

        Args:
            why: Reason of the outcome.
            at_once: Whether all brake before the first one is stopped, which may have to wait for a plan that hangs.
        """
        going = [agent for agent in self._agents if not self._judges[agent.name].decided]
        for agent in going:
            self._judges[agent.name].interrupt(why)
        if at_once:
            brake(going)
        for agent in going:
            agent.stop(why)

    def abort(self, error: BaseException, t: float) -> dict[str, Verdict]:
        """Something raised that no agent answers for: stop and judge all agents; never raises."""
        known = isinstance(error, Exception)
        why = describe(error) if known else str(error) or type(error).__name__
        for agent in self._agents:
            with suppress(Exception):  # whatever broke may be what they need
                agent.stop(why)
        for judge in self._judges.values():
            judge.fail(f"the run broke off: {why}") if known else judge.interrupt(why)
        with suppress(Exception):
            return self.finish(t)
        return {}

    def finish(self, t: float) -> dict[str, Verdict]:
        """Stop who still goes on, and give every agent its outcome at the end of the run [s]."""
        verdicts = {}
        for agent in self._agents:
            judge = self._judges[agent.name]
            if not judge.decided:
                agent.stop(END)
            judge.look_for_failure(agent)
            verdict = verdicts[agent.name] = judge.verdict()
            self._sink.emit(
                Judged(
                    t=t,
                    agent=agent.name,
                    outcome=verdict.outcome,
                    reason=verdict.reason,
                    time_to_goal=verdict.time_to_goal,
                )
            )
        return verdicts


def brake(agents: Sequence[EpisodeAgent]) -> None:
    """Send all robots to neutral before the first agent is stopped, which may have to wait for a plan that hangs."""
    for agent in agents:
        agent.brake()


def wait_until(clock: WallClock, deadline: float, stop: threading.Event, ended: Callable[[], str]) -> bool:
    """Sleep until the deadline [s], or until a signal ends the run; True unless `stop` was set before.

    Args:
        clock: Wall time.
        deadline: When to wake [s].
        stop: Wakes at once.
        ended: Why a signal ends the run; empty while none does.
    """
    while not ended() and clock.now() < deadline:
        if not clock.wait_until(min(deadline, clock.now() + SLICE), stop):
            return False
    return not stop.is_set()
