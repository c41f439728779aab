"""Ports of Nav2's nodes: a port without a value is no error by itself, and values have the types of Nav2."""

from __future__ import annotations

from typing import Annotated, Any, Final

from ..plan.context import MissionContext
from ..trees.nodes import Node, Output, Port, pointer

_EMPTY: Final[dict[Any, Any]] = {bool: False, int: 0, float: 0.0, str: "", list: ()}


class Lenient(Node):
    """Base of Nav2's nodes: an input port with a key without a value has its default, or is empty, as in Nav2."""

    def read(self, port: str) -> Any:
        key = self.key(port)
        if key is not None and key not in self.board:
            return absent(self.ports[port])
        return super().read(port)


def absent(port: Port) -> Any:
    """Value of a port with a key without a value: the default if it is a literal, else an empty value or None."""
    default = port.default
    if port.required or pointer(default) is not None:
        return _EMPTY.get(port.kind)
    return port.value(default) if isinstance(default, str) else default


class Served(Lenient):
    """Base of nodes that call an action server in Nav2; here they ignore its address."""

    server_name: Annotated[str, "address of the server; for a running Nav2 only"] = ""
    server_timeout: Annotated[float, "timeout of the server in Nav2 [ms]; for a running Nav2 only"] = 0.0
    error_code_id: Annotated[Output[int], "error code of nav2_msgs, 0 for none"]
    error_msg: Annotated[Output[str], "error message"]

    def put_error(self, code: int = 0, message: str = "") -> None:
        """Write the outputs for an error; both are zero or empty without one."""
        self.error_code_id, self.error_msg = code, message
        if isinstance(mission := self.runtime.owner, MissionContext):
            error_messages(mission)[code] = message


def error_messages(mission: MissionContext) -> dict[int, str]:
    """Last message of each error code, for conditions that know only the code."""
    found: dict[int, str] = mission.shared.setdefault("nav2 errors", {})
    return found


class Serviced(Lenient):
    """Base of nodes that call a service in Nav2; here they ignore its address."""

    service_name: Annotated[str, "address of the service; for a running Nav2 only"] = ""
    server_timeout: Annotated[float, "timeout of the service in Nav2 [ms]; for a running Nav2 only"] = 0.0


class Framed(Lenient):
    """Base of nodes that look up the robot's pose in Nav2's transforms; here it is that of Knowledge."""

    global_frame: Annotated[str, "frame in Nav2; here the world frame"] = "map"
    robot_base_frame: Annotated[str, "frame in Nav2; not used"] = "base_link"
