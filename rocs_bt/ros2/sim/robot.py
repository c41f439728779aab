"""Simulated robot as a ROS 2 robot: publishes its sensors' readings, and obeys velocity commands."""

from __future__ import annotations

import math

from ...agent import RobotDevices
from ...base.errors import DeviceError, interrupts
from ...base.raised import describe
from ...event import CommandExpired, EventSink
from ...simulation.robot_links import RobotLinks
from ..messages.fields import twist_of
from ..messages.names import MAP
from ..network.qos import QoS
from .outputs import robot_outputs
from .publishers import RobotPublishers
from .urdf import urdf

COMMAND_TYPES = {"TwistStamped": "geometry_msgs/msg/TwistStamped", "Twist": "geometry_msgs/msg/Twist"}
"""Message types of velocity commands, by short name."""

COMMAND_TIMEOUT = 0.5
"""Time without a command after which a robot stops [s], as by default in ros2_control."""

LATEST = QoS("best_effort", "volatile", 1)
"""Quality of service of velocity commands, which matches every publisher."""


class Ros2Robot:
    """Simulated robot on a ROS 2 network.

    The last velocity command holds until the next one, through the robot's safety gate; without a new one for the
    time-out, the robot goes to neutral. The age of a command counts from its arrival, in simulated time, so that the
    stamps of senders with another clock do not matter.

    Args:
        devices: Devices of the robot, in MuJoCo.
        links: Links of the robot.
        names: Names and publishers of the robot.
        sink: Sink for CommandExpired events.
        command_type: Message type of the commands.
        timeout: Time without a command after which the robot stops [s].
    """

    def __init__(
        self,
        devices: RobotDevices,
        links: RobotLinks,
        names: RobotPublishers,
        sink: EventSink,
        *,
        command_type: str = COMMAND_TYPES["TwistStamped"],
        timeout: float = COMMAND_TIMEOUT,
    ) -> None:
        self.names = names
        self._locomotion = devices.robot.locomotion
        self.outputs = robot_outputs(devices, self._locomotion, names, links)
        self._description = names.publisher("robot_description", "std_msgs/msg/String", QoS.LATCHED)
        self._links = links
        self.command_topic = names.topic("cmd_vel")
        self.commands = self.expired = 0
        self.faults: dict[str, str] = {}
        self._gate = devices.actuators[devices.robot.motion.actuator]
        self._types = names.transport.types
        self._reader = names.transport.reader(self.command_topic, command_type, LATEST)
        self._sink = sink
        self._timeout = timeout
        self._values: list[float] | None = None  # None while there is no valid command
        self._commanded_at = -math.inf

    def describe(self) -> None:
        """Publish the description of the robot, for displays and planners that start at any time."""
        frames = [each for each in self.names.statics if each[0] != MAP]
        self._description.send({"data": urdf(self.names.robot, self._links.links, self.names.frame, frames)})

    def publish(self, count: int) -> None:
        """Publish the readings of the sensors that are due in the control period with this number."""
        for output in self.outputs:
            if not output.rate.due(count):
                continue
            try:
                output.publish()
            except Exception as error:  # a user's sensor may raise anything; its topic then falls silent
                if interrupts(error):
                    raise
                self.faults[output.name] = describe(error)

    def drive(self, t: float) -> None:
        """Take a new command, if there is one, and command the robot at time t [s]."""
        if (sample := self._reader.take()) is not None:
            self._receive(sample.data, t)
        if self._values is None:
            return
        if t - self._commanded_at > self._timeout + 5e-7:
            self._values = None
            self.expired += 1
            self._gate.neutral()
            self._sink.emit(CommandExpired(t=t, agent=self.names.robot, actuator=self._gate.name))
        else:
            self._gate.give(self._values)

    def stop(self) -> None:
        """Send the robot to neutral."""
        self._values = None
        self._gate.neutral()

    def _receive(self, data: bytes, t: float) -> None:
        try:
            twist = twist_of(self._types.deserialize(data, self._reader.type))
        except DeviceError as error:
            self.faults[self.command_topic] = str(error)
            return
        if not all(map(math.isfinite, twist)):
            self.faults[self.command_topic] = f"a command is not finite: {twist}"
            return
        self._values, self._commanded_at = self._locomotion.command(twist).tolist(), t
        self.commands += 1
