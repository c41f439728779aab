"""Simulation of a scenario's world with its robots on a ROS 2 network, without agents."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from ...base.clock import SimulatedClock
from ...base.errors import Fault, InputError
from ...catalog import Catalog, ScenarioSpec
from ...event import ContactBegan, EventSink
from ...simulation.pace import Pace
from ...simulation.robot_links import RobotLinks
from ...simulation.simulated_world import SimulatedWorld, build_world
from ..messages import fields as messages
from ..messages.names import robot_namespace
from ..network.qos import QoS, mismatch
from ..network.transport import Endpoint, Transport
from .publishers import ALL_FRAMES, FrameOptions, RobotPublishers, TfPublishers, TopicPublisher
from .robot import COMMAND_TIMEOUT, COMMAND_TYPES, LATEST, Ros2Robot

_TICK = 0.01  # [s] maximum simulated time between two messages of /clock, and two looks for commands


class Screen(Protocol):
    """Display of the world, such as `Viewer`."""

    def show(self) -> bool:
        """Show the present state; False if the display was closed."""


@dataclass(frozen=True)
class SimulationEnd:
    """Figures of a simulation that ended.

    Attributes:
        sim_time: Simulated time [s].
        wall_time: Wall-clock time [s].
        skipped: Wall-clock time that was skipped because the machine was too slow [s].
    """

    sim_time: float
    wall_time: float
    skipped: float

    @property
    def real_time_factor(self) -> float:
        """Simulated time divided by wall-clock time."""
        return self.sim_time / max(self.wall_time, 1e-9)


class Ros2Simulation:
    """World of a scenario with its robots as ROS 2 robots; the scripted actors move as in `rocs-bt run`.

    Everything runs in one thread, and polls: commands, sensors and physics by turns. `/clock` is published at least
    every 10 ms of simulated time. It gets no acknowledgement, and commands arrive by the wall clock, so a simulation is
    not repeatable.

    Args:
        scenario: The scenario.
        catalog: Source of the robots and the world.
        transport: Network.
        sink: Sink for events of the world and the robots.
        seed: Seed of the start poses, of noise and of the scripted actors.
        rate: Simulated time per wall-clock time; 0 for as fast as possible.
        namespace: Namespace of the robot. Several robots get the agents' names in lower case, within this namespace.
        command_type: Message type of velocity commands.
        timeout: Time without a command after which a robot stops [s].
        frames: Transforms that are published.
        notice: Function that is called with each notice about nodes that do not match; None for none.

    Raises:
        InputError: The content is invalid, or two robots would have the same namespace.
        DeviceError: The network refuses a topic.
    """

    def __init__(
        self,
        scenario: ScenarioSpec,
        catalog: Catalog,
        transport: Transport,
        sink: EventSink,
        *,
        seed: int = 1,
        rate: float = 1.0,
        namespace: str = "",
        command_type: str = COMMAND_TYPES["TwistStamped"],
        timeout: float = COMMAND_TIMEOUT,
        frames: FrameOptions = ALL_FRAMES,
        notice: Callable[[str], None] | None = None,
    ) -> None:
        spaces = _namespaces([agent.name for agent in scenario.agents], namespace)
        self._clock = SimulatedClock(scenario.rate.physics)
        self._sink = sink
        self._rate = rate
        self.simulated: SimulatedWorld = build_world(scenario, catalog, seed, sink, clock=self._clock)
        self._time = TopicPublisher(transport, "/clock", "rosgraph_msgs/msg/Clock", QoS.COMMAND)
        self.without_tf, tf = "", dict[str, TfPublishers]()  # by namespace
        try:
            for space in set(spaces.values()) if frames.per_namespace else ("",):
                tf[space] = TfPublishers(transport, space)
        except InputError as error:  # rclpy of a ROS 2 installation without tf2_msgs
            self.without_tf = str(error)  # reason why no transforms are published; empty if they are
        self.shared = [self._time, *(each for one in tf.values() for each in one.publishers)]
        self.robots = [
            Ros2Robot(
                self.simulated.devices(name),
                RobotLinks(self.simulated.world, name),
                RobotPublishers(name, space, transport, tf.get(space if frames.per_namespace else ""), frames),
                sink,
                command_type=command_type,
                timeout=timeout,
            )
            for name, space in spaces.items()
        ]
        self._tf = tf
        published = [*self.shared, *(each for robot in self.robots for each in robot.names.publishers)]
        self._watch = NetworkWatch(
            transport,
            [(each.topic, each.type, each.qos) for each in published],
            [(robot.command_topic, command_type, LATEST) for robot in self.robots],
            notice or (lambda text: None),
        )
        control = scenario.rate.control_rate
        self._every = control.every
        divisors = [n for n in range(1, control.every + 1) if control.every % n == 0]
        self._steps = max([n for n in divisors if n * control.step <= _TICK + 1e-9], default=1)

    def run(
        self, duration: float = float("inf"), ended: Callable[[], str] = lambda: "", screen: Screen | None = None
    ) -> SimulationEnd:
        """Simulate until the duration is over, a signal ends it, or the display is closed; then stop all robots.

        Args:
            duration: Maximum simulated duration [s].
            ended: Returns the reason of a signal that ends the simulation, or an empty text.
            screen: Display of the world.
        """
        self._describe()
        pace = Pace(self._rate, ended)
        try:
            while (t := self._clock.now()) < duration - 1e-9 and not ended():
                if self._clock.count % self._every == 0 and not self._period(t, screen):
                    break
                for robot in self.robots:
                    robot.drive(t)
                self.simulated.world.advance(self._steps)
                self._time.send(messages.clock(self._clock.now()))
                pace(self._clock.now())
        finally:
            for robot in self.robots:
                robot.stop()
        return SimulationEnd(self._clock.now(), pace.passed, pace.skipped)

    def _describe(self) -> None:
        """Publish what late nodes need, too: constant transforms and descriptions of the robots."""
        for tf in self._tf.values():
            robots = [robot.names for robot in self.robots if robot.names.tf is tf]
            tf.send_static([each for names in robots for each in names.transforms()])
        for robot in self.robots:
            robot.describe()

    def _period(self, t: float, screen: Screen | None) -> bool:
        """Begin a control period: publish sensors, and move the actors; False if the display was closed."""
        world, count = self.simulated.world, self._clock.count // self._every
        for contact in world.contacts():
            kind = "collision" if contact.driven else "struck"
            self._sink.emit(ContactBegan(t=contact.t, agent=contact.robot, other=contact.other, kind=kind))
        for robot in self.robots:
            robot.publish(count)
        for actor in self.simulated.actors:
            actor.step(t)
        self._watch.look()
        return screen is None or screen.show()


def _namespaces(agents: Sequence[str], namespace: str) -> dict[str, str]:
    """Namespace of each agent's robot, without slashes at the ends; raises InputError."""
    outer = namespace.strip("/")
    if len(agents) == 1:
        return {agents[0]: outer}
    found = {name: "/".join(part for part in (outer, robot_namespace(name)) if part) for name in agents}
    for space in set(found.values()):
        if len(same := [name for name, its in found.items() if its == space]) > 1:
            message = f"the robots {' and '.join(same)} would have the same namespace '{space}'."
            raise InputError(Fault(message, hint="Rename an agent; case and punctuation do not count here."))
    return found


LOOK_AGAIN = 1.0
"""Wall-clock time between two looks at the network [s]."""


class NetworkWatch:
    """Looks for nodes with a type or quality of service that does not match a topic; each is noticed once.

    Args:
        transport: Network.
        published: Topics that the simulation publishes, each with its type and the quality of service offered.
        taken: Topics of commands that the simulation takes, each with its type and the quality of service requested.
        notice: Function that is called with each notice.
        wall: Wall clock [s].
    """

    def __init__(
        self,
        transport: Transport,
        published: Iterable[tuple[str, str, QoS]],
        taken: Iterable[tuple[str, str, QoS]],
        notice: Callable[[str], None],
        wall: Callable[[], float] = time.monotonic,
    ) -> None:
        self._transport = transport
        self._published = {topic: (type, qos) for topic, type, qos in published}
        self._taken = {topic: (type, qos) for topic, type, qos in taken}
        self._notice = notice
        self._wall = wall
        self._next = wall() + LOOK_AGAIN
        self._known: set[str] = set()

    def look(self) -> None:
        """Look at the network if it is time."""
        if self._wall() < self._next:
            return
        for endpoint in self._transport.endpoints():
            for text in self._mismatches(endpoint):
                if text not in self._known:
                    self._known.add(text)
                    self._notice(text)
        self._next = self._wall() + LOOK_AGAIN

    def _mismatches(self, each: Endpoint) -> Iterator[str]:
        node = each.owner
        type, qos = (self._taken if each.publishes else self._published).get(each.topic, (each.type, each.qos))
        verb = "publishes" if each.publishes else "subscribes to"
        if each.type != type:
            yield f"{each.topic}: {node} {verb} {each.type}, and the type here is {type}.{_advice(each)}"
        elif why := mismatch(each.qos, qos) if each.publishes else mismatch(qos, each.qos):
            fix = f"Let it {'offer' if each.publishes else 'request'} {qos.reliability}, {qos.durability}."
            yield f"{each.topic}: the quality of service of {node} does not match in {why}. {fix}"


def _advice(each: Endpoint) -> str:
    """What to do about commands of another type."""
    name = each.type.removeprefix("geometry_msgs/msg/")
    return f" Write --cmd-vel {name}." if each.publishes and name in ("Twist", "TwistStamped") else ""
