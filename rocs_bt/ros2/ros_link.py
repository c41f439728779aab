"""RosLink: interface of a robot's ROS 2 connection for the nodes of a mission.

Nothing in it waits: calls start something, and their handles are polled. Values are plain: numbers, texts, lists, and
mappings for nested messages.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

FieldPath = tuple[str | int, ...]
"""Path to a field of a message: names of fields and indices of arrays; empty for the whole message."""

QOS = ("reliable", "sensor_data", "latched")
"""Quality of service: `reliable`; `sensor_data` (best effort); `latched` (reliable, transient local)."""


@dataclass(frozen=True)
class RosField:
    """Field of a ROS 2 message type.

    Attributes:
        type: Primitive type such as `float64` or `string`, or message type such as `geometry_msgs/msg/Vector3`.
        array: Whether the field is an array.
        size: Number of elements of an array of fixed size; None if the number varies.
    """

    type: str
    array: bool = False
    size: int | None = None

    def __str__(self) -> str:
        return f"{self.type}[{'' if self.size is None else self.size}]" if self.array else self.type


class RosTypes(Protocol):
    """Fields of message, service and action types."""

    def fields(self, type: str) -> Mapping[str, RosField] | None:
        """Fields of a type, by name.

        Args:
            type: Message type such as `std_msgs/msg/String`; or a part of a service or action, such as
                `std_srvs/srv/SetBool_Request` or `test_msgs/action/Fibonacci_Goal`.

        Returns:
            Fields; None if the definitions of the type's package are not installed here.

        Raises:
            InputError: The package has no such type; the hint lists similar ones.
        """


class RosMessage(Protocol):
    """Received message."""

    def get(self, path: FieldPath = ()) -> Any:
        """Value of a field, as a plain value.

        Raises:
            LookupError: The message has no such field, or an array is too short.
        """


class RosPublisher(Protocol):
    """Publisher of a topic."""

    def matched(self) -> int:
        """Number of matched subscriptions."""

    def mismatch(self) -> str:
        """Reason why no subscription of the topic matches, as in the last look; empty if one does, or there is none."""

    def publish(self, values: Mapping[str, Any]) -> None:
        """Publish a message; omitted fields are 0, false or empty.

        Raises:
            DeviceError: The message cannot be sent.
        """

    def close(self) -> None:
        """Close the publisher."""


@dataclass(frozen=True)
class Received:
    """Newest message of a subscription.

    Attributes:
        message: The message.
        age: Time since it was published, at least the time since it was received [s].
        count: Number of the message, counted from 1.
    """

    message: RosMessage
    age: float
    count: int


class RosSubscription(Protocol):
    """Subscription of a topic.

    Attributes:
        ignored: Reason why the last message was ignored, such as a stamp in the future; empty if it was not.
    """

    ignored: str

    def newest(self) -> Received | None:
        """Newest message so far; None before the first."""

    def mismatch(self) -> str:
        """Reason why no publisher of the topic matches; see `RosPublisher.mismatch`."""

    def close(self) -> None:
        """Close the subscription."""


class RosCall(Protocol):
    """Pending call of a service.

    Attributes:
        response: Response; None while there is none.
        error: Reason why the call failed; empty if it has not failed.
    """

    @property
    def response(self) -> RosMessage | None: ...
    @property
    def error(self) -> str: ...
    def forget(self) -> None:
        """Drop the call; its response is ignored."""


class RosClient(Protocol):
    """Client of a service or an action."""

    def ready(self) -> bool:
        """Whether a server is there that matches."""

    def mismatch(self) -> str:
        """Reason why a server of that name does not match, such as another type; empty if there is none."""

    def close(self) -> None:
        """Close the client."""


class RosServiceClient(RosClient, Protocol):
    """Client of a service."""

    def call(self, request: Mapping[str, Any]) -> RosCall:
        """Send a request."""


class GoalState(Enum):
    """State of a goal, as its client knows it."""

    SENT = "not yet accepted"
    REJECTED = "rejected"
    ACCEPTED = "accepted"
    CANCELING = "to be cancelled"
    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "cancelled"
    FAILED = "failed"

    @property
    def done(self) -> bool:
        """Whether the goal has ended."""
        return self not in (GoalState.SENT, GoalState.ACCEPTED, GoalState.CANCELING)


class RosGoal(Protocol):
    """Goal that was sent to an action server.

    Attributes:
        state: State of the goal.
        feedback: Newest feedback; None before the first.
        feedback_count: Number of feedback messages received.
        result: Result; None until the goal has ended.
        error: Reason of the state FAILED.
    """

    @property
    def state(self) -> GoalState: ...
    @property
    def feedback(self) -> RosMessage | None: ...
    @property
    def feedback_count(self) -> int: ...
    @property
    def result(self) -> RosMessage | None: ...
    @property
    def error(self) -> str: ...
    def cancel(self) -> None:
        """Ask the server to cancel the goal, at once or after its acceptance. Never waits."""


class RosActionClient(RosClient, Protocol):
    """Client of an action."""

    def servers(self) -> Mapping[str, str]:
        """Servers: the name of their node, empty if unknown, by an identity that a restarted server does not keep."""

    def send(self, goal: Mapping[str, Any]) -> RosGoal:
        """Send a goal."""


class AcceptedGoal(Protocol):
    """Goal that an action server of this robot has accepted.

    Attributes:
        request: Fields of the goal.
        cancel_requested: Whether the client asks to cancel it.
    """

    @property
    def request(self) -> RosMessage: ...
    @property
    def cancel_requested(self) -> bool: ...
    def feedback(self, values: Mapping[str, Any]) -> None:
        """Publish feedback."""

    def end(self, state: GoalState, result: Mapping[str, Any]) -> None:
        """End the goal as SUCCEEDED, ABORTED or CANCELED, with its result."""


class RosActionServer(Protocol):
    """Action server of this robot, which serves one goal at a time and rejects others meanwhile."""

    def open(self, accepting: bool) -> None:
        """Start or stop accepting a goal."""

    def goal(self) -> AcceptedGoal | None:
        """Goal that is served; None while there is none."""

    def close(self) -> None:
        """Close the server."""


class RosTrigger(Protocol):
    """Server of a service of type std_srvs/srv/Trigger, which answers each request with success."""

    def taken(self) -> bool:
        """Whether there was a request since the last look."""

    def close(self) -> None:
        """Close the server."""


class RosLink(Protocol):
    """ROS 2 connection of a robot. Names of topics, services and actions without a leading `/` get its namespace.

    Services and actions need the transport rclpy; with another one their methods raise an InputError that says why.

    Attributes:
        types: Types that the connection knows.
    """

    @property
    def types(self) -> RosTypes: ...

    def publisher(self, topic: str, type: str, qos: str) -> RosPublisher:
        """Open a publisher.

        Args:
            topic: Name of the topic.
            type: Message type.
            qos: One of `QOS`.

        Raises:
            InputError: The type is unknown, or the name is not valid.
        """

    def subscription(self, topic: str, type: str, qos: str) -> RosSubscription:
        """Open a subscription; see `publisher`."""

    def service(self, name: str, type: str) -> RosServiceClient:
        """Open a client of a service; see `publisher`."""

    def action(self, name: str, type: str) -> RosActionClient:
        """Open a client of an action; see `publisher`."""

    def action_server(self, name: str, type: str) -> RosActionServer:
        """Open a server of an action; see `publisher`."""

    def trigger(self, name: str) -> RosTrigger:
        """Open a server of a service of type std_srvs/srv/Trigger; see `publisher`."""


NO_LINK = (
    "this robot has no ROS connection. Simulated runs (`rocs-bt run`) have none: run the scenario with "
    "`rocs-bt drive`, on a robot with a [ros2] table in its robot.toml"
)
"""Reason why a node of ROS fails without a connection."""


def index_path(path: Sequence[str | int]) -> str:
    """Text of a field path, such as `poses[0].position.x`; empty for the whole message."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")
