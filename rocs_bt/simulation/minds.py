"""Giving the robots on a stage their minds: missions, rules and what they are told, from a scenario's names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from ..agent import Agent, Mind, Rates, build_agent
from ..catalog import AgentSpec, Catalog, RobotSpec, ScenarioSpec
from ..clock import Clock, Rate
from ..device import Sensor
from ..errors import InputError, blame
from ..event import EventSink
from ..plan import mission_actions, mission_arguments
from ..safety import SafetyGate
from .options import Build
from .share import sharing_of
from .streams import stream


def load_mind(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, build: Build | None = None) -> Mind:
    """What a scenario says of one agent's mind.

    Args:
        scenario: The scenario.
        agent: One of its agents.
        catalog: Where missions and rules are found.
        build: A mission to play instead of the scenario's.

    Raises:
        InputError: A name does not exist, or the mission does not take the parameters.
    """
    mission = build or catalog.load_mission(agent.mission, agent.nodes)
    try:
        parameters = mission_arguments(mission, agent.parameters if build is None else {})
    except InputError as error:
        raise error.at(scenario.file, agent.parameters_line or agent.line) from error
    return Mind(
        build=mission,
        mission=agent.mission if build is None else getattr(build, "__module__", "mission"),
        parameters=parameters,
        rules=[catalog.find("rules", name).path for name in agent.rules],
        places=[place for place in scenario.places if agent.name in place.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        actions=mission_actions(mission),
        latency=agent.latency,
        schema=catalog.load_schema(),
    )


def build_minds(
    scenario: ScenarioSpec,
    catalog: Catalog,
    robots: Mapping[str, RobotSpec],
    sensors: Mapping[str, Mapping[str, Sensor]],
    actuators: Mapping[str, Mapping[str, SafetyGate]],
    sensor_rates: Mapping[str, Mapping[str, Rate]],
    *,
    clock: Clock,
    sink: EventSink,
    seed: int = 0,
    timer: Callable[[], float] | None = None,
    missions: Mapping[str, Build] | None = None,
) -> list[Agent]:
    """All agents of a scenario, in its order; mappings are by agent, and the seed is for missions that draw.

    Raises:
        InputError: Something in a mission, a rule file or robot.toml does not fit, with every fault of that file.
    """
    period = scenario.rate.control_rate.period
    rates = Rates(control=Rate(1, period), plan=scenario.rate.plan_rate)
    shares = sharing_of(scenario, clock, sink, seed)
    agents = []
    for agent in scenario.agents:
        mind = load_mind(scenario, agent, catalog, (missions or {}).get(agent.name))
        with blame(scenario.file, agent.line):
            built = build_agent(
                agent.name,
                robots[agent.name],
                mind,
                sensors=sensors[agent.name],
                actuators=actuators[agent.name],
                sensor_rates=sensor_rates[agent.name],
                rates=rates,
                clock=clock,
                sink=sink,
                timer=timer,
                rng=partial(stream, scenario.name, seed, agent.name),
                load_class=catalog.load_class,
                keep=catalog.keep,
                share=shares.get(agent.name),
            )
        agents.append(built)
    return agents
