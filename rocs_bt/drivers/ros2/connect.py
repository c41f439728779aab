"""Choice of the transport: rclpy where it can be imported, otherwise DDS without ROS."""

from __future__ import annotations

import os

from .dds import DdsTransport
from .message_types import DISTROS, FindDefinition, MessageTypes
from .rclpy_transport import RclpyTransport, definition, has_rclpy
from .settings import Ros2Settings
from .transport import Transport


def open_transport(
    settings: Ros2Settings, node: str = "rocs_bt", find: FindDefinition = lambda name: None
) -> Transport:
    """Join a ROS 2 network.

    Args:
        settings: Settings of the connection.
        node: Name of the node.
        find: Finds definitions of message types that the distribution does not have.

    Raises:
        InputError: A package is not installed; the hint says which.
        DeviceError: The network cannot be joined.
    """
    if settings.transport == "dds" or (settings.transport == "auto" and not has_rclpy()):
        return DdsTransport(settings, MessageTypes(settings.distro, find), node)
    distro = os.environ.get("ROS_DISTRO", settings.distro)
    types = MessageTypes(distro if distro in DISTROS else settings.distro, lambda name: find(name) or definition(name))
    return RclpyTransport(settings, types, node)
