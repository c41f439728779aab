"""Bases of the nodes that call the services of a running Nav2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from ...base.errors import DeviceError, InputError
from ...base.units import TimeLimit
from ...interfaces.action import Failure, Reason
from ...nav2.costs import NO_INFORMATION
from ...nav2.goals import SKIPPED, Statuses
from ...nav2.lenient import Served, Serviced
from ...nav2.path import poses_in
from ...nav2.poses import list_of
from ...trees.nodes import FAILURE, RUNNING, SUCCESS, Leaf, Outcome, Syntax
from ..ros_link import RosCall, RosField, RosLink, RosMessage, RosServiceClient, RosTypes
from .assignments import FieldInputs, FieldOutputs
from .nav2_messages import Nav2Caller, field_of
from .uses_ros import UsesRos, interface_type, mismatched, parse_name

PATIENCE = 5.0
"""Maximum time to wait for a service, and for its response [s]."""


class ServiceLeaf(UsesRos[RosServiceClient], Leaf):
    """Base of leaves that call a service: RUNNING until its response is there.

    FAILURE if no server is there within `wait`, if there is no response within `timeout`, or if the server refuses the
    request.
    """

    wait = timeout = PATIENCE
    _call: RosCall | None = None
    _until = 0.0

    def message(self) -> dict[str, Any]:
        """Fields of the request.

        Raises:
            InputError: A value is missing or does not fit.
        """
        raise NotImplementedError

    def responded(self, response: RosMessage) -> Outcome:
        """Outcome for a response."""
        raise NotImplementedError

    def connect(self, link: RosLink, name: str, type: str) -> RosServiceClient:
        return link.service(name, type)

    def initialise(self) -> None:
        self._call = None
        self._until = self.runtime.now() + self.wait

    def deadline(self) -> float:
        return self._until

    def update(self) -> Outcome:
        client = self.opened()
        if isinstance(client, Failure):
            return self.failed(client)
        name = self.names()[0]
        if self._call is None:
            if not client.ready():
                missing = f"no server of the service '{name}' within {self.wait:g} s"
                return self._waits(f"a server of '{name}'", Reason.UNHEARD, missing + mismatched(client))
            try:
                self._call = client.call(self.message())
            except InputError as error:
                return self.failed(Failure.cannot(error))
            except DeviceError as error:
                return self.failed(Failure(Reason.REFUSED, str(error)))
            self._until = self.runtime.now() + self.timeout
        if self._call.error:
            return self.failed(Failure(Reason.REFUSED, f"the service '{name}' failed: {self._call.error}"))
        if self._call.response is not None:
            return self.responded(self._call.response)
        missing = f"no response of the service '{name}' within {self.timeout:g} s"
        return self._waits(f"the response of '{name}'", Reason.TIMEOUT, missing)

    def terminate(self, new_status: Outcome) -> None:
        if self._call is not None:
            self._call.forget()
            self._call = None

    def _waits(self, what: str, reason: Reason, evidence: str) -> Outcome:
        if self.runtime.now() >= self._until:
            return self.failed(Failure(reason, evidence))
        self.feedback_message = f"waits for {what}"
        return RUNNING


class RosService(ServiceLeaf):
    """Calls a service: RUNNING until its response is there, then SUCCESS; needs rclpy.

        <RosService service="lamp" type="std_srvs/srv/SetBool" request="data = true" response="message -> {text}"/>

    FAILURE if no server is there within `wait`, if there is no response within `timeout`, or if the server refuses the
    request. A response that means failure, such as `success = false`, is a response: test its fields.
    """

    named = "service"
    parts: ClassVar = {"request": "_Request", "response": "_Response"}

    service: Annotated[str, Syntax(parse_name), "name of the service"]
    type_: Annotated[str, Syntax(interface_type("srv")), "service type"]
    request: Annotated[FieldInputs, "fields of the request: path = value; path = {key}"] = ""
    response: Annotated[FieldOutputs, "keys for fields of the response: path -> {key}"] = ""
    wait: Annotated[TimeLimit, "maximum time to wait for a server [s]"] = 5.0
    timeout: Annotated[TimeLimit, "maximum time to wait for the response [s]"] = 5.0

    def message(self) -> dict[str, Any]:
        return self.message_of("request")

    def responded(self, response: RosMessage) -> Outcome:
        missing = self.put("response", response)
        self.feedback_message = f"'{self.service}' responded"
        return self.failed(Failure(Reason.CANNOT, missing)) if missing else SUCCESS


class Nav2Service(Nav2Caller, ServiceLeaf):
    """Base of nodes that call a service of Nav2: RUNNING until its response is there; FAILURE after 5 s without it."""

    named = "service_name"
    parts: ClassVar = {"request": "_Request", "response": "_Response"}

    service_name: Annotated[str, Syntax(parse_name), "name of the service"]
    server_timeout: Annotated[float, "timeout in Nav2 [ms]; not used"] = 0.0

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

    server_name: Annotated[str, Syntax(parse_name), "name of the action"]
    service_name = Serviced.service_name
    error_code_id, error_msg = Served.error_code_id, Served.error_msg

    def names(self) -> tuple[str, str]:
        return f"{self._name('server_name')}/_action/cancel_goal", self.type
