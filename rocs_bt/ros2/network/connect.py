"""Choice of the transport: rclpy where it can be imported, otherwise DDS without ROS."""

from __future__ import annotations

import os

from ..messages.type_store import DISTROS, TypeStore
from ..settings import Ros2Settings
from .dds import DdsTransport
from .rclpy_transport import RclpyTransport, definition, has_rclpy
from .transport import Transport


def open_transport(settings: Ros2Settings, node: str = "rocs_bt") -> Transport:
    """Join a ROS 2 network.

    Raises:
        InputError: A package is not installed; the hint says which.
        DeviceError: The network cannot be joined.
    """
    if settings.transport == "dds" or (settings.transport == "auto" and not has_rclpy()):
        return DdsTransport(settings, TypeStore(settings.distro, settings.definition), node)
    distro = os.environ.get("ROS_DISTRO", settings.distro)
    types = TypeStore(
        distro if distro in DISTROS else settings.distro, lambda name: settings.definition(name) or definition(name)
    )
    return RclpyTransport(settings, types, node)
