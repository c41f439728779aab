"""RosService: call of a ROS 2 service."""

from __future__ import annotations

from ...action import Failure, Reason
from ...errors import DeviceError, InputError
from ...ros_link import RosCall, RosLink, RosServiceClient
from ...trees.nodes import RUNNING, SUCCESS, Input, Leaf, Outcome
from ...units import TIME
from .assignments import FieldInputs, FieldOutputs
from .uses_ros import UsesRos, interface_type, mismatched, parse_name


class RosService(UsesRos[RosServiceClient], Leaf):
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

    _call: RosCall | None = None

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
        if self._call is None:
            if not client.ready():
                return self._absent(client)
            try:
                self._call = client.call(self.message_of("request"))
            except InputError as error:
                return self.failed(Failure.cannot(error))
            except DeviceError as error:
                return self.failed(Failure(Reason.REFUSED, str(error)))
            self._until = self.runtime.now() + self.timeout
        call = self._call
        if call.error:
            return self.failed(Failure(Reason.REFUSED, f"the service '{self.service}' failed: {call.error}"))
        if call.response is not None:
            missing = self.put("response", call.response)
            self.feedback_message = f"'{self.service}' responded"
            return self.failed(Failure(Reason.CANNOT, missing)) if missing else SUCCESS
        if self.runtime.now() >= self._until:
            evidence = f"no response of the service '{self.service}' within {self.timeout:g} s"
            return self.failed(Failure(Reason.TIMEOUT, evidence))
        self.feedback_message = f"waits for the response of '{self.service}'"
        return RUNNING

    def terminate(self, new_status: Outcome) -> None:
        if self._call is not None:
            self._call.forget()
            self._call = None

    def _absent(self, client: RosServiceClient) -> Outcome:
        if self.runtime.now() >= self._until:
            evidence = f"no server of the service '{self.service}' within {self.wait:g} s" + mismatched(client)
            return self.failed(Failure(Reason.UNHEARD, evidence))
        self.feedback_message = f"waits for a server of '{self.service}'"
        return RUNNING
