"""Set-up of a simulated run: world, agents and event sink of a scenario, ready to run."""

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
from ..simulation.fact_schedule import fact_schedules
from ..simulation.simulated_world import SimulatedWorld, build_world
from .build_agents import build_agents
from .control import CommandDesk, SimulatedPause, rule_files_of
from .episode import Episode
from .header import plain_header
from .memory import Memory
from .options import Build, RunOptions
from .requirements import requirement_faults
from .run_record import RunRecord
from .sink_thread import SinkThread
from .summary import Unrecorded
from .swaps import SwapSchedule, rehearse_swaps, swapped_content


class Relay:
    """Event sink with a target that is set later; events before that are buffered."""

    def __init__(self) -> None:
        self._early: list[Event] = []
        self.emit: Callable[[Event], None] = self._early.append

    def open(self, target: EventSink) -> None:
        """Forward the buffered events, and from now on every event directly."""
        for event in self._early:
            target.emit(event)
        self.emit = target.emit


@dataclass(frozen=True)
class ReadyRun:
    """Scenario that is ready to run.

    Attributes:
        spec: The scenario.
        simulated: World of the scenario.
        agents: Agents of the scenario.
        header: Header of the run, without scenery.
        relay: Sink for the events of world and agents.
        rules: Watcher that reloads changed rule files.
        swaps: Replacements of subtrees of missions.
        desk: Commands of a person.
        clock: Wall clock in threaded mode; None in lockstep.
    """

    spec: ScenarioSpec
    simulated: SimulatedWorld
    agents: Sequence[Agent]
    header: RunHeader
    relay: Relay
    rules: RuleWatch
    swaps: SwapSchedule
    desk: CommandDesk
    clock: WallClock | None

    def episode(self, duration: float | None, watch: Callable[[float], bool], ended: Callable[[], str]) -> Episode:
        """Create the episode.

        Args:
            duration: Maximum duration [s]; None for that of the scenario.
            watch: Observer, called once per control period with the time [s]; False ends the run.
            ended: Returns the reason of a signal that ends the run, or an empty text.
        """
        desk, lockstep = self.desk, self.clock is None

        def between(t: float) -> bool:
            if lockstep:  # in threaded mode a thread watches the rule files, so that control never waits for a file
                self.rules.check()
            self.swaps.step(t)
            desk.period(ended)
            return watch(t)

        return Episode(
            self.simulated,
            self.agents,
            facts=fact_schedules(self.spec, self.agents, self.simulated),
            control=self.spec.rate.control_rate,
            duration=self.spec.duration if duration is None else duration,
            sink=self.relay,
            watch=between,
            ended=ended,
            paused=lambda: desk.paused,
        )

    def play(self, episode: Episode, sink: EventSink) -> None:
        """Run the episode; all events go to the sink."""
        if (clock := self.clock) is None:
            self.relay.open(sink)
            episode.run()
            return
        with SinkThread(sink) as thread, self.rules:
            self.relay.open(thread)
            episode.run_threaded(clock, [ThreadedRunner(agent, clock) for agent in self.agents])

    def summary(self, record: RunRecord, episode: Episode, memory: Memory) -> Summary:
        """Summary after the episode, even if the episode ended by an exception."""
        result, sharing, knowledge = episode.result, sharing_counts(self.agents), memory.summary()
        if result is None:
            return record.summary(self.simulated.clock.now(), Unrecorded(sharing=sharing, knowledge=knowledge))
        unrecorded = Unrecorded(result.wall_time, result.trajectory_hash, sharing, knowledge)
        return record.summary(result.sim_time, unrecorded)


def set_up(spec: ScenarioSpec, catalog: Catalog, options: RunOptions) -> ReadyRun:
    """Build the world, the agents and the header of a scenario.

    Raises:
        InputError: The content is invalid.
    """
    relay, clock = Relay(), WallClock(running=False) if options.mode == "threaded" else None
    simulated = build_world(spec, catalog, options.seed, relay, clock=clock)
    if options.prepare is not None:
        options.prepare(simulated)
    limit = spec.duration if options.duration is None else options.duration
    asked = rehearse_swaps(options.swaps, spec, catalog, seed=options.seed, duration=limit, missions=options.missions)
    agents = simulated_agents(spec, simulated, catalog, relay, options.missions, options.seed)
    swaps = SwapSchedule(asked, agents, catalog)
    rules = RuleWatch(rule_files_of(agents), simulated.clock, relay, watching=options.watch_rules)
    stage = SimulatedPause(agents, time_stops=clock is None)
    desk = CommandDesk(options.control, swaps, rules, simulated.clock, relay, stage)
    digest = catalog.digest(spec, swapped_content(asked, spec, catalog))
    header = plain_header(spec, agents, seed=options.seed, mode=options.mode, digest=digest, swaps=asked)
    refuse_requirements(spec, header.agents)
    return ReadyRun(spec, simulated, agents, header, relay, rules, swaps, desk, clock)


def sharing_counts(agents: Sequence[Agent]) -> dict[str, Mapping[str, float] | None]:
    """Statistics of the shared knowledge, by agent; None for an agent that does not share knowledge."""
    return {agent.name: None if agent.sharing is None else agent.sharing.statistics() for agent in agents}


def simulated_agents(
    spec: ScenarioSpec,
    simulated: SimulatedWorld,
    catalog: Catalog,
    sink: EventSink,
    missions: Mapping[str, Build] | None = None,
    seed: int = 0,
) -> list[Agent]:
    """Build the agents of a scenario in its simulated world."""
    devices = {agent.name: simulated.devices(agent.name) for agent in spec.agents}
    runtime = Runtime(simulated.clock, sink, time.perf_counter)
    return build_agents(spec, catalog, devices, runtime, seed=seed, missions=missions)


def refuse_requirements(spec: ScenarioSpec, agents: Sequence[AgentInfo]) -> None:
    """Check that the scenario's requirements use only signals that their agents have.

    Raises:
        InputError: A requirement does not fit its agent; lists every fault.
    """
    faults = [f for info in agents for f in requirement_faults(spec, info.name, environment_of(info, truth=True))]
    if faults:
        raise InputError(*dict.fromkeys(faults))
