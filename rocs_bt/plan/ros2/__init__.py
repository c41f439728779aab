"""Behaviour-tree nodes for ROS 2: topics, services and actions, through the robot's ROS connection."""

from __future__ import annotations

from typing import Final

from .action import RosAction
from .action_server import RosActionServer
from .assignments import FieldInput, FieldInputs, FieldOutput, FieldOutputs
from .nav2_servers import NAV2_SERVERS
from .service import RosService
from .topics import RosPublish, RosSubscribe
from .uses_ros import UsesRos

ROS_NODES: Final = (RosAction, RosActionServer, RosPublish, RosService, RosSubscribe)
"""Nodes for any topic, service or action; available in every mission."""

__all__ = [
    "NAV2_SERVERS",
    "ROS_NODES",
    "FieldInput",
    "FieldInputs",
    "FieldOutput",
    "FieldOutputs",
    "RosAction",
    "RosActionServer",
    "RosPublish",
    "RosService",
    "RosSubscribe",
    "UsesRos",
]
