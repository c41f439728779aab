"""Settings of a robot's connection to ROS 2: the `[ros2]` table of robot.toml."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path

from ..base.errors import Fault, InputError, unknown
from ..base.files import is_file, read_text

TRANSPORTS = ("auto", "rclpy", "dds")
NETWORKS = ("loopback", "lan")
MAX_DOMAIN = 232
"""Largest domain for which DDS has network ports."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*\Z")


@dataclass(frozen=True)
class Ros2Settings:
    """Settings of the connection to ROS 2.

    Attributes:
        transport: `rclpy` (needs a ROS 2 installation), `dds` (without ROS), or `auto`: rclpy where it can be imported.
        distro: Distribution of the network; with rclpy, that of the installation is used.
        domain: ROS domain; None for the environment variable ROS_DOMAIN_ID, or 0.
        network: `loopback` for nodes on this computer only, or `lan`.
        namespace: Namespace of relative topics; empty for none.
        use_sim_time: Whether the robot is simulated: time is that of the topic `/clock`.
        emergency_stop: Topic of an emergency stop (std_msgs/msg/Bool, true while pressed); empty for none.
        messages: Folder with the definitions of own message types, such as `my_msgs/msg/Thing.msg`; empty for none.
        go: Topic (std_msgs/msg/Bool) on which a person lets the robot move again; empty for none.

    Raises:
        InputError: A value is not valid; contains all faults.
    """

    transport: str = "auto"
    distro: str = "jazzy"
    domain: int | None = None
    network: str = "loopback"
    namespace: str = ""
    use_sim_time: bool = False
    emergency_stop: str = ""
    messages: str = ""
    go: str = ""

    def __post_init__(self) -> None:
        faults = []
        if self.transport not in TRANSPORTS:
            faults.append(unknown("transport", self.transport, TRANSPORTS))
        if self.network not in NETWORKS:
            faults.append(unknown("network", self.network, NETWORKS))
        if self.domain is not None and not 0 <= self.domain <= MAX_DOMAIN:
            faults.append(Fault(f"domain must be 0 to {MAX_DOMAIN}, found {self.domain}."))
        for what, name in (("namespace", self.namespace), ("emergency_stop", self.emergency_stop), ("go", self.go)):
            if name:
                faults += name_faults(what, name)
        if faults:
            raise InputError(*faults)

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
        if faults := name_faults("topic", name):
            raise InputError(*faults)
        if name.startswith("/"):
            return name
        return "/" + "/".join(part for part in (self.namespace.strip("/"), name) if part)

    def definition(self, name: str) -> str | None:
        """Text of the definition of an own message type; None if the folder `messages` has none."""
        file = Path(self.messages, *name.split("/")).with_suffix(".msg")
        return read_text(file) if self.messages and is_file(file) else None

    def within(self, namespace: str) -> Ros2Settings:
        """Copy of these settings with another namespace."""
        return replace(self, namespace=namespace)


def name_faults(what: str, name: str) -> list[Fault]:
    """Faults of the name of a topic or namespace, which may begin with a slash."""
    if _NAME.match(name.removeprefix("/")) and "__" not in name:
        return []
    hint = "Use letters, digits and single underscores, and slashes between names; no name begins with a digit."
    return [Fault(f"'{name}' is no valid {what}.", hint=hint)]
