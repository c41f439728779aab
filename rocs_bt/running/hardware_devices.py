"""Devices of all robots of a run on hardware, behind their safety gates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing

from ..agent import RobotDevices
from ..base.clock import Rate, WallClock
from ..base.errors import Fault, InputError
from ..catalog import ActuatorSpec, Catalog, RobotSpec, command_size
from ..drivers import ROS2, read_parameters
from ..drivers.emergency_stop import EmergencyStop
from ..drivers.host import Host
from ..drivers.isolated import IsolatedActuator
from ..event import EventSink, OtherPublisherFound
from ..interfaces.device import Actuator
from ..interfaces.safety import SafetyGate
from ..ros2.devices.actuator_node import shared_node
from ..ros2.devices.command_watch import CommandWatch
from ..ros2.devices.parameters import Ros2ActuatorParameters
from ..ros2.devices.stop_topics import StopTopics
from ..ros2.network.connect import open_transport
from ..ros2.network.node import RosNode
from ..ros2.network.sim_clock import SimTimeClock
from ..ros2.nodes.dry_link import DryLink
from ..ros2.nodes.link import NodeLink
from ..ros2.ros_link import RosLink
from ..ros2.settings import Ros2Settings
from ..simulation.devices import hardware_driver, make_hardware, make_isolated, make_sensor
from .options import RunOptions
from .preflight import PreflightTopic, preflight_topics


def hardware_clock(robots: Sequence[RobotSpec], stack: ExitStack, wait: float, ended: Callable[[], str]) -> WallClock:
    """Clock of a run: the wall clock, or that of a simulator if the robots' `[ros2]` tables have `use_sim_time`.

    Args:
        robots: All robots of the run.
        stack: Exit stack that leaves the simulator's network.
        wait: Maximum time to wait for the simulator [s].
        ended: Returns the reason of a signal that ends the run, or an empty text.

    Raises:
        InputError: Only some robots follow a simulator, or they follow simulators on different networks.
        DeviceError: The simulator publishes no time.
    """
    settings = [robot.ros2 or Ros2Settings() for robot in robots]
    if not any(each.use_sim_time for each in settings):
        return WallClock(running=False)
    if not all(each.use_sim_time for each in settings) or len({each.domain_id for each in settings}) > 1:
        message = "use_sim_time must be the same for all robots of a run, in one ROS domain."
        raise InputError(Fault(message, robots[0].file, hint="All agents of a run have one clock."))
    clock = SimTimeClock(stack.enter_context(closing(open_transport(settings[0], "rocs_bt_clock"))))
    clock.wait_for_message(wait, ended)
    return clock


class HardwareDevices:
    """Devices of all robots.

    Args:
        clock: Clock of the run.
        period: Control period [s].
        sink: Sink for events of the safety gates.
        options: Options of the run, for which no actuator is opened in a dry run, each robot may wait for a go from the
            beginning, and notices are given, such as that a goal may go on after the run.
    """

    def __init__(self, clock: WallClock, period: float, sink: EventSink, options: RunOptions) -> None:
        self.clock = clock
        self.sink = sink
        self._period = period
        self._dry_run = options.dry_run
        self._confirm = options.confirm
        self._notice = options.notice or (lambda text: None)
        self.robots: dict[str, RobotDevices] = {}
        self.motion: dict[str, SafetyGate] = {}  # of the locomotion, by agent
        self.links: dict[str, list[IsolatedActuator]] = {}
        self.stops: dict[str, EmergencyStop] = {}
        self.topics: list[PreflightTopic] = []  # topics of ROS 2 that need a node at the other side
        self.watches: list[StopTopics | CommandWatch] = []  # topics of ROS 2 that are watched during the run

    @property
    def gates(self) -> list[SafetyGate]:
        """Safety gates of all actuators of all robots."""
        return [gate for each in self.robots.values() for gate in each.actuators.values()]

    def open(
        self,
        name: str,
        robot: RobotSpec,
        rates: Mapping[str, Rate],
        catalog: Catalog,
        shared: ExitStack,
        opened: ExitStack,
    ) -> None:
        """Open the devices of an agent's robot.

        `shared` closes the host, which the devices share, and `opened` closes the devices.
        """
        stop = self.stops[name] = EmergencyStop(confirm=self._confirm)
        host = Host(self.clock, stop)
        shared.callback(host.close)
        sensors = {
            s.name: opened.enter_context(closing(make_sensor(catalog, robot, s, host, rates[s.name])))
            for s in robot.sensors
        }
        made = {a.name: opened.enter_context(closing(self._actuator(catalog, robot, a, host))) for a in robot.actuators}
        gates = {a.name: a.guard(made[a.name], self.clock, self._period, self.sink, name) for a in robot.actuators}
        stop.attach(list(gates.values()))
        link = self._ros_link(robot, host, shared)
        services = {} if link is None else {"ros2": link}
        self.robots[name] = RobotDevices(robot, sensors, gates, rates, services)
        self.motion[name] = gates[robot.locomotion.actuator]
        if robot.ros2 is not None:
            node = shared_node(robot.ros2, host)
            self.topics += preflight_topics(name, robot, node, dry_run=self._dry_run)
            if robot.ros2.emergency_stop or robot.ros2.go:
                self.watches.append(StopTopics(node, host))
            ours = [each for each in robot.actuators if each.driver == ROS2]
            self.watches += [self._watch(name, robot.ros2, each, made[each.name], node) for each in ours]
        self.links[name] = [device for device in made.values() if isinstance(device, IsolatedActuator)]

    def _watch(
        self, agent: str, settings: Ros2Settings, spec: ActuatorSpec, device: Actuator, node: RosNode
    ) -> CommandWatch:
        """Watch of the topic of an actuator for publishers that are not part of the run."""
        given = read_parameters(Ros2ActuatorParameters, spec.parameters, f"actuator '{spec.name}'")
        topic = settings.topic(given.topic)

        def report(other: str) -> None:
            found = OtherPublisherFound(t=self.clock.now(), agent=agent, actuator=spec.name, topic=topic, node=other)
            self.sink.emit(found)
            self._notice(f"{agent}: {found.sentence}.")

        return CommandWatch(node, topic, given.type, device.publishers, report)

    def _ros_link(self, robot: RobotSpec, host: Host, shared: ExitStack) -> RosLink | None:
        """ROS connection for the robot's mission; None for a robot without a `[ros2]` table."""
        settings = robot.ros2
        if settings is None:
            return None
        link = NodeLink(lambda: shared_node(settings, host), self._notice)
        shared.callback(link.close)
        return DryLink(link) if self._dry_run else link

    def _actuator(self, catalog: Catalog, robot: RobotSpec, spec: ActuatorSpec, host: Host) -> Actuator:
        """Device of an actuator; for an isolated actuator, the link to its process; in a dry run, none."""
        if self._dry_run:
            hardware_driver(catalog, robot, spec)  # refuses what a real run refuses
            return NoActuator(spec.name, command_size(robot, spec))
        if spec.isolated and not isinstance(self.clock, SimTimeClock):  # a process of its own has the wall clock
            return make_isolated(catalog, robot, spec, host)
        device: Actuator = make_hardware(catalog, robot, spec, host)
        return device


class NoActuator(Actuator):
    """Actuator of a dry run, without a device."""

    def command(self, values: Sequence[float]) -> None:
        """Ignore the command; the agent records it."""

    def neutral(self) -> None:
        """Do nothing."""
