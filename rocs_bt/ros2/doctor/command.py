"""Output of `rocs-bt doctor --ros2`."""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...base.errors import DeviceError, Fault, InputError
from ...cli.content import catalog_for
from ...cli.terminal import echo, show_table

if TYPE_CHECKING:
    from .measure import Examination, TopicState

_NONE = "–"
_OTHER_CLOCK = 1e6  # [s] from which two times have different origins, such as simulated time


def examine_ros2(robot: str | None, network: str, duration: float) -> int:
    """Examine the topics of a robot, or list all discovered topics; returns the exit code.

    Raises:
        InputError: The robot is invalid or has no ROS 2 device, or a package is not installed.
    """
    from ...declare import checked
    from ..settings import Ros2Settings
    from .measure import examine

    spec = None if robot is None else catalog_for(robot, no_code=True).load_robot(robot)
    if spec is not None and "ros2" not in spec.tables:
        raise InputError(
            Fault(f"the robot '{spec.name}' has no [ros2] table.", spec.file, hint="See rocs-bt docs: ros2.md.")
        )
    asked = checked(Ros2Settings, {"network": network}, "the network")
    settings = asked if spec is None or "ros2" not in spec.tables else spec.tables["ros2"]
    for line in _installed():
        echo(line)
    try:
        found = examine(spec, settings, duration)
    except DeviceError as error:
        echo(str(error), err=True)
        return 1
    echo(f"network     ROS domain {found.domain}, {found.network}, by {found.transport}, types of {found.distro}")
    echo()
    return _show_all(found) if spec is None else _show_robot(found)


def _installed() -> Iterator[str]:
    """Lines about the packages and ROS 2."""
    for package, use in (("rosbags", "message types"), ("cyclonedds", "DDS without ROS")):
        try:
            yield f"{package:<11} {importlib.metadata.version(package)}"
        except importlib.metadata.PackageNotFoundError:
            yield f"{package:<11} not installed ({use}): pip install 'rocs_bt[ros2]'"
    from ..network.rclpy_transport import has_rclpy

    distro = os.environ.get("ROS_DISTRO", "of an unknown distribution")
    yield f"rclpy       {distro if has_rclpy() else 'not here; services and actions need an installation of ROS 2'}"


def _show_robot(found: Examination) -> int:
    rows = [
        (
            topic.device,
            topic.topic,
            ", ".join(sorted(filter(None, topic.nodes))) or ("unknown" if topic.nodes else _NONE),
            _NONE if topic.rate is None else f"{topic.rate:.1f}",
            _milliseconds(topic.age),
            _milliseconds(topic.header),
            _values(topic),
            _verdict(topic),
        )
        for topic in found.topics
    ]
    styles = {i: "yellow" for i, topic in enumerate(found.topics) if topic.problem}
    head = ("device", "topic", "node", "Hz", "age ms", "header ms", "values", "")
    show_table(rows, head, styles=styles, right=(3, 4, 5), box=None, pad_edge=False)
    for topic in found.topics:
        for text in filter(None, (topic.problem, topic.remark)):
            echo(f"{topic.device}: {text}", err=True)
    wrong = sum(_verdict(topic) == "problem" for topic in found.topics)
    echo(f"{len(found.topics)} topics, {wrong} with a problem.")
    return 1 if wrong else 0


def _show_all(found: Examination) -> int:
    """List all endpoints; exit code 1 if there are none."""
    rows = [
        (e.topic, e.type, e.node or "unknown", "publishes" if e.publishes else "reads", e.qos) for e in found.endpoints
    ]
    show_table(rows, ("topic", "type", "node", "", "quality of service"), box=None, pad_edge=False)
    if not rows:
        echo("No node was discovered: compare ROS_DOMAIN_ID, and the network (--network lan).", err=True)
    return 0 if rows else 1


def _milliseconds(time: float | None) -> str:
    if time is None:
        return _NONE
    return f"{1e3 * time:.1f}" if abs(time) < _OTHER_CLOCK else "other clock"


def _verdict(topic: TopicState) -> str:
    if not topic.problem:
        return topic.kind or "good"
    return "optional" if topic.optional else "problem"


def _values(topic: TopicState) -> str:
    if topic.matched is not None:
        return f"{topic.matched} matched"
    return _NONE if topic.size is None else str(topic.size)
