"""Settings of a robot's connection to ROS 2: the `[ros2]` table of robot.toml."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Literal

from ..base.errors import Fault, InputError
from ..base.files import is_file, read_text
from ..base.units import Bounds
from ..declare import Valid, Value

MAX_DOMAIN = 232
"""Largest domain for which DDS has network ports."""

NAME_HINT = "Use letters, digits and single underscores, and slashes between names; no name begins with a digit."

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*\Z")


def is_ros_name(name: str) -> bool:
    """Whether a text can be the name of a topic or namespace, which may begin with a slash."""
    return _NAME.match(name.removeprefix("/")) is not None and "__" not in name


def _is_name_or_empty(name: str) -> bool:
    return not name or is_ros_name(name)


_Topic = Annotated[str, Valid(_is_name_or_empty, "a valid topic", NAME_HINT)]
_Namespace = Annotated[str, Valid(_is_name_or_empty, "a valid namespace", NAME_HINT)]


class Ros2Settings(Value):
    """Settings of the connection to ROS 2.

    Attributes:
        transport: `rclpy` (needs a ROS 2 installation), `dds` (without ROS), or `auto`: rclpy where it can be imported.
        distro: Distribution of the network; with rclpy, that of the installation is used.
        domain: ROS domain; None for the environment variable ROS_DOMAIN_ID, or 0.
        network: `loopback` for nodes on this computer only, or `lan`.
        namespace: Namespace of relative topics; empty for none.
        use_sim_time: Whether the robot is simulated: time is that of the topic `/clock`.
        emergency_stop: Topic of an emergency stop (std_msgs/msg/Bool, true while pressed); empty for none.
        messages: Folder with the definitions of own message types, such as `my_msgs/msg/Thing.msg`; None for none.
        go: Topic (std_msgs/msg/Bool) on which a person lets the robot move again; empty for none.
    """

    transport: Literal["auto", "rclpy", "dds"] = "auto"
    distro: str = "jazzy"
    domain: Annotated[int, Bounds(0, MAX_DOMAIN)] | None = None
    network: Literal["loopback", "lan"] = "loopback"
    namespace: _Namespace = ""
    use_sim_time: bool = False
    emergency_stop: _Topic = ""
    messages: Path | None = None
    go: _Topic = ""

    @property
    def domain_id(self) -> int:
        """Number of the ROS domain, from this table or from the environment.

        Raises:
            InputError: ROS_DOMAIN_ID is no valid number.
        """
        if self.domain is not None:
            return self.domain
        text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
        if not (text.isascii() and text.isdecimal() and int(text) <= MAX_DOMAIN):
            raise InputError(Fault(f"ROS_DOMAIN_ID must be a number from 0 to {MAX_DOMAIN}, found '{text}'."))
        return int(text)

    def topic(self, name: str) -> str:
        """Full name of a topic: a relative name gets the namespace.

        Raises:
            InputError: The name is not valid.
        """
        if not is_ros_name(name):
            raise InputError(Fault(f"'{name}' is not a valid topic.", hint=NAME_HINT))
        if name.startswith("/"):
            return name
        return "/" + "/".join(part for part in (self.namespace.strip("/"), name) if part)

    def definition(self, name: str) -> str | None:
        """Text of the definition of an own message type; None if the folder `messages` has none."""
        file = None if self.messages is None else self.messages.joinpath(*name.split("/")).with_suffix(".msg")
        return None if file is None or not is_file(file) else read_text(file)
