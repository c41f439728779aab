"""UsesRos: base of the nodes that use the robot's ROS 2 connection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from ...base.errors import DeviceError, Fault, InputError
from ...interfaces.action import Failure, Reason
from ...plan.context import MissionContext
from ...plan.waits import until
from ...trees.error import TreeError
from ...trees.nodes import FAILURE, RUNNING, Node, Outcome
from ...trees.nodes.tree import fault_at
from ..messages.field_path import field_at
from ..messages.known_types import installed_types
from ..ros_link import NO_LINK, FieldPath, RosLink, RosMessage, RosTypes, index_path
from .assignments import FieldInput, FieldOutput, inputs_of, parse_inputs, parse_outputs
from .fields import converted, message

FOREVER = math.inf
"""Default of ports with a maximum duration."""


class Endpoint(Protocol):
    """Publisher, subscription, client or server of a connection."""

    def close(self) -> None: ...


E = TypeVar("E", bound=Endpoint)


class UsesRos(Node, Generic[E]):
    """Base of the nodes that use the robot's ROS 2 connection, which is `MissionContext.ros`.

    The node opens its endpoint before the run, or in its first tick if a key holds a name. Without a connection it
    returns FAILURE.

    Attributes:
        named: Port with the name of the topic, service or action.
        parts: Suffix of each part of the type, such as `_Goal`, by the port with its fields, if there is one.
    """

    named: ClassVar[str] = "topic"
    parts: ClassVar[Mapping[str, str]] = {}

    _endpoint: E | None = None
    _opened: tuple[str, str] = ("", "")

    def names(self) -> tuple[str, str]:
        """Name and type of the topic, service or action.

        Raises:
            InputError: A key holds no such name.
        """
        return self._name(self.named), self._name("type")

    def connect(self, link: RosLink, name: str, type: str) -> E:
        """Open the endpoint."""
        raise NotImplementedError

    @property
    def mission(self) -> MissionContext | None:
        """Mission that contains the node; None in a tree without a mission."""
        owner = self.runtime.owner
        return owner if isinstance(owner, MissionContext) else None

    @property
    def link(self) -> RosLink | None:
        """ROS connection of the robot; None without one."""
        return None if self.mission is None else self.mission.services.get("ros2")

    @property
    def types(self) -> RosTypes | None:
        """Types of the connection; without one those that are installed, in the mission of a robot."""
        if self.link is not None:
            return self.link.types
        return None if self.mission is None else installed_types(self.mission.tables.get("ros2"))

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        types = self.types
        if types is None or not self._fixed():
            return
        type = self.names()[1]
        try:
            if types.fields(type + next(iter(self.parts.values()), "")) is None:
                return
        except InputError as error:
            yield from (("type", fault) for fault in error.faults)
            return
        for port, suffix in self.parts.items():
            if port in self.ports and self.key(port) is None:
                yield from self._field_faults(port, type + suffix, types)

    def setup(self, **kwargs: Any) -> None:
        if self.link is not None and self._fixed():
            try:
                self.endpoint()
            except (InputError, DeviceError) as error:
                faults = error.faults if isinstance(error, InputError) else (Fault(str(error)),)
                raise InputError(*(fault_at(self, f.message, f.hint, warning=False) for f in faults)) from error

    def shutdown(self) -> None:
        if self._endpoint is not None:
            self._endpoint.close()
            self._endpoint = None

    def endpoint(self) -> E | None:
        """Endpoint for the present names, opened if necessary; None without a connection.

        Raises:
            InputError: A name or type is not valid, or the transport cannot do it.
            DeviceError: The network refuses it.
        """
        link = self.link
        if link is None:
            return None
        names = self.names()
        if self._endpoint is None or names != self._opened:
            self.shutdown()
            self._endpoint, self._opened = self.connect(link, *names), names
        return self._endpoint

    def opened(self) -> E | Failure:
        """Endpoint, or the reason why there is none."""
        try:
            found = self.endpoint()
        except InputError as error:
            return Failure.cannot(error)
        except DeviceError as error:
            return Failure(Reason.CANNOT, str(error))
        return Failure(Reason.CANNOT, NO_LINK) if found is None else found

    def message_of(self, port: str, *, optional: bool = False) -> dict[str, Any]:
        """Message with the current values of a FieldInputs port.

        Args:
            port: Name of the port.
            optional: Whether fields with keys that have no value are omitted.

        Raises:
            InputError: A key has no value, or a value does not fit its field.
        """
        link, given = self.link, list[tuple[FieldPath, Any]]()
        if link is None:
            raise InputError(NO_LINK)
        for item in self._inputs(port):
            try:
                given.append((item.path, item.current(self.board.__getitem__)))
            except TreeError:
                if not optional:
                    raise
        return message(link.types, self.names()[1] + self.parts[port], given)

    def put(self, port: str, received: RosMessage | None) -> str:
        """Write the fields of a message to the keys of a FieldOutputs port.

        Returns:
            Reason why a field has no value; empty if all were written.
        """
        if received is None:
            return ""
        for item in self._outputs(port):
            try:
                self.board[item.key.name] = received.get(item.path)
            except LookupError as error:
                return f"the message has no '{index_path(item.path)}': {error}"
        return ""

    def deadline(self) -> float:
        """Time until which a RUNNING node waits [s]; infinite without a limit."""
        return math.inf

    def wait_text(self) -> str:
        return until(self.deadline() if self.status is RUNNING else math.inf, self.feedback_message)

    def failed(self, failure: Failure) -> Outcome:
        """End the node with a failure."""
        self.feedback_message = str(failure)
        return FAILURE

    def _fixed(self) -> bool:
        """Whether names and type are written in the mission, not in keys."""
        return all(self.key(name) is None for name in (self.named, "type") if name in self.ports)

    def _name(self, port: str) -> str:
        value: str = self.read(port)
        return value if self.key(port) is None else str(self.ports[port].value(value))  # a key holds text as written

    def _inputs(self, port: str) -> tuple[FieldInput, ...]:
        return inputs_of(self.read(port))

    def _outputs(self, port: str) -> tuple[FieldOutput, ...]:
        value = self.read(port)
        return parse_outputs(value) if isinstance(value, str) else tuple(value)

    def _field_faults(self, port: str, type: str, types: RosTypes) -> Iterator[tuple[str, Fault]]:
        syntax = self.ports[port].syntax
        parse = None if syntax is None else syntax.parse
        items: Iterable[FieldInput | FieldOutput] = ()
        if parse is parse_inputs:
            items = self._inputs(port)
        elif parse is parse_outputs:
            items = self._outputs(port)
        for item in items:
            try:
                field = field_at(types, type, item.path)
                if field is not None and isinstance(item, FieldInput) and item.constant:
                    converted(types, field, item.value, index_path(item.path) or "the message")
            except InputError as error:
                yield from ((port, replace(fault, column=item.column + 1)) for fault in error.faults)


class Matched(Protocol):
    """Endpoint that may have no counterpart that matches."""

    def mismatch(self) -> str:
        """Reason why a counterpart does not match; empty if there is none."""


def mismatched(endpoint: Matched) -> str:
    """Text after `no server` or `no message`: the reason why a counterpart does not match; empty if there is none."""
    reason = endpoint.mismatch()
    return f": {reason}" if reason else ""


def interface_type(kind: str) -> Callable[[str], str]:
    """Parser of a port with a type of ROS; the kind is `msg`, `srv` or `action`."""
    example = {"msg": "std_msgs/msg/String", "srv": "std_srvs/srv/SetBool", "action": "nav2_msgs/action/Spin"}[kind]

    def parse(text: str) -> str:
        parts = text.strip().split("/")
        if len(parts) == 2:
            parts.insert(1, kind)
        if len(parts) != 3 or parts[1] != kind or not all(part.isidentifier() for part in parts):
            raise InputError(Fault(f"'{text}' is not the name of a type.", hint=f"Write it as in {example}."))
        return "/".join(parts)

    return parse


def parse_name(text: str) -> str:
    """Parse the name of a topic, service or action.

    Raises:
        InputError: The text is not a name of ROS.
    """
    parts = text.strip().removeprefix("/").split("/")
    if not all(part.isidentifier() and part.isascii() for part in parts):
        hint = "Use letters, digits, '_' and '/'; a name without a leading '/' gets the namespace of the robot."
        raise InputError(Fault(f"'{text}' is not a name of ROS.", hint=hint))
    return text.strip()
