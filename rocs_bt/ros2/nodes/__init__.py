"""Behaviour-tree nodes for ROS 2: topics, services and actions, through the robot's ROS connection."""

from __future__ import annotations

from typing import Final

from ...trees.nodes import Node
from .action import RosAction
from .action_server import RosActionServer
from .assignments import FieldInput, FieldInputs, FieldOutput, FieldOutputs
from .nav2_servers import NODES
from .nav2_services import RosService
from .nav2_topics import TOPIC_NODES
from .topics import RosPublish, RosSubscribe
from .uses_ros import UsesRos

ROS_NODES: Final = (RosAction, RosActionServer, RosPublish, RosService, RosSubscribe)
"""Nodes for any topic, service or action; available in every mission."""

NAV2_SERVERS: Final[tuple[type[Node], ...]] = (*NODES.values(), *TOPIC_NODES)
"""Nodes that use the servers, services and topics of a running Nav2; see also `rocs_bt.nav2`."""

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
