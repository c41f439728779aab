"""Names of topics and frames in ROS 2, the same for `rocs-bt sim` and for exported bags."""

from __future__ import annotations

import re
from functools import cache

MAP, ODOM, BASE = "map", "odom", "base_link"
"""Frames of REP 105."""


class RosNames:
    """Names of the topics and frames of a robot.

    Args:
        namespace: Namespace of its topics, and prefix of its frames, without slashes at the ends; empty for none.
    """

    def __init__(self, namespace: str) -> None:
        self.namespace = namespace

    def topic(self, name: str) -> str:
        """Full name of a topic."""
        return f"/{self.frame(name)}"

    def frame(self, name: str) -> str:
        """Full name of a frame."""
        own = "/".join(map(ros_name, name.split("/")))
        return f"{self.namespace}/{own}" if self.namespace else own


@cache
def ros_name(name: str) -> str:
    """Name that ROS accepts for a robot or device: letters, digits and single underscores, no digit first."""
    plain = re.sub(r"[\W_]+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"


def robot_namespace(robot: str) -> str:
    """Namespace of one of several robots: its name in lower case."""
    return ros_name(robot).lower()
