"""ROS 2 beside the blocks of a robot on hardware: its connection, the topics that it watches, a simulator's clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from functools import partial

from ..base.clock import WallClock
from ..base.errors import Fault, InputError
from ..catalog import RobotSpec
from ..event import OtherPublisherFound
from ..running.hardware_services import ServicePlace
from ..running.preflight import PreflightTopic, SensorState
from .devices.actuator_node import shared_node
from .devices.command_watch import CommandWatch
from .devices.parameters import Ros2ActuatorParameters
from .devices.stop_topics import STOP_QOS, STOP_TYPE, StopTopics
from .network.clock_watch import RunClock
from .network.connect import open_transport
from .network.matching import FIXED, OwnEndpoint
from .nodes.dry_link import DryLink
from .nodes.link import NodeLink
from .ros_link import RosLink
from .settings import Ros2Settings


class RosBesideRobot:
    """Service of a robot with a `[ros2]` table; see `running.hardware_services.RobotService`.

    Raises:
        InputError: A package is not installed.
        DeviceError: The network cannot be joined.
    """

    def __init__(self, place: ServicePlace) -> None:
        settings = place.robot.tables.get("ros2", Ros2Settings())
        self._place = place
        self._node = shared_node(settings, place.host)
        self._nodes = NodeLink(lambda: self._node, place.notice)
        self.link: RosLink = DryLink(self._nodes) if place.dry_run else self._nodes
        keys = {spec.name: spec.parameters for spec in place.robot.actuators}
        ours = {name: given for name, given in keys.items() if isinstance(given, Ros2ActuatorParameters)}
        self.topics: Sequence[PreflightTopic] = [
            PreflightTopic(
                SensorState(
                    agent=place.agent,
                    sensor=name,
                    driver="ros2",
                    source=endpoint.topic,
                    needed_for=(use,),
                    optional=place.dry_run,
                    matched=True,
                ),
                partial(self._node.counterparts, endpoint),
            )
            for name, endpoint, use in _needs(settings, ours)
        ]
        self._watches: list[StopTopics | CommandWatch] = []
        if settings.emergency_stop or settings.go:
            self._watches.append(StopTopics(self._node, place.host))
        self._watches += [self._watch(name, settings.topic(given.topic), given.type) for name, given in ours.items()]

    def poll(self) -> None:
        """Read the topics of the emergency stop, and look for other publishers of commands."""
        for each in self._watches:
            each.poll()

    def close(self) -> None:
        """Close the connection of the mission's nodes."""
        self._nodes.close()

    def _watch(self, actuator: str, topic: str, type: str) -> CommandWatch:
        """Watch of the topic of an actuator for publishers that are not part of the run."""
        place = self._place

        def report(other: str) -> None:
            found = OtherPublisherFound(
                t=place.host.clock.now(), agent=place.agent, actuator=actuator, topic=topic, node=other
            )
            place.sink.emit(found)
            place.notice(f"{place.agent}: {found.sentence}.")

        return CommandWatch(self._node, topic, type, place.actuators[actuator].publishers, report)

    @staticmethod
    def clock(robots: Sequence[RobotSpec], stack: ExitStack, wait: float, ended: Callable[[], str]) -> WallClock | None:
        """Clock of a simulator, if the `[ros2]` tables have `use_sim_time`; see `HardwareService`."""
        settings = [robot.tables.get("ros2", Ros2Settings()) for robot in robots]
        if not any(each.use_sim_time for each in settings):
            return None
        if not all(each.use_sim_time for each in settings) or len({each.domain_id for each in settings}) > 1:
            message = "use_sim_time must be the same for all robots of a run, in one ROS domain."
            raise InputError(Fault(message, robots[0].file, hint="All agents of a run have one clock."))
        clock = RunClock(stack.enter_context(closing(open_transport(settings[0], "rocs_bt_clock"))))
        clock.wait_for_message(wait, ended)
        return clock


def _needs(settings: Ros2Settings, ours: dict[str, Ros2ActuatorParameters]) -> Iterator[tuple[str, OwnEndpoint, str]]:
    """Topics that need a node at the other side: those of commands and of the emergency stop, with their uses."""
    for name, given in ours.items():
        yield name, OwnEndpoint(settings.topic(given.topic), given.type, given.qos, publishes=True), "commands"
    if stop := settings.emergency_stop:
        yield "emergency_stop", OwnEndpoint(settings.topic(stop), STOP_TYPE, STOP_QOS, side=FIXED), "emergency stop"
