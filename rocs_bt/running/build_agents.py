"""Build the agents of a scenario and connect them to its robots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from ..agent import Agent, Controller, Rates, RobotDevices, Runtime, build_agent
from ..catalog import AgentSpec, Catalog, ScenarioSpec, mission_values
from ..clock import Rate
from ..errors import located_at
from ..plan import mission_actions
from ..simulation.random_streams import stream
from .options import Build
from .share import sharing_of


def load_controller(
    scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, build: Build | None = None
) -> Controller:
    """Controller of one agent, as declared in a scenario.

    Args:
        scenario: The scenario.
        agent: Agent of the scenario.
        catalog: Source of missions and rules.
        build: Mission function that replaces the scenario's mission.

    Raises:
        InputError: An unknown name, or parameters that the mission does not take.
    """
    mission = build or catalog.load_mission(agent.mission, agent.nodes)
    parameters = mission_values(mission, agent if build is None else replace(agent, parameters={}))
    return Controller(
        build=mission,
        mission=agent.mission if build is None else getattr(build, "__module__", "mission"),
        parameters=parameters,
        rules=[catalog.find("rules", name).path for name in agent.rules],
        places=[place for place in scenario.places if agent.name in place.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        actions=mission_actions(mission),
        latency=agent.latency,
        privileged=agent.privileged,
        schema=catalog.load_schema(),
    )


def build_agents(
    scenario: ScenarioSpec,
    catalog: Catalog,
    devices: Mapping[str, RobotDevices],
    runtime: Runtime,
    *,
    seed: int = 0,
    missions: Mapping[str, Build] | None = None,
) -> list[Agent]:
    """Build the agents of a scenario, in its order, and connect them to their robots.

    Args:
        scenario: The scenario.
        catalog: Source of the content.
        devices: Devices of the robots, by agent.
        runtime: Clock, sink and timer of the run.
        seed: Seed of the missions' random streams.
        missions: Mission functions that replace the scenario's, by agent.

    Raises:
        InputError: A mission, rule file or robot.toml is invalid; lists every fault of that file.
    """
    rates = Rates(control=Rate(1, scenario.rate.control_rate.period), plan=scenario.rate.plan_rate)
    shares = sharing_of(scenario, runtime.clock, seed)
    agents = []
    for agent in scenario.agents:
        own = replace(runtime, rng=partial(stream, scenario.name, seed, agent.name))
        with located_at(scenario.file, agent.line):
            controller = load_controller(scenario, agent, catalog, (missions or {}).get(agent.name))
            built = build_agent(
                agent.name,
                devices[agent.name],
                controller,
                rates,
                own,
                load_class=catalog.load_class,
                cached=catalog.cached,
                share=shares.get(agent.name),
            )
        agents.append(built)
    return agents
