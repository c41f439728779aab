"""Bases of the nodes that call the services of a running Nav2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...nav2.costs import NO_INFORMATION
from ...nav2.goals import SKIPPED, Statuses
from ...nav2.lenient import Served, Serviced
from ...nav2.path import poses_in
from ...nav2.poses import list_of
from ...trees.nodes import FAILURE, SUCCESS, Input, Outcome
from ..ros_link import RosField, RosMessage, RosTypes
from .nav2_messages import Nav2Caller, field_of
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


class Validate(Nav2Service):
    """Base of nodes that ask whether a path is free."""

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


class CheckPose(_Costs):
    """SUCCESS if a pose is occupied."""

    def fields(self, known: Mapping[str, RosField], types: RosTypes) -> dict[str, Any]:
        return {"use_footprint": self.read("use_footprint"), "poses": [self.stamped(self.read("pose"))]}

    def responded(self, response: RosMessage) -> Outcome:
        return SUCCESS if self.occupied(response, 1) == [True] else FAILURE


class RemoveGoals(Statuses, _Costs):
    """Writes the goals that are free."""

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


class Cancel(Nav2Service):
    """Base of nodes that cancel all goals of an action server."""

    named = "server_name"

    service_name = Serviced.service_name
    error_code_id, error_msg = Served.error_code_id, Served.error_msg

    def names(self) -> tuple[str, str]:
        return f"{self._name('server_name')}/_action/cancel_goal", self.type
