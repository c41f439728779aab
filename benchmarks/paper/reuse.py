"""Reuse between two scenarios: equal and different files, classes of rocs_bt in the agents, and settings.

The paper claims reuse: the mission stays when the robot is replaced, and the robot stays when the task is replaced
(6.2, Q2 and Q3).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rocs_bt.actions import action_table
from rocs_bt.agent import AgentRuntime, RobotDevices
from rocs_bt.base.clock import Clock, SimulatedClock
from rocs_bt.base.files import read_bytes
from rocs_bt.catalog import (
    KINDS,
    ActorSpec,
    ActuatorSpec,
    AgentSpec,
    Catalog,
    Entry,
    RobotSpec,
    ScenarioSpec,
    SensorSpec,
    command_size,
    content_hash,
)
from rocs_bt.catalog.registered_devices import registered_devices
from rocs_bt.event import EventSink, NullSink
from rocs_bt.interfaces.device import Actuator, Sensor
from rocs_bt.ros2.devices.actuator_node import ActuatorNode
from rocs_bt.ros2.devices.sensor_node import SensorNode
from rocs_bt.running.build_agents import build_agents, load_controller
from rocs_bt.running.hardware_devices import hardware_driver, on_hardware
from rocs_bt.running.simulated_stage import simulated_agents
from rocs_bt.simulation.simulated_world import build_world

from .provenance import package_of, used_classes
from .settings import Setting, settings

Robot = AgentSpec | ActorSpec


@dataclass(frozen=True)
class Piece:
    """Piece of content that a scenario uses.

    Attributes:
        kind: Kind of content in the catalog.
        name: Name of the content.
        content_hash: sha256 over the files of the content.
        lines: Number of lines in these files.
    """

    kind: str
    name: str
    content_hash: str
    lines: int


@dataclass(frozen=True)
class Share:
    """Overlap of two scenarios or agents in one kind of content or one subpackage of the engine.

    Attributes:
        kind: Kind of content, or subpackage of the engine.
        both: Names that both use, with equal content.
        changed: Names that both use, with different content.
        first: Names that only the first uses.
        second: Names that only the second uses.
    """

    kind: str
    both: tuple[str, ...]
    changed: tuple[str, ...]
    first: tuple[str, ...]
    second: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not (self.changed or self.first or self.second)


@dataclass(frozen=True)
class Counterpart:
    """Robot of the first scenario and its counterpart in the second.

    Attributes:
        first: Name of the robot in the first scenario; empty if there is none.
        second: Name of the robot in the second scenario; empty if there is none.
        settings: Settings of both robots.
        code: Engine classes of their agents, by subpackage; empty for robots without an agent.
    """

    first: str
    second: str
    settings: tuple[Setting, ...]
    code: tuple[Share, ...]

    def differing(self) -> tuple[str, ...]:
        """Names of the settings that differ."""
        return tuple(setting.what for setting in self.settings if not setting.same)


@dataclass(frozen=True)
class Reuse:
    """Content and code that two scenarios share, and the settings in which they differ.

    Attributes:
        first: Name of the first scenario.
        second: Name of the second scenario.
        content: Overlap in content, one item per kind of content.
        code: Overlap in engine classes of all agents, one item per subpackage.
        settings: Settings of both scenarios; settings of their robots are in `robots`.
        robots: Each robot with its counterpart: the robot of the same name, else the next robot without a counterpart.
        pieces: All content that the scenarios use, under the keys `first` and `second`.
    """

    first: str
    second: str
    content: tuple[Share, ...]
    code: tuple[Share, ...]
    settings: tuple[Setting, ...]
    robots: tuple[Counterpart, ...]
    pieces: Mapping[str, tuple[Piece, ...]]


def diff(first: ScenarioSpec, second: ScenarioSpec, catalog: Catalog) -> Reuse:
    """Compare two scenarios; the agents of both are built but not run.

    Args:
        first: First scenario.
        second: Second scenario.
        catalog: Source of the content.

    Raises:
        InputError: The content is invalid.
    """
    pieces = [tuple(map(_piece, catalog.content_of(s))) for s in (first, second)]
    used = [_code(s, catalog) for s in (first, second)]
    classes = [{cls for of_agent in agents.values() for cls in of_agent} for agents in used]
    pairs = [*_pairs(first.agents, second.agents), *_pairs(first.actors, second.actors)]
    kinds = [k for k in KINDS if any(p.kind == k for p in (*pieces[0], *pieces[1]))]
    hashes = [{k: {p.name: p.content_hash for p in of if p.kind == k} for k in kinds} for of in pieces]
    return Reuse(
        first=first.name,
        second=second.name,
        content=tuple(_share(kind, *(of[kind] for of in hashes)) for kind in kinds),
        code=_by_package(*classes),
        settings=settings(first, second),
        robots=tuple(_counterpart(*pair, used) for pair in pairs),
        pieces={"first": pieces[0], "second": pieces[1]},
    )


def _piece(entry: Entry) -> Piece:
    lines = sum(read_bytes(file).count(b"\n") for file in entry.files())
    return Piece(entry.kind, entry.name, content_hash([entry]), lines)


def _code(scenario: ScenarioSpec, catalog: Catalog) -> dict[str, tuple[type, ...]]:
    """Classes of rocs_bt that each agent consists of, by agent."""
    sink = NullSink()
    if any(on_hardware(catalog, catalog.load_robot(agent.robot)) for agent in scenario.agents):
        clock: Clock = SimulatedClock(scenario.rate.control_rate.period)
        devices = {agent.name: _unopened_devices(scenario, agent, catalog, clock, sink) for agent in scenario.agents}
        shared: tuple[object, ...] = (clock, sink)
        agents = build_agents(scenario, catalog, devices, AgentRuntime(clock, sink))
    else:
        simulated = build_world(scenario, catalog, 1, sink)
        shared = (simulated.world, simulated.clock, sink)
        agents = simulated_agents(scenario, simulated, catalog, sink)
    found = {}
    for agent, spec in zip(agents, scenario.agents, strict=True):
        actions = action_table(*load_controller(scenario, spec, catalog).actions)
        found[agent.name] = used_classes(agent, shared, actions)
        agent.close()
    return found


def _unopened_devices(
    scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, clock: Clock, sink: EventSink
) -> RobotDevices:
    """Devices of a robot on hardware, without their connections."""
    robot, period = catalog.load_robot(agent.robot), scenario.rate.control_rate.period
    return RobotDevices(
        robot,
        {s.name: _unopened_sensor(catalog, robot, s) for s in robot.sensors},
        {
            a.name: a.guard(_unopened_actuator(catalog, robot, a), clock, period, sink, agent.name)
            for a in robot.actuators
        },
        {s.name: scenario.rate.sensor_rate(s.rate, s.name) for s in robot.sensors},
    )


def _by_package(first: Iterable[type], second: Iterable[type]) -> tuple[Share, ...]:
    """Overlap of classes by subpackage. Both scenarios use the same engine, so no class can differ in content."""
    sides = [{(package_of(cls), cls.__name__) for cls in classes} for classes in (first, second)]
    packages = sorted({package for side in sides for package, _ in side})
    return tuple(_share(p, *({name: "" for package, name in side if package == p} for side in sides)) for p in packages)


def _share(kind: str, first: Mapping[str, str], second: Mapping[str, str]) -> Share:
    """Overlap of two mappings from names to digests of their content."""
    common = sorted(first.keys() & second.keys())
    return Share(
        kind,
        both=tuple(name for name in common if first[name] == second[name]),
        changed=tuple(name for name in common if first[name] != second[name]),
        first=tuple(sorted(first.keys() - second.keys())),
        second=tuple(sorted(second.keys() - first.keys())),
    )


def _pairs(first: Sequence[Robot], second: Sequence[Robot]) -> Iterator[tuple[Robot | None, Robot | None]]:
    """Pairs of robots: of the same name in both scenarios, else the next ones with different names."""
    there = {robot.name: robot for robot in second}
    new = [robot for robot in second if robot.name not in {r.name for r in first}]
    for robot in first:
        yield robot, there.get(robot.name) or (new.pop(0) if new else None)
    yield from ((None, robot) for robot in new)


def _counterpart(
    first: Robot | None, second: Robot | None, used: Sequence[Mapping[str, tuple[type, ...]]]
) -> Counterpart:
    names = ["" if robot is None else robot.name for robot in (first, second)]
    classes = [side.get(name, ()) for side, name in zip(used, names, strict=True)]
    return Counterpart(names[0], names[1], settings(first, second), _by_package(*classes))


def _unopened_sensor(catalog: Catalog, robot: RobotSpec, spec: SensorSpec) -> Sensor:
    """Sensor on hardware without its connection, to build an agent that will not run; see `hardware_driver`."""
    made: Sensor = _unopened(_device_class(catalog, robot, spec, SensorNode), "read", "close")
    Sensor.__init__(made, spec.name)
    return made


def _unopened_actuator(catalog: Catalog, robot: RobotSpec, spec: ActuatorSpec) -> Actuator:
    """Actuator on hardware without its connection, to build an agent that will not run; see `hardware_driver`."""
    made: Actuator = _unopened(_device_class(catalog, robot, spec, ActuatorNode), "command", "neutral", "close")
    Actuator.__init__(made, spec.name, command_size(robot, spec))
    return made


def _device_class(catalog: Catalog, robot: RobotSpec, spec: SensorSpec | ActuatorSpec, ros2: type) -> Any:
    """Class of a device; `ros2` for registered devices."""
    return ros2 if registered_devices(spec.driver) else hardware_driver(catalog, robot, spec)[0]


def _unopened(cls: Any, *names: str) -> Any:
    """Object of a subclass, without a call of the constructor; its methods of these names do nothing."""
    made: Any = type("_Unopened", (cls,), dict.fromkeys(names, lambda *args: None))
    return made.__new__(made)
