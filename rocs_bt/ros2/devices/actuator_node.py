"""ActuatorNode: actuator that publishes its commands on a topic of ROS 2 (paper, section 7 and Figure 10)."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...base.errors import DeviceError
from ...control.locomotion import Locomotion
from ...devices.host import Host
from ...devices.last_neutral import repeat_neutral
from ...interfaces.device import Actuator
from ..messages import fields as messages
from ..network.node import RosNode
from ..network.transport import Transport
from ..settings import Ros2Settings
from .parameters import ARRAY, TWIST_STAMPED, Ros2ActuatorParameters

NODE = "rocs_bt"
"""Name of the node of a robot."""


class ActuatorNode(Actuator):
    """Actuator that publishes twists, or the values of its commands.

    The twist is that of the locomotion for the command: the command itself for a body that accepts twists, and the
    forward kinematics for wheels. Neutral is the twist zero.

    Raises:
        DeviceError: The network refuses the publisher.
    """

    def __init__(self, name: str, node: RosNode, parameters: Ros2ActuatorParameters, locomotion: Locomotion) -> None:
        super().__init__(name, len(locomotion.values))
        self._node = node
        self._given = parameters
        self._locomotion = locomotion
        self._writer = node.writer(parameters.topic, parameters.type, parameters.qos)
        self._neutral = list(locomotion.rest)
        node.types.serialize(self._message(self._neutral))  # compiles the type now, and not in the first command
        self.publishers = frozenset({self._writer.gid})

    @property
    def topic(self) -> str:
        """Full name of the topic."""
        return self._writer.topic

    def command(self, values: Sequence[float]) -> None:
        self._writer.write(self._node.types.serialize(self._message(values)))

    def neutral(self) -> None:
        try:
            self.command(self._neutral)
        except DeviceError:  # must not raise; without a network, the base stops by its own time-out
            return

    def close(self) -> None:
        """Publish neutral several times, then close the publisher."""
        repeat_neutral(self.neutral)
        self._writer.close()

    def _message(self, values: Sequence[float]) -> Any:
        given, types = self._given, self._node.types
        if given.type == ARRAY:
            return types.make(ARRAY, data=[given.scale * value for value in values])
        twist = self._locomotion.twist3(values)
        if given.type != TWIST_STAMPED:
            return types.make(given.type, **messages.twist_fields(twist))
        now = self._node.now()  # NaN before the first message of `/clock`
        return types.make(given.type, **messages.twist_stamped(now if math.isfinite(now) else 0.0, given.frame, twist))


@dataclass(frozen=True)
class ActuatorNodeMaker:
    """Constructor call of an ActuatorNode, for the process of an isolated actuator.

    Attributes:
        name: Name of the actuator.
        settings: The `[ros2]` table.
        parameters: Keys of the actuator.
        locomotion: Locomotion of the robot.
        node: Name of the node, if the devices of the host have none yet.
    """

    name: str
    settings: Ros2Settings
    parameters: Ros2ActuatorParameters
    locomotion: Locomotion
    node: str = NODE

    @property
    def two_owners(self) -> bool:
        """True: a topic can have several publishers. The second must exist before it is needed, to be discovered."""
        return True

    def __call__(self, host: Host) -> ActuatorNode:
        """Construct the actuator; its node is shared with the other devices of the host.

        Raises:
            InputError: A package is not installed; the hint says which.
            DeviceError: The network cannot be joined.
        """
        node = shared_node(self.settings, host, name=self.node)
        return ActuatorNode(self.name, node, self.parameters, self.locomotion)


def isolated_node(actuator: str) -> str:
    """Name of the node in the process of an isolated actuator; two nodes of one name would disturb tools."""
    return re.sub(r"\W|_+", "_", f"{NODE}_{actuator}", flags=re.ASCII)


def shared_node(settings: Ros2Settings, host: Host, transport: Transport | None = None, name: str = NODE) -> RosNode:
    """Connection of a robot, which all its devices in one process share.

    Args:
        settings: The `[ros2]` table.
        host: Host of the devices.
        transport: Opened transport, in the first call; None to open one by the settings.
        name: Name of the node, in the first call.
    """
    return host.share(("ros2", settings), lambda: RosNode(settings, host.clock, transport, name))
