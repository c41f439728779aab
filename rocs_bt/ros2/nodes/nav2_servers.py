"""Nodes that call the servers of a running Nav2, with the names and ports of Nav2's own nodes.

They are available with `nodes = "nav2_servers"`. The nodes of `rocs_bt.nav2` (`nodes = "nav2"`) have the same
names and ports but need no ROS: they use the planners and actions of rocs_bt.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from ...nav2.nodes import NAV2
from ...nav2.servers import CANCELLED
from ...nav2.tables import made_node
from ...plan.action_node import ActionNode
from ...trees.nodes import Direction, Node, port_of
from .nav2_actions import Nav2Action, Nav2Motion, Planning, Routing, Teleop
from .nav2_messages import Nav2Caller
from .nav2_services import Cancel, CheckPose, Nav2Service, RemoveGoals, Validate


def server_of(tag: str) -> str:
    """Name of the action server that a node of Nav2 calls by default."""
    return "backup" if tag == "BackUp" else re.sub(r"(?<=.)([A-Z])", r"_\1", tag).lower()


_PLANNER: Final = {
    "planner_id": port_of(str, "name of a planner of Nav2; its default if empty", default=""),
    "path": port_of(Any, "path, as nav_msgs/Path; empty after a failure", Direction.OUTPUT),
}
_CORNERS: Final = {
    "corners": port_of(list, "path as corners, (x, y) in `frame` [m], as FollowRoute takes it", Direction.OUTPUT)
}
_ROUTE: Final = {
    "planner_id": None,
    "start": NAV2["ComputePathToPose"].ports["start"],
    "start_id": port_of(int, "number of the start node", default=0),
    "goal_id": port_of(int, "number of the goal node", default=0),
    "route": port_of(Any, "route, as nav2_msgs/Route; empty after a failure", Direction.OUTPUT),
    "path": port_of(Any, "path, as nav_msgs/Path; empty after a failure", Direction.OUTPUT),
}
_SMOOTH: Final = {"inputs": {"path": "unsmoothed_path"}, "outputs": {"smoothed_path": "path"}}
_CLEAR: Final = "Clears one of Nav2's costmaps, or a part of it."
_VALID: Final = "Asks Nav2's planner server whether a path is free; RUNNING until it has responded."
_IS_VALID: Final = {"type": "nav2_msgs/srv/IsPathValid", "service_name": "is_path_valid"}
_COSTS: Final = {"type": "nav2_msgs/srv/GetCosts", "service_name": "/global_costmap/get_cost_global_costmap"}
_RESTART: Final = {"type": "std_srvs/srv/Empty", "service_name": "reinitialize_global_localization"}
_TOGGLE: Final = {"type": "nav2_msgs/srv/Toggle", "service_name": "collision_monitor/toggle"}
_CANCEL: Final = {"type": "action_msgs/srv/CancelGoal"}

_ROWS: Final[Mapping[str, tuple[type[Nav2Caller], str, Mapping[str, Any]]]] = {
    "NavigateToPose": (Nav2Motion, "Drives to a goal with Nav2's navigator.", {"inputs": {"pose": "goal"}}),
    "NavigateThroughPoses": (
        Nav2Motion,
        "Drives to several goals in order with Nav2's navigator.",
        {"inputs": {"poses": "goals"}},
    ),
    "ComputePathToPose": (Planning, "Computes a path with Nav2's planner server.", _PLANNER | _CORNERS),
    "ComputePathThroughPoses": (Planning, "Computes a path through goals with Nav2's planner server.", _PLANNER),
    "SmoothPath": (Nav2Action, "Smooths a path with Nav2's smoother server.", _SMOOTH),
    "FollowPath": (Nav2Motion, "Follows a path with Nav2's controller server.", {}),
    "Spin": (Nav2Motion, "Turns on the spot with Nav2's behavior server.", {"inputs": {"target_yaw": "spin_dist"}}),
    "BackUp": (
        Nav2Motion,
        "Drives backward with Nav2's behavior server.",
        {"inputs": {"target": "backup_dist", "speed": "backup_speed"}},
    ),
    "DriveOnHeading": (
        Nav2Motion,
        "Drives straight with Nav2's behavior server.",
        {"inputs": {"target": "dist_to_travel"}},
    ),
    "Wait": (Nav2Action, "Waits with Nav2's behavior server.", {"inputs": {"time": "wait_duration"}}),
    "AssistedTeleop": (Teleop, "Lets a person drive with Nav2's checks; SUCCESS at the end unless `is_recovery`.", {}),
    "ComputeRoute": (Routing, "Computes a route with Nav2's route server.", _ROUTE),
    "ComputeAndTrackRoute": (
        Routing,
        "Computes a route with Nav2's route server; RUNNING until the robot has reached its end.",
        _ROUTE,
    ),
    "DockRobot": (Nav2Motion, "Docks with Nav2's docking server.", {}),
    "UndockRobot": (Nav2Motion, "Undocks with Nav2's docking server.", {}),
    "FollowObject": (Nav2Motion, "Follows a moving object with Nav2's following server.", {}),
    "ClearEntireCostmap": (Nav2Service, _CLEAR, {}),
    "ClearCostmapExceptRegion": (Nav2Service, _CLEAR, {}),
    "ClearCostmapAroundRobot": (Nav2Service, _CLEAR, {}),
    "ClearCostmapAroundPose": (Nav2Service, _CLEAR, {}),
    "ReinitializeGlobalLocalization": (
        Nav2Service,
        "Makes the localisation start again: the robot may be anywhere.",
        _RESTART,
    ),
    "ToggleCollisionMonitor": (Nav2Service, "Switches Nav2's collision monitor on or off.", _TOGGLE),
    "ValidatePath": (Validate, _VALID, _IS_VALID),
    "IsPathValid": (Validate, _VALID, _IS_VALID),
    "CheckPoseOccupancy": (CheckPose, "SUCCESS if a pose is occupied in Nav2's global costmap.", _COSTS),
    "RemoveInCollisionGoals": (RemoveGoals, "Removes goals that are occupied in Nav2's global costmap.", _COSTS),
    **{
        tag: (Cancel, f"Cancels the goals of Nav2's server of {server}.", _CANCEL | {"server_name": server_of(server)})
        for tag, server in CANCELLED.items()
    },
}
"""Base, docstring and own members of each node; other ports are those of Nav2's node."""


def _node(tag: str, base: type[Nav2Caller], doc: str, members: Mapping[str, Any]) -> type[Node]:
    own = base.ports.keys() | ActionNode.ports.keys()
    ports: dict[str, Any] = {name: port for name, port in NAV2[tag].ports.items() if name not in own}
    if issubclass(base, Nav2Action):
        ports = {"server_name": server_of(tag), **ports, "type": f"nav2_msgs/action/{tag}"}
    given = {"type": f"nav2_msgs/srv/{tag}", "kind": NAV2[tag].kind, **ports, **members}
    return made_node(tag, base, doc, {name: value for name, value in given.items() if value is not None}, __name__)


NODES: Final = {tag: _node(tag, *row) for tag, row in _ROWS.items()}
"""Nodes that call servers of Nav2, by name; they are attributes of this module too."""


def __getattr__(name: str) -> type[Node]:
    if name not in NODES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return NODES[name]
