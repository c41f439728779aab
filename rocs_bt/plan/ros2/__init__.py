"""Behaviour-tree nodes for ROS 2: topics, services and actions, through the robot's ROS connection."""

from __future__ import annotations

from typing import Final

from ...trees.nodes import nodes_of
from . import nav2_planners, nav2_servers
from .action import RosAction
from .action_server import RosActionServer
from .assignments import FieldInput, FieldInputs, FieldOutput, FieldOutputs
from .nav2_services import service_nodes
from .service import RosService
from .topics import RosPublish, RosSubscribe
from .uses_ros import UsesRos

ROS_NODES: Final = (RosAction, RosActionServer, RosPublish, RosService, RosSubscribe)
"""Nodes for any topic, service or action; available in every mission."""

NAV2_SERVERS: Final = (*nodes_of(nav2_servers), *nodes_of(nav2_planners), *service_nodes())
"""Nodes that call the action servers and services of a running Nav2; see also `rocs_bt.plan.nav2`."""

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
