"""RosPublish and RosSubscribe: topics of ROS 2."""

from __future__ import annotations

from typing import Annotated, ClassVar

from ...base.errors import DeviceError, InputError, unknown
from ...base.units import TimeLimit
from ...interfaces.action import Failure, Reason
from ...trees.nodes import RUNNING, SUCCESS, Leaf, Outcome, Syntax
from ..ros_link import QOS, RosLink, RosPublisher, RosSubscription
from .assignments import FieldInputs, FieldOutputs
from .uses_ros import FOREVER, UsesRos, interface_type, mismatched, parse_name


def parse_qos(text: str) -> str:
    """Parse a quality of service.

    Raises:
        InputError: The text is not one of `QOS`.
    """
    if text not in QOS:
        raise InputError(unknown("quality of service", text, QOS))
    return text


class RosPublish(UsesRos[RosPublisher], Leaf):
    """Publishes a message on a topic, then SUCCESS.

        <RosPublish topic="say" type="std_msgs/msg/String" values="data = 'hello'"/>
        <RosPublish topic="aim" type="geometry_msgs/msg/Twist" values="linear.x = 0.2 m/s; angular.z = {turn}"/>

    Fields without a value are 0, false or empty.
    """

    parts: ClassVar = {"values": ""}

    topic: Annotated[str, Syntax(parse_name), "name of the topic"]
    type_: Annotated[str, Syntax(interface_type("msg")), "message type"]
    values: Annotated[FieldInputs, "fields of the message: path = value; path = {key}"] = ""
    qos: Annotated[str, Syntax(parse_qos), "reliable, sensor_data or latched"] = "reliable"
    wait: Annotated[TimeLimit, "maximum time to wait for a subscription [s]"] = 0.0

    def connect(self, link: RosLink, name: str, type: str) -> RosPublisher:
        return link.publisher(name, type, self.qos)

    def initialise(self) -> None:
        self._until = self.runtime.now() + self.wait

    def deadline(self) -> float:
        return self._until

    def update(self) -> Outcome:
        publisher = self.opened()
        if isinstance(publisher, Failure):
            return self.failed(publisher)
        if self.runtime.now() < self._until and not publisher.matched():
            self.feedback_message = f"waits for a subscription of '{self.topic}'" + mismatched(publisher)
            return RUNNING
        try:
            publisher.publish(self.message_of("values"))
        except InputError as error:
            return self.failed(Failure.cannot(error))
        except DeviceError as error:
            return self.failed(Failure(Reason.REFUSED, str(error)))
        unheard = "" if publisher.matched() else mismatched(publisher)
        self.feedback_message = f"published on '{self.topic}'{unheard and ', where nothing receives it'}{unheard}"
        return SUCCESS


class RosSubscribe(UsesRos[RosSubscription], Leaf):
    """Reads the newest message of a topic: RUNNING until there is one, then SUCCESS.

        <RosSubscribe topic="battery" type="sensor_msgs/msg/BatteryState" values="percentage -> {charge}"/>

    Messages are received from the start of the run. With `timeout="0 s"` the node is a condition: SUCCESS if a message
    is there that is recent enough, else FAILURE.
    """

    parts: ClassVar = {"values": ""}

    topic: Annotated[str, Syntax(parse_name), "name of the topic"]
    type_: Annotated[str, Syntax(interface_type("msg")), "message type"]
    values: Annotated[FieldOutputs, "keys for fields of the message: path -> {key}; . is the whole message"] = ""
    qos: Annotated[str, Syntax(parse_qos), "reliable, sensor_data or latched"] = "reliable"
    max_age: Annotated[TimeLimit, "maximum age of the message [s]"] = FOREVER
    new: Annotated[bool, "whether the message must arrive after the node has started"] = False
    timeout: Annotated[TimeLimit, "time after which the node fails without a message [s]"] = FOREVER

    def connect(self, link: RosLink, name: str, type: str) -> RosSubscription:
        return link.subscription(name, type, self.qos)

    def initialise(self) -> None:
        self._until = self.runtime.now() + self.timeout
        self._seen: int | None = None

    def deadline(self) -> float:
        return self._until

    def update(self) -> Outcome:
        subscription = self.opened()
        if isinstance(subscription, Failure):
            return self.failed(subscription)
        newest = subscription.newest()
        if self._seen is None:
            self._seen = newest.count if newest is not None and self.new else 0
        if newest is not None and newest.count > self._seen and newest.age <= self.max_age:
            missing = self.put("values", newest.message)
            self.feedback_message = f"message of '{self.topic}', {newest.age:.2f} s old"
            return self.failed(Failure(Reason.CANNOT, missing)) if missing else SUCCESS
        state = "no message" if newest is None else f"the newest message is {newest.age:.1f} s old"
        if newest is not None and newest.age <= self.max_age:
            state = "no new message"
        why = f" (ignored: {subscription.ignored})" if subscription.ignored else mismatched(subscription)
        self.feedback_message = f"waits for '{self.topic}': {state}{why}"
        if self.runtime.now() >= self._until:
            return self.failed(Failure(Reason.TIMEOUT, f"{state} on '{self.topic}' within {self.timeout:g} s{why}"))
        return RUNNING
