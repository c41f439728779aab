"""Names of topics and frames in ROS 2, the same for `rocs-bt sim` and for exported bags."""

from __future__ import annotations

import re
from functools import cache

MAP, ODOM, FOOTPRINT, BASE = "map", "odom", "base_footprint", "base_link"
"""Frames of REP 105 and REP 120."""


class RosNames:
    """Names of the topics and frames of a robot.

    The prefix of frames is by default the namespace.
    """

    def __init__(self, namespace: str, prefix: str | None = None) -> None:
        self.namespace = namespace
        self._prefix = namespace if prefix is None else prefix

    def topic(self, name: str) -> str:
        """Full name of a topic."""
        return f"/{_within(self.namespace, name)}"

    def frame(self, name: str) -> str:
        """Full name of a frame."""
        return _within(self._prefix, name)


def _within(outer: str, name: str) -> str:
    own = "/".join(map(ros_name, name.split("/")))
    return f"{outer}/{own}" if outer else own


@cache
def ros_name(name: str) -> str:
    """Name that ROS accepts for a robot or device: letters, digits and single underscores, no digit first."""
    plain = re.sub(r"[\W_]+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"


def robot_namespace(robot: str) -> str:
    """Namespace of one of several robots: its name in lower case."""
    return ros_name(robot).lower()
