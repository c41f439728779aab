"""Simulated world of a scenario: robots with devices, scripted actors and objects, and judges, without agents."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..agent import RobotDevices
from ..base.clock import Clock, Rate, SimulatedClock
from ..base.errors import Fault, InputError, located_at
from ..base.geometry import Pose2
from ..catalog import (
    ActorSpec,
    ActuatorSpec,
    AgentSpec,
    Catalog,
    RobotSpec,
    ScenarioSpec,
    SensorSpec,
    perturbed,
    running_class,
)
from ..declare import location_of
from ..devices.mujoco import FreeObject, MujocoWorld, RobotInstance, SensorMount, compile_model
from ..devices.simulated import Odometer, PoseSensor, Velocity, WheelTravel
from ..event import EventSink
from ..interfaces.device import Sensor
from ..interfaces.safety_gate import SafetyGate
from .ground import ground_pieces
from .outcome import Goal, Judge
from .placement import jittered, place_all
from .push_schedule import PushSchedule, push_schedules
from .random_streams import CHOICE, ODOMETER, START, loop_of, noise_of, stream
from .scripted_object import ScriptedObject
from .scripted_objects import Free
from .scripted_robots import ScriptedRobot
from .scripts import FREE, object_script, robot_script
from .simulated_device import simulated_device

ENCODED, COUNTS = ("motors", "wheel_radius", "signs"), 4096
"""Keys of an actuator that its encoders share, and their counts per turn of a wheel."""


@dataclass(frozen=True)
class SimulatedWorld:
    """World with all robots and objects at their start poses.

    Attributes:
        world: MuJoCo world.
        clock: Clock of the world.
        sink: Sink for events of devices, pushes and faults.
        robots: Specifications of the robots, by agent or actor, as their agents know them: without perturbations.
        sensors: Sensors by agent, then by name.
        actuators: Safety gates of the actuators, by agent, then by name.
        sensor_rates: Rates of the sensors in control periods, by agent, then by name.
        actors: Scripted actors and objects, and pushes.
        wheels: Functions that return the true wheel linear speeds [m/s], by robot.
        judges: Judges by agent.
        goals: Goals that an agent may enter, by agent.
        starts: Start poses of the robots, world frame.
        spatial: Robots with a recorded height, roll and pitch: those without wheels.
        states: Poses with a name, such as `open`, by object.
    """

    world: MujocoWorld
    clock: Clock
    sink: EventSink
    robots: Mapping[str, RobotSpec]
    sensors: Mapping[str, dict[str, Sensor]]
    actuators: Mapping[str, dict[str, SafetyGate]]
    sensor_rates: Mapping[str, Mapping[str, Rate]]
    actors: Sequence[ScriptedRobot | ScriptedObject | PushSchedule]
    wheels: Mapping[str, Callable[[], list[float]]]
    judges: Mapping[str, Judge]
    goals: Mapping[str, list[Goal]]
    starts: Mapping[str, Pose2]
    spatial: frozenset[str] = frozenset()
    states: Mapping[str, Mapping[str, Pose2]] = field(default_factory=dict)

    def devices(self, agent: str) -> RobotDevices:
        """Devices of an agent's robot."""
        return RobotDevices(self.robots[agent], self.sensors[agent], self.actuators[agent], self.sensor_rates[agent])


def build_world(
    scenario: ScenarioSpec, catalog: Catalog, seed: int, sink: EventSink, *, clock: Clock | None = None
) -> SimulatedWorld:
    """Compose the world, place all robots and objects, and construct all devices.

    Args:
        scenario: The scenario.
        catalog: Source of the robots and the world.
        seed: Seed of the episode.
        sink: Sink for events of the devices.
        clock: Clock of the world; a simulated clock by default.

    Raises:
        InputError: Content is missing or inconsistent, or a start pose is in collision.
    """
    time = clock or SimulatedClock(scenario.rate.physics)
    world, robots, actual = _compose(scenario, catalog, time, seed)
    world.places = {place.name: place.pose for place in scenario.places}
    # Scripted objects first: robots in collision with one are sampled again, objects are not.
    objects = _scripted_objects(world, catalog, scenario, seed)
    at_rest = _at_rest(scenario, seed)
    with located_at(scenario.file):
        starts = place_all(world, [*scenario.agents, *(m for m in scenario.actors if m.robot)], scenario.name, seed)
    wheels: dict[str, Callable[[], list[float]]] = {}
    sensors, actuators = {}, {}
    for name in (agent.name for agent in scenario.agents):
        sensors[name] = _sensors(world, catalog, scenario, name, actual[name], seed)
        with located_at(actual[name].file):
            _add_odometer(world, name, actual[name], sensors[name], stream(scenario.name, seed, name, ODOMETER))
        actuators[name] = {
            a.name: _actuator(world, catalog, name, actual[name], a, scenario, seed, sink, wheels)
            for a in actual[name].actuators
        }
        for gate in actuators[name].values():
            world.guard(gate)
    return SimulatedWorld(
        world=world,
        clock=time,
        sink=sink,
        robots=robots,
        sensors=sensors,
        actuators=actuators,
        sensor_rates={
            a.name: {s.name: scenario.rate.sensor_rate(s.rate, s.name) for s in actual[a.name].sensors}
            for a in scenario.agents
        },
        actors=[
            *(each for each in objects if each.name not in at_rest),
            *_actors(world, catalog, scenario, robots, seed, wheels),
            *push_schedules(scenario, seed, world, sink),
        ],
        wheels=wheels,
        judges={a.name: _judge(scenario, a) for a in scenario.agents},
        goals={a.name: _goals_of(scenario, a.name) for a in scenario.agents},
        starts=starts,
        spatial=frozenset(name for name, robot in robots.items() if not robot.locomotion.wheels),
        states={each.name: each.states for each in objects},
    )


def _sensors(
    world: MujocoWorld, catalog: Catalog, scenario: ScenarioSpec, name: str, robot: RobotSpec, seed: int
) -> dict[str, Sensor]:
    """Sensors of an agent's robot, by name."""
    made: dict[str, Sensor] = {}
    for spec in robot.sensors:
        sensor, rng = simulated_device(catalog, robot, spec), stream(scenario.name, seed, name, noise_of(spec.name))
        with located_at(robot.file, spec.line), running_class(type(sensor)):
            made[spec.name] = sensor.bind(
                spec.name, world, name, rng, noise=spec.noise, latency=spec.latency, drop_out=spec.drop_out
            )
    return made


def _add_odometer(
    world: MujocoWorld, name: str, robot: RobotSpec, sensors: Mapping[str, Sensor], rng: np.random.Generator
) -> None:
    """Connect the pose sensors that read an odometer to one of the robot's own wheels, or of its base without any."""
    dead = [each for each in sensors.values() if isinstance(each, PoseSensor) and each.odometry]
    if not dead:
        return
    travel, motors = None, robot.mover.parameters
    if robot.locomotion.wheels and isinstance(motors, Velocity):
        encoders = WheelTravel(**{key: getattr(motors, key) for key in ENCODED}, counts=COUNTS)
        travel = encoders.bind(ODOMETER, world, name).sample
    odometer = Odometer(world, name, dead[0].odometry, rng, travel, robot.locomotion)
    for each in dead:
        each.odometer = odometer


def _judge(scenario: ScenarioSpec, agent: AgentSpec) -> Judge:
    goals, success = _goals_of(scenario), agent.success
    return Judge(
        next((g for g in goals if g.name == success.goal), None),
        at_end=success.at == "end",
        after=[(g, success.after[g.name]) for g in goals if g.name in success.after],
        end_on_collision=scenario.end_on_collision,
    )


def compose_scenario(scenario: ScenarioSpec, catalog: Catalog, clock: Clock | None = None) -> MujocoWorld:
    """Compiled world of a scenario, with its robots at the origin and without devices.

    Raises:
        InputError: Content is missing or inconsistent.
    """
    return _compose(scenario, catalog, clock or SimulatedClock(scenario.rate.physics))[0]


def _compose(
    scenario: ScenarioSpec, catalog: Catalog, clock: Clock, seed: int = 1
) -> tuple[MujocoWorld, dict[str, RobotSpec], dict[str, RobotSpec]]:
    """Compiled world, the robots as their agents know them, and the robots as they are, with perturbations."""
    specs = {name: catalog.load_robot(name) for name in scenario.robots}
    robots = {a.name: catalog.robot_of(a) for a in scenario.agents}
    robots |= {m.name: specs[m.robot] for m in scenario.actors if m.robot}
    agents = {agent.name for agent in scenario.agents}
    actual = robots | {a.name: perturbed(robots[a.name], a.perturbations) for a in scenario.agents}
    placed = []
    for name, spec in actual.items():
        if spec.model is None:
            raise InputError(
                Fault(f"the robot '{spec.name}' has no model.", spec.file, hint='Add model = "robot.xml".')
            )
        mounts = [_mount(catalog, spec, s) for s in spec.sensors] if name in agents else []
        placed.append(RobotInstance(name, spec.model, mounts, spec.variant))
    arena, step = catalog.find("world", scenario.world), scenario.rate.physics
    free = [_free_object(scenario, actor) for actor in scenario.actors if not actor.robot and actor.script == FREE]
    named = (scenario.name, seed) if any(ground.kind == "rough" for ground in scenario.grounds) else ()
    grounds = (*scenario.grounds, *named)
    key = (
        "model",
        arena,
        step,
        grounds,
        tuple(free),
        *((name, spec.file, name in agents, spec.variant) for name, spec in actual.items()),
        *(agent.perturbations for agent in scenario.agents),
        *(repr(agent.overlay) for agent in scenario.agents),
    )

    def compiled() -> Any:
        ground = ground_pieces(scenario, seed)
        return compile_model(
            arena.path, placed, step=step, within=catalog.roots, text=arena.text, ground=ground, free=free
        )

    model = catalog.cached(key, compiled)
    world = MujocoWorld(model, list(robots), clock)
    for name, spec in robots.items():
        if spec.body.ground_contact is not None:
            with located_at(spec.file):
                world.allow_ground_contact(name, spec.body.ground_contact)
    return world, robots, actual


def _free_object(scenario: ScenarioSpec, actor: ActorSpec) -> FreeObject:
    with located_at(scenario.file, location_of(actor).line):
        if actor.one_of:
            message = f"'{actor.name}' has no motion of its own that the seed could select, as its script is '{FREE}'."
            raise InputError(Fault(message, hint="Remove one_of."))
        mass = actor.with_keys(Free).mass
    return FreeObject(actor.name, mass, scenario.file, location_of(actor).line)


def _mount(catalog: Catalog, robot: RobotSpec, sensor: SensorSpec) -> SensorMount:
    device = simulated_device(catalog, robot, sensor)
    return SensorMount(sensor.name, device, robot.file, sensor.line, partial(running_class, type(device)))


def _actuator(
    world: MujocoWorld,
    catalog: Catalog,
    owner: str,
    robot: RobotSpec,
    spec: ActuatorSpec,
    scenario: ScenarioSpec,
    seed: int,
    sink: EventSink | None,
    wheels: dict[str, Callable[[], list[float]]],
) -> SafetyGate:
    """Safety gate of one actuator; adds the function for the true wheel speeds of the owner to `wheels`."""
    actuator = simulated_device(catalog, robot, spec)
    with located_at(robot.file, spec.line), running_class(type(actuator)):
        device = actuator.bind(spec.name, world, owner, stream(scenario.name, seed, owner, loop_of(spec.name)))
        robot.check_twists(device)
        gate = spec.guard(device, world.clock, scenario.rate.control_rate.period, sink, owner)
    if device.has_loop:
        world.attach(partial(gate.run, device.before_step))
    if spec.name == robot.motion.actuator:
        wheeled = bool(robot.locomotion.wheels)
        if not isinstance(device, Velocity):  # the world knows the commands of velocity motors
            world.watch_motion(owner, gate)
        if hasattr(device, "measured") and wheeled:
            wheels[owner] = device.measured
    return gate


def _actors(
    world: MujocoWorld,
    catalog: Catalog,
    scenario: ScenarioSpec,
    robots: Mapping[str, RobotSpec],
    seed: int,
    wheels: dict[str, Callable[[], list[float]]],
) -> list[ScriptedRobot]:
    actors = []
    for actor in (m for m in scenario.actors if m.robot):
        robot = robots[actor.name]
        spec = robot.mover
        gate = _actuator(world, catalog, actor.name, robot, spec, scenario, seed, None, wheels)
        with located_at(scenario.file, location_of(actor).line):
            made = robot_script(actor, partial(catalog.load_script, scenario))
            with running_class(type(made)):
                made.bind(
                    actor.name, world, robot.locomotion, gate, stream(scenario.name, seed, actor.name, actor.script)
                )
        actors.append(made)
    return actors


def _scripted_objects(world: MujocoWorld, catalog: Catalog, scenario: ScenarioSpec, seed: int) -> list[ScriptedObject]:
    """Place all objects of the scenario, and construct their scripts."""
    made, at_rest = [], _at_rest(scenario, seed)
    for actor in (m for m in scenario.actors if not m.robot):
        start = jittered(actor.pose, actor.jitter, stream(scenario.name, seed, actor.name, START))
        with located_at(scenario.file, location_of(actor).line):
            each = object_script(actor, partial(catalog.load_script, scenario))
            rng = stream(scenario.name, seed, actor.name, actor.script)
            with running_class(type(each)):
                each.bind(actor.name, world, start, rng, scenario.rate.control_rate.period)
        if actor.name in at_rest:
            world.place_object(actor.name, start)  # a script may begin at another pose
        made.append(each)
    return made


def _at_rest(scenario: ScenarioSpec, seed: int) -> set[str]:
    """Objects that do not follow their scripts: of each group all except one, which the seed selects."""
    groups: dict[str, list[str]] = {}
    for actor in scenario.actors:
        if actor.one_of:
            groups.setdefault(actor.one_of, []).append(actor.name)
    selected = [
        names[int(stream(scenario.name, seed, group, CHOICE).integers(len(names)))] for group, names in groups.items()
    ]
    return {name for names in groups.values() for name in names}.difference(selected)


def _goals_of(scenario: ScenarioSpec, agent: str | None = None) -> list[Goal]:
    """Goals of the scenario, or only those of one agent if it is given."""
    return [
        Goal(p.name, p.pose, p.tolerance, p.z, p.height_tolerance)
        for p in scenario.places
        if p.kind == "goal" and (agent is None or agent in p.agents)
    ]
