"""Replay: run the agents again on recorded sensor data; they must make the same decisions (docs/architecture.md)."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace as replace_fault
from pathlib import Path

from ..agent import Agent
from ..base.clock import SimulatedClock
from ..base.errors import InputError, RecordingError, UnknownName, unknown
from ..base.files import unsaved
from ..catalog import Catalog, ScenarioSpec
from ..event import (
    AgentStopped,
    CommandExpired,
    Event,
    LandingBegan,
    ListSink,
    MotionHeld,
    MotionReleased,
    RulesReplaced,
    RunControlled,
)
from ..knowledge.history import from_json_text
from ..record import WORLD_EVENTS, Divergence, Recording, RunHeader, SubtreeSwap, compare
from ..simulation.fact_schedule import fact_schedules
from .build_agents import worldless_agents
from .memory import recall
from .run_options import Build
from .swaps import SwapSchedule, controlled_swaps, swapped_content

_NOT_OF_AGENTS: tuple[type[Event], ...] = (
    *WORLD_EVENTS,
    CommandExpired,
    LandingBegan,
    MotionHeld,
    MotionReleased,
    RulesReplaced,
    RunControlled,
)


def replay(
    recording: Recording,
    catalog: Catalog | None = None,
    *,
    agent: str | None = None,
    missions: Mapping[str, Build] | None = None,
    changed_content: bool = False,
) -> Divergence | None:
    """Run the agents of a recorded scenario on the recorded sensor data, and compare their events with the recording.

    Args:
        recording: Recording of a lockstep run; a truncated one is compared up to its end.
        catalog: Source of the scenario; the project around the current folder by default.
        agent: Name of the only agent to compare; None compares all.
        missions: Mission functions that replaced the scenario's in the run, by agent.
        changed_content: Whether to compare also if the content has changed since the run; the present content is used.

    Returns:
        First event that differs; None if all events are equal, except for fields with wall-clock times.

    Raises:
        RecordingError: The run cannot be repeated: threaded mode, changed content, or measured planning
            latency.
        InputError: The scenario or the agent does not exist, or the scenario does not load.
    """
    header = recording.header
    if header.mode != "lockstep":
        raise RecordingError(
            f"'{recording.path}' was recorded in {header.mode} mode. Its decisions depend on wall time and are not "
            "repeatable. Record it in lockstep mode, or query it with --why."
        )
    names = [a.name for a in header.agents]
    if agent is not None and agent not in names:
        raise InputError(unknown("agent", agent, names, "The run"))
    recorded = list(recording.events())
    catalog = catalog or Catalog.here()
    scenario = _scenario(header.scenario, catalog)
    replaced = [e for e in recorded if isinstance(e, RulesReplaced) and e.accepted]
    before: dict[Path, str] = {}
    for event in reversed(replaced):  # of several, the first has the rules of the beginning
        before |= _texts(event.before, event, scenario, catalog)
    with unsaved(before):
        return _compare(recording, catalog, scenario, recorded, replaced, agent, missions, changed_content)


def _compare(
    recording: Recording,
    catalog: Catalog,
    scenario: ScenarioSpec,
    recorded: Sequence[Event],
    replaced: Sequence[RulesReplaced],
    agent: str | None,
    missions: Mapping[str, Build] | None,
    changed_content: bool,
) -> Divergence | None:
    """Compare, in the context of the rules with which the run began; see `replay`."""
    header = recording.header
    swaps = [*header.swaps, *controlled_swaps(recorded, catalog, changed_content=changed_content)]
    swapped = swapped_content(header.swaps, scenario, catalog)
    if not changed_content and catalog.digest(scenario, swapped) != header.content_hash:
        raise RecordingError(
            f"the content of '{header.scenario}' has changed since '{recording.path}' was recorded (content_hash "
            f"{header.content_hash[:12]}). Check out the recorded version, run the scenario again, or "
            "compare with the present content: rocs-bt replay --changed-content."
        )
    if measured := [a.name for a in scenario.agents if a.latency is None]:
        raise RecordingError(
            f"the latency of {measured[0]}'s planner was measured while '{recording.path}' was recorded, so the run is "
            'not repeatable. Declare it, as in latency = "0.05 s", or query the recording with --why.'
        )
    recorded = [e for e in recorded if not isinstance(e, _NOT_OF_AGENTS)]
    found = _decide(scenario, catalog, header, recorded, swaps, replaced, missions)
    if agent is not None:
        recorded, found = ([e for e in events if e.agent == agent] for events in (recorded, found))
    return compare(recorded, found, cut_off=not recording.complete)


def _scenario(name: str, catalog: Catalog) -> ScenarioSpec:
    try:
        catalog.find("scenario", name)
    except UnknownName as error:
        hint = "Replay a run in the project folder in which it was recorded."
        raise UnknownName(*(replace_fault(f, hint=f"{f.hint} {hint}") for f in error.faults)) from error
    return catalog.load_scenario(name)


def _decide(
    scenario: ScenarioSpec,
    catalog: Catalog,
    header: RunHeader,
    recorded: Sequence[Event],
    swaps: Sequence[SubtreeSwap],
    replaced: Sequence[RulesReplaced],
    missions: Mapping[str, Build] | None,
) -> list[Event]:
    """Run the agents of the scenario on recorded sensor data and return their events."""
    control, sink = scenario.rate.control_rate, ListSink()
    clock = SimulatedClock(scenario.rate.physics)
    agents = worldless_agents(
        scenario, catalog, seed=header.seed, missions=missions, recorded=recorded, clock=clock, sink=sink
    )
    if header.recalled:
        schema = agents[0].knowledge.graph.schema
        recall(from_json_text(header.recalled, Path("the recording"), schema), agents)
    schedules, coming = fact_schedules(scenario, agents), SwapSchedule(swaps, agents, catalog)
    stops = {e.agent: e for e in recorded if isinstance(e, AgentStopped)}
    reloads = deque(replaced)
    last = round(recorded[-1].t / control.period) if recorded else -1
    for count in range(last + 1):
        for agent in agents:
            if (stop := stops.get(agent.name)) and count >= round(stop.t / control.period):
                agent.stop(stop.by)
        while reloads and reloads[0].t <= clock.now():
            _reload(reloads.popleft(), agents)
        coming.step(clock.now())
        for agent in agents:
            if not agent.stopped:
                agent.step(count)
        for schedule in schedules:
            schedule.step(clock.now())
        clock.advance(control.every)
    return sink.events


def _reload(event: RulesReplaced, agents: Sequence[Agent]) -> None:
    """Give an agent the rules that replaced others during the run."""
    for file in next(agent for agent in agents if agent.name == event.agent).reloadable_rules:
        if file.file.stem == event.rules:
            with unsaved({file.file.parent / name: text for name, text in event.texts.items()}):
                file.reload()


def _texts(texts: Mapping[str, str], event: RulesReplaced, scenario: ScenarioSpec, catalog: Catalog) -> dict[Path, str]:
    """Texts of a rule file, and of those that it includes, by file of this catalog."""
    rules = next((agent.rules for agent in scenario.agents if agent.name == event.agent), ())
    found = [catalog.find("rules", name).path for name in rules]
    return {file.parent / name: text for file in found if file.stem == event.rules for name, text in texts.items()}
