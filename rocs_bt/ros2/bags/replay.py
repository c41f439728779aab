"""Replay of a ROS bag as the sensors of a robot: a recording with the signals that rules read, without any command."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ...agent import Agent, AgentRuntime, Controller, Rates, RobotDevices, build_agent
from ...base.clock import Rate, SimulatedClock
from ...base.errors import DeviceError, Fault, InputError, RecordingError
from ...base.words import listed
from ...catalog import Catalog, RateSpec, RobotSpec, SensorSpec
from ...devices.host import Host
from ...event import BodyMoved, EventSink, OutcomeDecided
from ...plan import Mission, Plan
from ...record import AgentInfo, Recording, RunHeader
from ...running.build_agents import worldless_devices
from ...running.hardware_devices import make_sensor
from ...running.header import box_body, signals_of, versions
from ...running.run_files import RunFiles
from ...running.sink_thread import Relay
from ..devices.actuator_node import shared_node
from ..devices.parameters import Ros2SensorParameters
from ..messages.message_types import POSE, TRANSFORMS
from ..messages.takes import pose3
from ..messages.type_store import TypeStore
from ..network.qos import QoS
from ..settings import Ros2Settings
from .bag_file import Bag
from .transport import BagReader, BagTransport

GOAL_TOPIC, GOAL_TYPE = "goal_pose", POSE
"""Topic of the robot's goal, as rviz and Nav2 publish it."""


@dataclass(frozen=True)
class BagReplay:
    """Result of a replay."""

    recording: Recording
    topics: Mapping[str, tuple[str, ...]]  # by sensor; empty for a sensor that the bag does not have
    counts: Mapping[str, int]  # number of messages in the bag by topic


def replay_bag(
    path: Path,
    robot: RobotSpec,
    catalog: Catalog,
    out: Path,
    *,
    start: float = 0.0,
    duration: float = math.inf,
    control: float = 20.0,
) -> BagReplay:
    """Feed a bag to the sensors of a robot, and record readings, signals and changes; no reflex or mission acts.

    Args:
        path: Bag: folder of a rosbag2, its file, or a ROS 1 bag.
        robot: Robot with sensors that read topics of ROS 2.
        catalog: Source of the robot's own classes.
        out: Folder of the recording.
        start: Time in the bag at which the replay begins [s].
        duration: Maximum duration [s].
        control: Control rate [Hz].

    Raises:
        InputError: The bag cannot be read, or does not have the robot's topics; contains all faults.
        RecordingError: The bag is damaged, or the recording cannot be written.
    """
    rate = RateSpec(control=control)
    clock = SimulatedClock(rate.physics)
    settings = robot.tables.get("ros2", Ros2Settings())
    with ExitStack() as stack:
        bag = Bag(path)
        stack.callback(bag.close)
        if start > (long := (bag.end - bag.start) * 1e-9):
            raise InputError(Fault(f"the bag '{path}' has {long:.1f} s, so it cannot begin at {start:g} s."))
        topics = _topics(robot, settings, bag)
        names = {topic for found in topics.values() for topic in found}
        statics = {f"{topic}_static" for topic in names if bag.topics[topic].type == TRANSFORMS}
        goal = settings.topic(GOAL_TOPIC)
        goals = {goal} if goal in bag.topics and bag.topics[goal].type == GOAL_TYPE else set()
        transport = BagTransport(
            bag,
            [*names, *statics, *goals],
            clock,
            distro=settings.distro,
            start=start,
            duration=duration,
            use_sim_time=settings.use_sim_time,
        )
        host, sink = Host(clock), Relay()
        shared_node(settings, host, transport)
        devices = _devices(robot, catalog, host, rate, {name for name, found in topics.items() if found}, sink)
        reader = transport.reader(goal, GOAL_TYPE, QoS.COMMAND)
        agent = build_agent(
            robot.name,
            devices,
            Controller(build=partial(_Goals, transport.types, reader), mission="bag", schema=catalog.load_schema()),
            Rates(control=Rate(1, rate.control_rate.period), plan=rate.plan_rate),
            AgentRuntime(clock, sink),
            load_class=catalog.load_class,
        )
        stack.callback(agent.close)
        files = RunFiles(out)
        stack.callback(files.unlock)
        files.begin(_header(path, robot, agent, rate))
        stack.callback(files.abandon)
        assert files.recorder is not None
        sink.open(files.recorder)
        _play(agent, transport, clock, rate.control_rate, files.recorder)
        files.abandon()
        if files.missing:
            raise RecordingError(files.missing[0])
    counts = {name: bag.topics[name].count for name in sorted(names)}
    return BagReplay(Recording.open(out), topics, counts)


def _topics(robot: RobotSpec, settings: Ros2Settings, bag: Bag) -> dict[str, tuple[str, ...]]:
    """Topics by sensor, of which the bag has all; empty for other sensors. Raises InputError."""
    found: dict[str, tuple[str, ...]] = {}
    faults = []
    for sensor in robot.sensors:
        found[sensor.name] = ()
        if not isinstance(given := sensor.parameters, Ros2SensorParameters):
            continue
        topics = tuple(settings.topic(topic) for topic in given.all_topics)
        wrong = [_misfit(sensor, topic, given.type, bag) for topic in topics]
        if not any(wrong):
            found[sensor.name] = topics
        elif not sensor.optional:
            faults += [replace(fault, file=robot.file, line=sensor.line) for fault in wrong if fault is not None]
    if faults:
        raise InputError(*faults)
    if not any(found.values()):
        hint = 'Its sensors need driver = "ros2", a topic and a type: see docs/ros2-without-a-robot.md.'
        raise InputError(Fault(f"the robot '{robot.name}' reads no topic of the bag '{bag.path}'.", hint=hint))
    return found


def _misfit(sensor: SensorSpec, topic: str, kind: str, bag: Bag) -> Fault | None:
    """Fault of a topic that the bag does not have with this type."""
    if (known := bag.topics.get(topic)) is None:
        alike = sorted(name for name, each in bag.topics.items() if each.type == kind)
        hint = f"Topics of type {kind}: {listed(alike)}." if alike else f"It has {listed(sorted(bag.topics)[:20])}."
        return Fault(f"sensor '{sensor.name}' reads '{topic}', but the bag '{bag.path}' has no such topic.", hint=hint)
    if known.type != kind:
        message = f"sensor '{sensor.name}' reads {kind}, but '{topic}' in the bag '{bag.path}' is {known.type}."
        return Fault(message, hint=f'Write type = "{known.type}", or name another topic.')
    return None


def _devices(
    robot: RobotSpec, catalog: Catalog, host: Host, rate: RateSpec, read: Collection[str], sink: EventSink
) -> RobotDevices:
    """Sensors that read the bag, others without readings, and actuators without effect."""
    devices = worldless_devices(robot, rate, host.clock, sink, robot.name)
    bag = {
        s.name: make_sensor(catalog, robot, s, host, devices.sensor_rates[s.name])
        for s in robot.sensors
        if s.name in read
    }
    return replace(devices, sensors={**devices.sensors, **bag})


class _Goals(Plan):
    """Plan that pursues the goals of the bag and submits no action."""

    def __init__(self, types: TypeStore, reader: BagReader, mission: Mission) -> None:
        super().__init__("bag", **mission.parts)
        self._types = types
        self._reader = reader

    def run(self, t: float) -> None:
        """Pursue a new goal."""
        self.changes()
        sample = self._reader.take()
        if sample is None:
            return
        with suppress(DeviceError):  # a malformed goal is no goal
            pose = self._types.deserialize(sample.data, GOAL_TYPE).pose
            self.knowledge.world.place(GOAL_TOPIC, pose3(pose.position, pose.orientation).plane, kind="goal")
            self.knowledge.world.pursue(GOAL_TOPIC)


def _header(path: Path, robot: RobotSpec, agent: Agent, rate: RateSpec) -> RunHeader:
    locomotion = agent.knowledge.robot.locomotion
    info = AgentInfo(
        name=agent.name,
        robot=robot.name,
        mission="bag",
        signals=signals_of(agent),
        axes=() if locomotion.wheels else locomotion.values,
    )
    return RunHeader(
        scenario=path.resolve().stem,
        seed=0,
        versions=versions(),
        rates={"physics": 1.0 / rate.physics, "control": rate.control, "plan": rate.plan},
        agents=(info,),
        bodies=(box_body(agent.name, robot),),
        simulated=False,
    )


def _play(agent: Agent, transport: BagTransport, clock: SimulatedClock, control: Rate, sink: EventSink) -> None:
    """Run the agent until the bag ends."""
    count, name = 0, agent.name
    while True:
        transport.advance()
        agent.step(count)
        if agent.failure is not None:
            raise agent.failure
        pose = agent.knowledge.robot.pose()
        if math.isfinite(pose.x + pose.y + pose.yaw):
            sink.emit(BodyMoved(t=clock.now(), agent=name, body=name, x=pose.x, y=pose.y, yaw=pose.yaw))
        clock.advance(control.every)
        count += 1
        if transport.ended:
            break
    agent.stop("the end of the bag")
    sink.emit(OutcomeDecided(t=clock.now(), agent=name, outcome="timeout", reason="the bag ended"))
