"""RosService: call of a ROS 2 service."""

from __future__ import annotations

from typing import Any

from ...base.errors import DeviceError, InputError
from ...base.units import TIME
from ...interfaces.action import Failure, Reason
from ...trees.nodes import RUNNING, SUCCESS, Input, Leaf, Outcome
from ..ros_link import RosCall, RosLink, RosMessage, RosServiceClient
from .assignments import FieldInputs, FieldOutputs
from .uses_ros import UsesRos, interface_type, mismatched, parse_name


class ServiceLeaf(UsesRos[RosServiceClient], Leaf):
    """Base of leaves that call a service: RUNNING until its response is there.

    FAILURE if no server is there within `wait`, if there is no response within `timeout`, or if the server refuses the
    request.
    """

    wait: Any
    timeout: Any
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
    parts = {"request": "_Request", "response": "_Response"}  # noqa: RUF012 - a table of the class

    service = Input(str, doc="name of the service", parse=parse_name)
    type_ = Input(str, doc="service type", name="type", parse=interface_type("srv"))
    request = FieldInputs("fields of the request: path = value; path = {key}")
    response = FieldOutputs("keys for fields of the response: path -> {key}")
    wait = Input(float, 5.0, "maximum time to wait for a server [s]", dimension=TIME)
    timeout = Input(float, 5.0, "maximum time to wait for the response [s]", dimension=TIME)

    def message(self) -> dict[str, Any]:
        return self.message_of("request")

    def responded(self, response: RosMessage) -> Outcome:
        missing = self.put("response", response)
        self.feedback_message = f"'{self.service}' responded"
        return self.failed(Failure(Reason.CANNOT, missing)) if missing else SUCCESS
