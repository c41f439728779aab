"""RunLoop: the control periods of one run, from the first one to the outcome of every agent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from typing import Protocol

from ..agent import Agent
from ..base.clock import Clock, WallClock
from ..base.raised import describe
from ..event import EventSink, OutcomeDecided
from ..simulation.outcome import AgentOutcome, AgentState, Judge

END = "the end of the run"
"""Reason with which actions are cancelled when an agent's run is over."""

CLOSED = "the viewer was closed"
"""Reason of the outcome `interrupted` if the observer of the run ended it."""


class LoopAgent(AgentState, Protocol):
    """Interface of an agent that a loop steps, stops and judges."""

    @property
    def name(self) -> str:
        """Name of the agent and of its robot in the world."""

    def step(self, count: int) -> None:
        """Run one control period in lockstep; `count` is the number of periods before it."""

    def brake(self) -> None:
        """Send all actuators to neutral permanently."""

    def stop(self, by: str = ...) -> None:
        """Send all actuators to neutral permanently and cancel all actions."""


class Stage(Protocol):
    """Place of a run with the agents of a scenario: a simulated world, or the robots themselves."""

    @property
    def clock(self) -> Clock:
        """Clock of the run."""

    @property
    def judges(self) -> Mapping[str, Judge]:
        """Judges of the outcomes, by agent."""

    @property
    def time_stops(self) -> bool:
        """Whether the time of the run stops between two periods, as in lockstep."""

    @property
    def trajectory_hash(self) -> str | None:
        """Hash of the ground truth at all control periods; None without ground truth."""

    @property
    def agents(self) -> Sequence[Agent]:
        """Agents of the scenario."""

    @property
    def start(self) -> float:
        """Time of the first control period [s]; valid after `ready`."""

    def ready(self, ended: Callable[[], str]) -> bool:
        """Wait until the run may start; False if a signal ended it before."""

    def playing(self, ended: Callable[[], str]) -> AbstractContextManager[Iterator[float]]:
        """Context in which the run goes on; it gives the time of each control period [s].

        Args:
            ended: Returns the reason of a signal that ends the run, or an empty text; no period is late for it.
        """

    def observe(self, t: float) -> None:
        """Begin a control period: emit where the bodies are, check the devices, and judge the agents."""

    def advance(self, t: float) -> None:
        """End a control period: what does not go on by itself does so until the next period."""

    def rest(self) -> None:
        """After the last period, however it ended: all robots stay in neutral."""

    def pause(self, by: str) -> None:
        """Begin a pause that this person or program asked for."""

    def resume(self, by: str) -> None:
        """End a pause, on a stage where a command ends it."""


@dataclass(frozen=True)
class LoopResult:
    """Result of a run loop.

    Attributes:
        verdicts: Verdicts (outcomes with reasons) by agent; empty if they could not be determined.
        sim_time: Duration on the clock of the run [s].
        wall_time: Wall-clock duration of the run [s].
        trajectory_hash: sha256 of the float64 generalised positions at all control periods; None on hardware.
    """

    verdicts: Mapping[str, AgentOutcome]
    sim_time: float
    wall_time: float
    trajectory_hash: str | None


class RunLoop:
    """One run of the agents of a scenario on their stage.

    Args:
        stage: Stage of the run.
        agents: Agents of the scenario.
        sink: Sink for the outcomes.
        duration: Maximum duration [s].
        start: Time of the first control period [s].
        between: Observer, called once per control period with the time [s]; False ends the run.
        ended: Returns the reason of a signal that ends the run, or an empty text; called once per control period.

    Attributes:
        t: Time of the last control period [s].
    """

    def __init__(
        self,
        stage: Stage,
        agents: Sequence[LoopAgent],
        sink: EventSink,
        *,
        duration: float,
        start: float = 0.0,
        between: Callable[[float], bool] = lambda t: True,
        ended: Callable[[], str] = lambda: "",
    ) -> None:
        self.t = self._start = start
        self._stage = stage
        self._agents = agents
        self._judges = stage.judges
        self._sink = sink
        self._end = start + duration
        self._between = between
        self._ended = ended
        self._wall = WallClock(running=False)
        self._wall_time = 0.0
        self._verdicts: dict[str, AgentOutcome] = {}

    def run(self) -> LoopResult:
        """Run until every agent has an outcome, the duration is over, or a signal ends the run.

        If an exception is raised, all agents are stopped and their outcomes are determined before the exception
        propagates; `result` is valid also then.
        """
        self._wall.start()
        try:
            with self._stage.playing(self._ended) as periods:
                for t in periods:
                    self.t = t
                    if self._over(t):
                        break
                    self._stage.advance(t)
        except BaseException as error:  # raised again, after the robots stopped
            self.t = max(self.t, self._stage.clock.now())
            self._abort(error)
            raise
        finally:
            self._wall_time = self._wall.now()
            self._stage.rest()
        self._finish()
        return self.result()

    def interrupt(self) -> None:
        """Give every agent the outcome of a run that a signal ended before the robots could start."""
        self._interrupt(self._ended())
        self._finish()

    def result(self) -> LoopResult:
        """Result of the loop, also if `run` raised."""
        took = self.t - self._start
        wall_time = self._wall_time if self._stage.time_stops else took
        return LoopResult(self._verdicts, took, wall_time, self._stage.trajectory_hash)

    def _over(self, t: float) -> bool:
        """Process one control period; returns whether the run is over."""
        self._stage.observe(t)
        going = self._between(t)
        if why := self._ended() or ("" if going else CLOSED):
            self._interrupt(why)
        for name, judge in self._judges.items():
            if judge.decided and name not in self._verdicts:
                self._announce(name, judge.verdict())
        return all(judge.decided for judge in self._judges.values()) or t >= self._end - 1e-9

    def _interrupt(self, why: str) -> None:
        """Stop all agents that have no outcome yet."""
        going = [agent for agent in self._agents if not self._judges[agent.name].decided]
        for agent in going:
            self._judges[agent.name].interrupt(why)
        if not self._stage.time_stops:
            brake(going)
        for agent in going:
            agent.stop(why)

    def _abort(self, error: BaseException) -> None:
        """Stop all agents and determine their outcomes after an exception outside of the agents; never raises."""
        known = isinstance(error, Exception)
        why = describe(error) if known else str(error) or type(error).__name__
        for agent in self._agents:
            with suppress(Exception):  # stopping may need the part that failed
                agent.stop(why)
        for judge in self._judges.values():
            judge.fail(f"the run ended by an exception: {why}") if known else judge.interrupt(why)
        with suppress(Exception):  # a part that failed may be needed here too; the error itself is reported
            self._finish()

    def _finish(self) -> None:
        """Stop the remaining agents, and emit the outcomes that are new."""
        for agent in self._agents:
            judge = self._judges[agent.name]
            if not judge.decided:
                judge.running = agent.running
                agent.stop(END)
            judge.check_failure(agent)
            if (verdict := judge.verdict()) != self._verdicts.get(agent.name):
                self._announce(agent.name, verdict)

    def _announce(self, agent: str, verdict: AgentOutcome) -> None:
        self._verdicts[agent] = verdict
        self._sink.emit(
            OutcomeDecided(
                t=self.t,
                agent=agent,
                outcome=verdict.outcome,
                reason=verdict.reason,
                time_to_goal=verdict.time_to_goal,
                fell=verdict.fell,
            )
        )


def brake(agents: Sequence[LoopAgent]) -> None:
    """Send all robots to neutral. Call it before stopping the first agent, which may wait for a plan that hangs."""
    for agent in agents:
        agent.brake()
