"""Swapping the simulation for something else: the drivers differ, and nothing else does (paper, 5.3)."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from rocs_bt import run
from rocs_bt.agent import Agent, AgentRuntime, RobotDevices
from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.catalog import Catalog, RobotSpec, ScenarioSpec
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.devices.simulated.flat import FlatWorld
from rocs_bt.event import ActuatorCommanded, Event, ListSink, NullSink, SensorRead
from rocs_bt.plan import TreePlan
from rocs_bt.running.build_agents import build_agents
from rocs_bt.running.simulated_stage import simulated_agents
from rocs_bt.simulation import build_world
from rocs_bt.testing.mock_agent import MockDevices, mock_devices

CATALOG = Catalog()
RUNS = {"exp1": 6.0, "exp2_localised": 5.0, "exp3": 4.0}
DRIVER = """
from rocs_bt import Actuator, Sensor


class Told(Sensor):
    def read(self):
        raise NotImplementedError


class Wheels(Actuator):
    def command(self, values):
        raise NotImplementedError

    def neutral(self):
        pass
"""


def mocked(scenario: str, catalog: Catalog = CATALOG, sink: Any = None) -> tuple[list[Agent], dict[str, MockDevices]]:
    """The scenario's minds on mock drivers."""
    spec = catalog.load_scenario(scenario)
    clock = SimulatedClock(spec.rate.physics)
    robots = {a.name: catalog.load_robot(a.robot) for a in spec.agents}
    stages = {name: mock_devices(robot, clock) for name, robot in robots.items()}
    devices = {
        name: RobotDevices(robot, stages[name].sensors, stages[name].actuators, rates(spec, robot))
        for name, robot in robots.items()
    }
    return build_agents(spec, catalog, devices, AgentRuntime(clock, sink or NullSink())), stages


def rates(spec: ScenarioSpec, robot: RobotSpec) -> dict[str, Rate]:
    return {s.name: spec.rate.sensor_rate(s.rate, s.name) for s in robot.sensors}


def on_mujoco(scenario: str) -> list[Agent]:
    spec = CATALOG.load_scenario(scenario)
    return simulated_agents(spec, build_world(spec, CATALOG, 1, NullSink()), CATALOG, NullSink())


def graph(agent: Agent) -> dict[str, dict[str, Any]]:
    """Every node with its attributes, but for live views of signals."""
    known = agent.knowledge.graph
    nodes = {name: dict(known.attributes(name)) for name in known.nodes()}
    return {name: {k: v for k, v in attributes.items() if k != "values"} for name, attributes in nodes.items()}


def blocks(agent: Agent) -> dict[str, Any]:
    """What the mind is made of."""
    assert isinstance(agent.plan, TreePlan)
    return {
        "monitors": [(m.name, type(m), [s.sensor.name for s in m.monitored], m.rate) for m in agent.monitors],
        "analyzes": [(a.name, type(a), tuple(a.from_knowledge)) for a in agent.analyzes],
        "mission": agent.plan.outline,
        "rules": [[rule.name for rule in model.rules.rules] for model in agent.knowledge.reactive_models],
        "signals": [agent.knowledge.signals.spec(name) for name in agent.knowledge.signals.names],
        "rates": agent.rates,
        "drive": [
            agent.knowledge.robot.locomotion.kind,
            agent.knowledge.robot.locomotion.wheels,
            agent.knowledge.robot.limits,
        ],
    }


@pytest.mark.parametrize("scenario", RUNS)
def test_a_mind_on_mock_drivers_is_the_mind_on_mujocos(scenario: str) -> None:
    real, (mock, _) = on_mujoco(scenario), mocked(scenario)
    for one, other in zip(real, mock, strict=True):
        assert graph(one) == graph(other)
        assert blocks(one) == blocks(other)
        devices = [*one.sensors.values(), *(w._device for w in one.actuators.values())]
        others = [*other.sensors.values(), *(w._device for w in other.actuators.values())]
        assert [d.name for d in devices] == [d.name for d in others]
        assert {type(d.world) for d in devices} == {MujocoWorld}
        assert {type(getattr(d, "device", d).world) for d in others} == {FlatWorld}


def test_a_robot_with_drivers_of_its_own_differs_by_its_driver_table_alone(tmp_path: Any) -> None:
    shipped = CATALOG.load_robot("pioneer_p3dx")
    tables = [f'[[sensor]]\nname = "{s.name}"\ndriver = "own.py:Told"\n' for s in shipped.sensors]
    tables.append('[[actuator]]\nname = "wheels"\ndriver = "own.py:Wheels"\n')
    folder = tmp_path / "robots" / "real_p3dx"
    folder.mkdir(parents=True)
    (folder / "own.py").write_text(DRIVER)
    (folder / "robot.toml").write_text('format = "robot/3"\nbase = "pioneer_p3dx"\n' + "".join(tables))
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "real.toml").write_text(
        'format = "scenario/2"\nbase = "exp1"\n[[agent]]\nname = "R2"\nrobot = "real_p3dx"\n'
    )
    catalog = Catalog(tmp_path)
    spec, own = catalog.load_scenario("real"), catalog.load_robot("real_p3dx")
    devices = {s.name: catalog.load_class(folder / "own.py", "Told")(s.name) for s in own.sensors}
    stage = mock_devices(shipped, SimulatedClock(spec.rate.physics))
    own_devices = RobotDevices(own, devices, stage.actuators, rates(spec, own))
    (mind,) = build_agents(spec, catalog, {"R2": own_devices}, AgentRuntime(stage.clock, NullSink()))
    (simulated,) = on_mujoco("exp1")
    assert blocks(mind) == blocks(simulated)
    differs = {
        (node, key, value)
        for node, attributes in graph(mind).items()
        for key, value in attributes.items()
        if graph(simulated)[node][key] != value
    }
    drivers = {(s.name, "driver", "own.py:Told") for s in shipped.sensors} | {("wheels", "driver", "own.py:Wheels")}
    assert differs == drivers | {("R2", "model", "real_p3dx")}


@cache
def recorded(scenario: str) -> list[Event]:
    sink = ListSink()
    run(scenario, CATALOG, seed=1, duration=RUNS[scenario], sinks=[sink])
    return sink.events


@pytest.mark.parametrize("scenario", RUNS)
def test_fed_the_same_readings_it_gives_the_same_commands_byte_for_byte(scenario: str) -> None:
    sink = ListSink()
    minds, stages = mocked(scenario, sink=sink)
    readings: dict[float, dict[tuple[str, str], list[float]]] = {}
    for event in recorded(scenario):
        if isinstance(event, SensorRead):
            readings.setdefault(event.t, {})[event.agent, event.sensor] = event.values
    every = CATALOG.load_scenario(scenario).rate.control_rate.every
    clock: Any = next(iter(stages.values())).clock
    for count in range(len(readings)):
        for (agent, sensor), values in readings[clock.now()].items():
            device: Any = stages[agent].sensors[sensor]
            device.values = values
        for mind in minds:
            mind.step(count)
        clock.advance(every)

    def commands(events: list[Event]) -> list[tuple[float, str, str, bytes]]:
        last = max(readings) + 1e-9
        found = [e for e in events if isinstance(e, ActuatorCommanded) and e.t <= last]
        return [(e.t, e.agent, e.actuator, e.data) for e in found]

    wanted, found = commands(recorded(scenario)), commands(sink.events)
    assert len(wanted) > 20 * RUNS[scenario] * 0.5
    assert len({data for *_, data in wanted}) > 20, "the commands say something"
    assert found == wanted[: len(found)]
    assert len(wanted) - len(found) <= len(minds), "at the end the run lets the wheels stand"
