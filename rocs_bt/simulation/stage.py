"""Setting the stage: from a scenario's file to a world with robots that can sense and act, but do not think yet."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..agent import robot_drive
from ..catalog import ActuatorSpec, Catalog, RobotSpec, ScenarioSpec, SensorSpec
from ..clock import Clock, Rate, SimulatedClock
from ..device import Sensor
from ..drivers.mujoco import MujocoWorld, Placed, SensorMount, compile_model, make_actuator, make_sensor
from ..errors import Fault, InputError, blame
from ..event import EventSink
from ..geometry import Pose2
from ..safety import SafetyGate
from .carried import Carrier, make_carrier
from .devices import mujoco_driver
from .mover import Mover, make_mover
from .outcome import Goal, Judge
from .placement import jittered, place_all
from .streams import START, noise_of, stream


@dataclass(frozen=True)
class Stage:
    """A world in which everybody stands at the start.

    Attributes:
        world: The world.
        clock: Its time.
        robots: By agent and mover.
        sensors: By agent, then by name.
        actuators: Behind their limits; by agent, then by name.
        sensor_rates: By agent, then by name, over control periods.
        movers: Who else moves.
        wheels: By robot, how fast its rims truly go [m/s].
        judges: By agent.
        goals: By agent, those that it may enter.
        starts: Where everybody stands.
    """

    world: MujocoWorld
    clock: Clock
    robots: Mapping[str, RobotSpec]
    sensors: Mapping[str, dict[str, Sensor]]
    actuators: Mapping[str, dict[str, SafetyGate]]
    sensor_rates: Mapping[str, Mapping[str, Rate]]
    movers: Sequence[Mover | Carrier]
    wheels: Mapping[str, Callable[[], list[float]]]
    judges: Mapping[str, Judge]
    goals: Mapping[str, list[Goal]]
    starts: Mapping[str, Pose2]


def set_stage(
    scenario: ScenarioSpec, catalog: Catalog, seed: int, sink: EventSink, *, clock: Clock | None = None
) -> Stage:
    """Compose the world, place everybody, and make all devices.

    Args:
        scenario: What is to be played.
        catalog: Where its robots and its world are found.
        seed: The episode's seed.
        sink: Where events go.
        clock: Time; a simulated one by default.

    Raises:
        InputError: Content is missing or does not fit together, or somebody would start inside of something.
    """
    time = clock or SimulatedClock(scenario.rate.physics)
    world, robots = _compose(scenario, catalog, time)
    # Things first, since they stand where they stand: robots are drawn anew while they are inside of one.
    carriers = _carriers(world, scenario, seed)
    with blame(scenario.file):
        starts = place_all(world, [*scenario.agents, *(m for m in scenario.movers if m.robot)], scenario.name, seed)
    sensors: dict[str, dict[str, Sensor]] = {}
    actuators: dict[str, dict[str, SafetyGate]] = {}
    wheels: dict[str, Callable[[], list[float]]] = {}
    for agent in scenario.agents:
        spec = robots[agent.name]
        sensors[agent.name] = {}
        for s in spec.sensors:
            driver = mujoco_driver(catalog, spec, s)
            with blame(spec.file, s.line), driver.running():
                sensors[agent.name][s.name] = make_sensor(
                    world,
                    agent.name,
                    s.name,
                    driver.make,
                    driver.parameters,
                    noise=s.noise,
                    rng=stream(scenario.name, seed, agent.name, noise_of(s.name)),
                )
        actuators[agent.name] = {
            a.name: _actuator(world, catalog, agent.name, spec, a, scenario, sink, wheels) for a in spec.actuators
        }
        for gate in actuators[agent.name].values():
            world.guard(gate)
    rates = {
        a.name: {s.name: scenario.rate.sensor_rate(s.rate, s.name) for s in robots[a.name].sensors}
        for a in scenario.agents
    }
    movers: list[Mover | Carrier] = [*carriers, *_movers(world, catalog, scenario, robots, seed, wheels)]
    goals = {
        a.name: [Goal(p.name, p.pose, p.tolerance) for p in scenario.places if p.kind == "goal" and a.name in p.agents]
        for a in scenario.agents
    }
    judges = {
        a.name: Judge(
            next((g for g in _goals_of(scenario) if g.name == a.success), None),
            at_end=a.at_end,
            after=[(g, a.after[g.name]) for g in _goals_of(scenario) if g.name in a.after],
            end_on_collision=scenario.end_on_collision,
        )
        for a in scenario.agents
    }
    return Stage(world, time, robots, sensors, actuators, rates, movers, wheels, judges, goals, starts)


def compose_scenario(scenario: ScenarioSpec, catalog: Catalog, clock: Clock | None = None) -> MujocoWorld:
    """A scenario's compiled world alone, with its robots at the origin.

    Raises:
        InputError: Content is missing or does not fit together.
    """
    return _compose(scenario, catalog, clock or SimulatedClock(scenario.rate.physics))[0]


def _compose(scenario: ScenarioSpec, catalog: Catalog, clock: Clock) -> tuple[MujocoWorld, dict[str, RobotSpec]]:
    specs = {name: catalog.load_robot(name) for name in scenario.robots}
    robots = {a.name: specs[a.robot] for a in scenario.agents}
    robots |= {m.name: specs[m.robot] for m in scenario.movers if m.robot}
    minds = {agent.name for agent in scenario.agents}
    placed = []
    for name, spec in robots.items():
        if spec.model is None:
            raise InputError(
                Fault(f"the robot '{spec.name}' has no model.", spec.file, hint='Add model = "robot.xml".')
            )
        mounts = [_mount(catalog, spec, s) for s in spec.sensors] if name in minds else []
        placed.append(Placed(name, spec.model, mounts))
    arena, step = catalog.find("world", scenario.world).path, scenario.rate.physics
    key = ("model", arena, step, *((name, spec.file, name in minds) for name, spec in robots.items()))
    model = catalog.keep(key, lambda: compile_model(arena, placed, step=step, within=catalog.roots))
    return MujocoWorld(model, list(robots), clock), robots


def _mount(catalog: Catalog, robot: RobotSpec, sensor: SensorSpec) -> SensorMount:
    driver = mujoco_driver(catalog, robot, sensor)
    return SensorMount(sensor.name, driver.make, driver.parameters, robot.file, sensor.line, driver.running)


def _actuator(
    world: MujocoWorld,
    catalog: Catalog,
    owner: str,
    robot: RobotSpec,
    spec: ActuatorSpec,
    scenario: ScenarioSpec,
    sink: EventSink | None,
    wheels: dict[str, Callable[[], list[float]]],
) -> SafetyGate:
    """One actuator behind its limits; notes in `wheels` how fast the owner's wheels truly go."""
    driver = mujoco_driver(catalog, robot, spec)
    with blame(robot.file, spec.line), driver.running():
        device = make_actuator(world, owner, spec.name, driver.make, driver.parameters)
        gate = spec.guard(device, world.clock, scenario.rate.control_rate.period, sink, owner)
    if spec.name == robot.drive.actuator and hasattr(device, "measured"):
        wheels[owner] = device.measured
    return gate


def _movers(
    world: MujocoWorld,
    catalog: Catalog,
    scenario: ScenarioSpec,
    robots: Mapping[str, RobotSpec],
    seed: int,
    wheels: dict[str, Callable[[], list[float]]],
) -> list[Mover]:
    movers = []
    for mover in (m for m in scenario.movers if m.robot):
        robot = robots[mover.name]
        spec = next(a for a in robot.actuators if a.name == robot.drive.actuator)
        gate = _actuator(world, catalog, mover.name, robot, spec, scenario, None, wheels)
        with blame(scenario.file, mover.line):
            made = make_mover(
                mover.script,
                mover.parameters,
                name=mover.name,
                world=world,
                drive=robot_drive(robot.drive),
                wheels=gate,
                rng=stream(scenario.name, seed, mover.name, mover.script),
            )
        movers.append(made)
    return movers


def _carriers(world: MujocoWorld, scenario: ScenarioSpec, seed: int) -> list[Carrier]:
    made = []
    for mover in (m for m in scenario.movers if not m.robot):
        rng = stream(scenario.name, seed, mover.name, START)
        with blame(scenario.file, mover.line):
            made.append(
                make_carrier(
                    mover.script,
                    mover.parameters,
                    name=mover.name,
                    world=world,
                    start=jittered(mover.pose, mover.jitter, rng),
                    rng=stream(scenario.name, seed, mover.name, mover.script),
                    period=scenario.rate.control_rate.period,
                )
            )
    return made


def _goals_of(scenario: ScenarioSpec) -> list[Goal]:
    return [Goal(p.name, p.pose, p.tolerance) for p in scenario.places if p.kind == "goal"]
