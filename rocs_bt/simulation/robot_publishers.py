"""Publishers of a simulated robot on a ROS 2 network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..clock import Rate
from ..drivers.ros2 import messages
from ..drivers.ros2.qos import QoS
from ..drivers.ros2.transport import Transport
from ..geometry import Pose3
from .ros_names import RosNames


class Publisher:
    """Publisher of one topic.

    Args:
        transport: Network.
        topic: Full name of the topic.
        type: Message type.
        qos: Offered quality of service.
        hz: Rate of its messages, for displays [Hz]; 0 if it has no fixed rate.
    """

    def __init__(self, transport: Transport, topic: str, type: str, qos: QoS, hz: float = 0.0) -> None:
        self.topic = topic
        self.hz = hz
        self.type = type
        self.qos = qos
        self._types = transport.types
        self._writer = transport.writer(topic, type, qos)

    def send(self, fields: Mapping[str, Any]) -> None:
        """Publish a message, given by its fields."""
        self._writer.write(self._types.serialize(self._types.make(self.type, **fields)))


class RobotPublishers(RosNames):
    """Names and publishers of a robot on the network.

    Args:
        robot: Name of the robot in the world.
        namespace: Namespace of its topics, and prefix of its frames; empty for none.
        transport: Network.
        tf: Publisher of transforms, which all robots share; None without one.
        map_to_odom: Whether ground-truth odometry has a constant transform from the map; else a localiser publishes it.

    Attributes:
        statics: Constant transforms, which the outputs add.
        publishers: Publishers of the robot.
    """

    def __init__(
        self, robot: str, namespace: str, transport: Transport, tf: Publisher | None, *, map_to_odom: bool = True
    ) -> None:
        super().__init__(namespace)
        self.robot = robot
        self.transport = transport
        self.tf = tf
        self.map_to_odom = map_to_odom
        self.statics: list[messages.Fields] = []
        self.publishers: list[Publisher] = []

    def publisher(self, name: str, type: str, qos: QoS, rate: Rate) -> Publisher:
        """Open a publisher of this robot."""
        made = Publisher(self.transport, self.topic(name), type, qos, rate.hz)
        self.publishers.append(made)
        return made

    def fix(self, frame: str, child: str, pose: Pose3) -> None:
        """Add a constant transform between two full frame names."""
        self.statics.append(messages.transform(0.0, frame, child, pose))
