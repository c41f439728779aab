"""Publishers of a simulated robot on a ROS 2 network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...base.clock import Rate
from ...base.geometry import Pose3
from ..messages import fields as messages
from ..messages.message_types import MESSAGES, TRANSFORMS, Channel, Values
from ..messages.names import RosNames
from ..network.qos import QoS
from ..network.transport import Transport

MOVING = QoS("reliable", "volatile", 100)
"""Quality of service of `/tf`, as tf2 offers it."""


class TopicPublisher:
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

    def measure(self, stamp: float, values: Values, channel: Channel) -> None:
        """Publish values of a short form with a stamp [s]."""
        self.send(MESSAGES[self.type].make(stamp, values, channel))

    def send(self, fields: Mapping[str, Any]) -> None:
        """Publish a message, given by its fields."""
        self._writer.write(self._types.serialize(self._types.make(self.type, **fields)))


class TfPublishers:
    """Publishers of the transforms of one robot or several: `tf` and `tf_static`.

    Raises:
        InputError: The ROS 2 installation has no tf2_msgs.
    """

    def __init__(self, transport: Transport, namespace: str = "") -> None:
        names = RosNames(namespace)
        self._moving = TopicPublisher(transport, names.topic("tf"), TRANSFORMS, MOVING)
        self._static = TopicPublisher(transport, names.topic("tf_static"), TRANSFORMS, QoS.LATCHED)
        self.publishers = (self._moving, self._static)

    def send(self, transforms: Sequence[messages.Fields]) -> None:
        """Publish moving transforms."""
        self._moving.send(messages.transforms(transforms))

    def send_static(self, transforms: Sequence[messages.Fields]) -> None:
        """Publish all constant transforms of the robots."""
        self._static.send(messages.transforms(transforms))


@dataclass(frozen=True)
class FrameOptions:
    """Transforms that a simulation publishes.

    Attributes:
        map_to_odom: Whether ground-truth odometry has a constant transform from the map; else a localiser publishes it.
        odom_to_base: Whether odometry has a transform; else a filter such as robot_localization publishes it.
        per_namespace: Whether each robot has `tf` and `tf_static` in its namespace, and frames without a prefix.
    """

    map_to_odom: bool = True
    odom_to_base: bool = True
    per_namespace: bool = False


ALL_FRAMES = FrameOptions()
"""All transforms, on one `/tf`."""


class RobotPublishers(RosNames):
    """Names and publishers of a robot on the network.

    Args:
        robot: Name of the robot in the world.
        namespace: Namespace of its topics, and prefix of its frames; empty for none.
        transport: Network.
        tf: Publishers of transforms; None without them.
        options: Transforms that are published.
    """

    def __init__(
        self,
        robot: str,
        namespace: str,
        transport: Transport,
        tf: TfPublishers | None,
        options: FrameOptions = ALL_FRAMES,
    ) -> None:
        super().__init__(namespace, "" if options.per_namespace else None)
        self.robot = robot
        self.transport = transport
        self.tf = tf
        self.options = options
        # Constant transforms, which the outputs add: parent, frame, pose in the parent.
        self.statics: list[tuple[str, str, Pose3]] = []
        self.publishers: list[TopicPublisher] = []

    def publisher(self, name: str, type: str, qos: QoS, rate: Rate | None = None) -> TopicPublisher:
        """Open a publisher of this robot; without a rate for a latched topic."""
        made = TopicPublisher(self.transport, self.topic(name), type, qos, 0.0 if rate is None else rate.hz)
        self.publishers.append(made)
        return made

    def fix(self, parent: str, frame: str, pose: Pose3) -> None:
        """Add a constant transform between two full frame names."""
        self.statics.append((parent, frame, pose))

    def transforms(self) -> list[messages.Fields]:
        """Messages of the constant transforms."""
        return [messages.transform(0.0, *each) for each in self.statics]
