"""A scenario that is ready to be played: its world, its agents, and where their events go."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..agent import Agent, RuleWatch, Runtime, ThreadedRunner
from ..catalog import Catalog, ScenarioSpec
from ..clock import WallClock
from ..errors import InputError
from ..event import Event, EventSink
from ..record import AgentInfo, RunHeader, Summary, environment_of
from .build_agents import build_agents
from .episode import Episode
from .fact_schedule import fact_schedules
from .header import plain_header
from .memory import Memory
from .options import Build, RunOptions
from .requirements import requirement_faults
from .run_record import RunRecord
from .simulated_world import SimulatedWorld, build_world
from .sink_thread import SinkThread
from .summary import Unrecorded


class Relay:
    """A sink whose target is known only after those that emit into it have been built; it keeps what came before."""

    def __init__(self) -> None:
        self._early: list[Event] = []
        self.emit: Callable[[Event], None] = self._early.append

    def open(self, target: EventSink) -> None:
        """Hand over what came so far, and from now on everything at once."""
        for event in self._early:
            target.emit(event)
        self.emit = target.emit


@dataclass(frozen=True)
class ReadyRun:
    """A scenario that is ready to be played.

    Attributes:
        spec: The scenario.
        simulated: Its world.
        agents: Its agents.
        header: Header of the run, without scenery.
        relay: Takes the events of all of them.
        rules: Looks after the rule files that may change.
        clock: Wall time in threaded mode; None in lockstep.
    """

    spec: ScenarioSpec
    simulated: SimulatedWorld
    agents: Sequence[Agent]
    header: RunHeader
    relay: Relay
    rules: RuleWatch
    clock: WallClock | None

    def episode(self, duration: float | None, watch: Callable[[float], bool], ended: Callable[[], str]) -> Episode:
        """The episode, at most `duration` long [s], or as long as the scenario says."""
        return Episode(
            self.simulated,
            self.agents,
            facts=fact_schedules(self.spec, self.agents, self.simulated),
            control=self.spec.rate.control_rate,
            duration=self.spec.duration if duration is None else duration,
            sink=self.relay,
            # In threaded mode nobody's control waits for a file: rule files have a thread.
            watch=watch if self.clock is not None else self.rules.before(watch),
            ended=ended,
        )

    def play(self, episode: Episode, sink: EventSink) -> None:
        """Play the episode; all events go to the sink."""
        if (clock := self.clock) is None:
            self.relay.open(sink)
            episode.run()
            return
        with SinkThread(sink) as thread, self.rules:
            self.relay.open(thread)
            episode.run_threaded(clock, [ThreadedRunner(agent, clock) for agent in self.agents])

    def summary(self, record: RunRecord, episode: Episode, memory: Memory) -> Summary:
        """The summary after the episode, also where that broke off."""
        result, sharing, knowledge = episode.result, sharing_counts(self.agents), memory.summary()
        if result is None:
            return record.summary(self.simulated.clock.now(), Unrecorded(sharing=sharing, knowledge=knowledge))
        unrecorded = Unrecorded(result.wall_time, result.trajectory_hash, sharing, knowledge)
        return record.summary(result.sim_time, unrecorded)


def set_up(spec: ScenarioSpec, catalog: Catalog, options: RunOptions) -> ReadyRun:
    """Set a scenario up: world, agents, header.

    Raises:
        InputError: Something in the content is wrong.
    """
    relay, clock = Relay(), WallClock(running=False) if options.mode == "threaded" else None
    simulated = build_world(spec, catalog, options.seed, relay, clock=clock)
    if options.prepare is not None:
        options.prepare(simulated)
    agents = simulated_agents(spec, simulated, catalog, relay, options.missions, options.seed)
    files = [(a.name, file) for a in agents for file in a.rule_files if options.watch_rules]
    header = plain_header(spec, agents, seed=options.seed, mode=options.mode, digest=catalog.digest(spec))
    refuse_requirements(spec, header.agents)
    return ReadyRun(spec, simulated, agents, header, relay, RuleWatch(files, simulated.clock, relay), clock)


def sharing_counts(agents: Sequence[Agent]) -> dict[str, Mapping[str, float] | None]:
    """Counts of shared knowledge by agent; None for an agent that does not share."""
    return {agent.name: None if agent.sharing is None else agent.sharing.statistics() for agent in agents}


def simulated_agents(
    spec: ScenarioSpec,
    simulated: SimulatedWorld,
    catalog: Catalog,
    sink: EventSink,
    missions: Mapping[str, Build] | None = None,
    seed: int = 0,
) -> list[Agent]:
    """The agents of a scenario in its simulated world."""
    devices = {agent.name: simulated.devices(agent.name) for agent in spec.agents}
    runtime = Runtime(simulated.clock, sink, time.perf_counter)
    return build_agents(spec, catalog, devices, runtime, seed=seed, missions=missions)


def refuse_requirements(spec: ScenarioSpec, agents: Sequence[AgentInfo]) -> None:
    """Refuse requirements that do not fit their agents.

    Raises:
        InputError: One does not, with every fault.
    """
    faults = [f for info in agents for f in requirement_faults(spec, info.name, environment_of(info, truth=True))]
    if faults:
        raise InputError(*dict.fromkeys(faults))
