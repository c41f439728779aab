"""Nodes that call the services of a running Nav2, with the names and ports of Nav2's own nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Final

from ...nav2.costs import NO_INFORMATION
from ...nav2.goals import SKIPPED, Statuses
from ...nav2.lenient import Served, Serviced
from ...nav2.nodes import NAV2
from ...nav2.path import poses_in
from ...nav2.poses import list_of
from ...nav2.servers import CANCELLED
from ...nav2.tables import made_node
from ...trees.nodes import FAILURE, SUCCESS, Input, Node, Outcome
from ..ros_link import RosField, RosMessage, RosTypes
from .nav2_messages import Nav2Caller, field_of
from .nav2_servers import server_of
from .service import ServiceLeaf
from .uses_ros import parse_name

PATIENCE = 5.0
"""Maximum time to wait for a service, and for its response [s]."""


class Nav2Service(Nav2Caller, ServiceLeaf):
    """Base of nodes that call a service of Nav2: RUNNING until its response is there; FAILURE after 5 s without it."""

    named = "service_name"
    parts = {"request": "_Request", "response": "_Response"}  # noqa: RUF012 - a table of the class

    service_name = Input(str, doc="name of the service", parse=parse_name)
    server_timeout = Input(float, 0.0, "timeout in Nav2 [ms]; not used")

    wait = timeout = PATIENCE

    def message(self) -> dict[str, Any]:
        return self.filled("Request")

    def responded(self, response: RosMessage) -> Outcome:
        return SUCCESS if field_of(response, "success", True) else FAILURE


class _Validate(Nav2Service):
    def responded(self, response: RosMessage) -> Outcome:
        path = poses_in(self.read("path"))
        if "collision_poses" in self.ports:
            found = field_of(response, "invalid_pose_indices", ())
            self.write("collision_poses", [path[i] for i in found if 0 <= i < len(path)])
        valid = super().responded(response) is SUCCESS and field_of(response, "is_valid", False)
        return SUCCESS if valid else FAILURE


class _Costs(Nav2Service):
    """Base of nodes that ask for the costs of poses in Nav2's global costmap."""

    def occupied(self, response: RosMessage, count: int) -> list[bool] | None:
        """Whether each pose is occupied; None if the service did not succeed."""
        costs = field_of(response, "costs", ())
        if Nav2Service.responded(self, response) is FAILURE or len(costs) != count:
            return None
        least, unknown = self.read("cost_threshold"), self.read("consider_unknown_as_obstacle")
        return [unknown if cost == NO_INFORMATION else cost >= least for cost in costs]


class _CheckPose(_Costs):
    def fields(self, known: Mapping[str, RosField], types: RosTypes) -> dict[str, Any]:
        return {"use_footprint": self.read("use_footprint"), "poses": [self.stamped(self.read("pose"))]}

    def responded(self, response: RosMessage) -> Outcome:
        return SUCCESS if self.occupied(response, 1) == [True] else FAILURE


class _RemoveGoals(Statuses, _Costs):
    inputs: ClassVar[Mapping[str, str]] = {"poses": "input_goals"}

    def update(self) -> Outcome:
        outcome = super().update() if list_of(self.read("input_goals")) else FAILURE
        if outcome is FAILURE:
            self.write("output_goals", list_of(self.read("input_goals")))
        return outcome

    def responded(self, response: RosMessage) -> Outcome:
        goals = list_of(self.read("input_goals"))
        occupied = self.occupied(response, len(goals))
        if occupied is None or not self.mark([g for g, o in zip(goals, occupied, strict=True) if o], SKIPPED):
            return FAILURE
        self.write("output_goals", [goal for goal, o in zip(goals, occupied, strict=True) if not o])
        return SUCCESS


class _Cancel(Nav2Service):
    """Base of nodes that cancel all goals of an action server."""

    named = "server_name"

    service_name = Serviced.service_name
    error_code_id, error_msg = Served.error_code_id, Served.error_msg

    def names(self) -> tuple[str, str]:
        return f"{self._name('server_name')}/_action/cancel_goal", self.type


_CLEAR: Final = "Clears one of Nav2's costmaps, or a part of it."
_VALID: Final = "Asks Nav2's planner server whether a path is free; RUNNING until it has responded."
_COSTS: Final = ("nav2_msgs/srv/GetCosts", "/global_costmap/get_cost_global_costmap")
_SERVICES: Final[Mapping[str, tuple[type[Nav2Service], str, str, str]]] = {
    **{
        tag: (Nav2Service, f"nav2_msgs/srv/{tag}", "", _CLEAR)
        for tag in (
            "ClearEntireCostmap",
            "ClearCostmapExceptRegion",
            "ClearCostmapAroundRobot",
            "ClearCostmapAroundPose",
        )
    },
    "ReinitializeGlobalLocalization": (
        Nav2Service,
        "std_srvs/srv/Empty",
        "reinitialize_global_localization",
        "Makes the localisation start again: the robot may be anywhere.",
    ),
    "ToggleCollisionMonitor": (
        Nav2Service,
        "nav2_msgs/srv/Toggle",
        "collision_monitor/toggle",
        "Switches Nav2's collision monitor on or off.",
    ),
    "ValidatePath": (_Validate, "nav2_msgs/srv/IsPathValid", "is_path_valid", _VALID),
    "IsPathValid": (_Validate, "nav2_msgs/srv/IsPathValid", "is_path_valid", _VALID),
    "CheckPoseOccupancy": (_CheckPose, *_COSTS, "SUCCESS if a pose is occupied in Nav2's global costmap."),
    "RemoveInCollisionGoals": (_RemoveGoals, *_COSTS, "Removes goals that are occupied in Nav2's global costmap."),
}


def _node(tag: str, base: type[Nav2Service], type: str, service: str, doc: str) -> type[Node]:
    ports: dict[str, Any] = {name: port for name, port in NAV2[tag].ports.items() if name not in base.ports}
    if service:
        ports["service_name"] = Input(str, service, "name of the service", parse=parse_name)
    return made_node(tag, base, doc, {"type": type, "kind": NAV2[tag].kind, **ports}, __name__)


def _cancel(tag: str, server: str) -> type[Node]:
    port = Input(str, server_of(server), "name of the action", parse=parse_name)
    members = {"type": "action_msgs/srv/CancelGoal", "server_name": port}
    return made_node(tag, _Cancel, f"Cancels the goals of Nav2's server of {server}.", members, __name__)


SERVICES: Final = (
    *(_node(tag, *row) for tag, row in _SERVICES.items()),
    *(_cancel(tag, server) for tag, server in CANCELLED.items()),
)
"""Nodes that call services."""
