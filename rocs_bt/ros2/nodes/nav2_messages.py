"""Messages of a running Nav2, filled from the ports of its nodes, and written to them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

from ...base.errors import Fault, InputError
from ...base.geometry import Pose2
from ...nav2.lenient import Lenient
from ...nav2.path import poses_in
from ...nav2.poses import list_of, pose_of, robot_pose
from ...trees.nodes import Direction
from ..messages.field_path import primitive
from ..messages.fields import time_fields
from ..ros_link import RosField, RosMessage, RosTypes
from .fields import message, seconds
from .uses_ros import UsesRos

STAMPED, PATH = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Path"
_POINTS = ("geometry_msgs/msg/Point", "geometry_msgs/msg/Vector3")
_EMPTY: tuple[Any, ...] = (None, "", [])


class Nav2Caller(Lenient, UsesRos[Any]):
    """Base of nodes that call an action or a service of Nav2.

    A field of the goal or request is filled from the port of its name, as its type needs it, and the output ports are
    written from the fields of their names. Fields that the installed nav2_msgs does not have are omitted, because they
    differ between the distributions of ROS 2. Poses are names of places in the world model, or texts of a PoseStamped,
    in the frame of the port `frame`.

    Attributes:
        type: Type of the action or service.
        inputs: Port for each field of another name.
        outputs: Field for each output port of another name.
        optional: Ports with poses; their fields are omitted without a value.
    """

    type: ClassVar[str] = ""
    inputs: ClassVar[Mapping[str, str]] = {}
    outputs: ClassVar[Mapping[str, str]] = {}
    optional: ClassVar[frozenset[str]] = frozenset({"start", "viapoints", "dock_pose"})

    frame: Annotated[str, "frame of the poses"] = "map"

    def names(self) -> tuple[str, str]:
        return self._name(self.named), self.type

    def fields(self, known: Mapping[str, RosField], types: RosTypes) -> dict[str, Any]:
        """Fields of the goal or request, as plain values.

        Raises:
            InputError: A pose or a path is not known.
        """
        found: dict[str, Any] = {}
        for name, field in known.items():
            port = self.inputs.get(name, name)
            value = self.read(port) if port in self.ports else None
            if port in self.ports and not (port in self.optional and value in _EMPTY):
                found[name] = self.as_field(field, value, types)
        return found

    def as_field(self, field: RosField, value: Any, types: RosTypes) -> Any:
        """Value of a port as plain values of a field's type."""
        if primitive(field):
            if field.array:
                return [part.strip() for part in value.split(";")] if isinstance(value, str) else list(value or ())
            return value
        if field.array:
            return [self.stamped(each) for each in list_of(value)]
        if field.type == STAMPED:
            return self.stamped(value)
        if field.type == PATH:
            return path_message(value, self.frame)
        if field.type.endswith("/Duration"):
            return time_fields(value)
        if field.type in _POINTS:
            return {"x": value}
        inner = types.fields(field.type) or {}  # a message that contains an array of poses
        array = next((name for name, each in inner.items() if each.array and not primitive(each)), "poses")
        return {"header": {"frame_id": self.frame}, array: [self.stamped(each) for each in list_of(value)]}

    def filled(self, part: str) -> dict[str, Any]:
        """Plain values of the goal or request.

        Raises:
            InputError: The type is not installed, or a pose or a path is not known.
        """
        types, name = None if self.link is None else self.link.types, f"{self.type}_{part}"
        known = None if types is None else types.fields(name)
        if types is None or known is None:
            hint = f"Install {self.type.partition('/')[0]}."
            raise InputError(Fault(f"the fields of {self.type} are not known here.", hint=hint))
        given = {field: value for field, value in self.fields(known, types).items() if field in known}
        return message(types, name, [((), given)])

    def write_fields(self, received: RosMessage | None) -> None:
        """Write the fields of a message to output ports, durations in seconds."""
        for name, port in self.ports.items() if received is not None else ():
            if port.direction is Direction.OUTPUT and self.key(name) is not None and received is not None:
                value = field_of(received, self.outputs.get(name, name), None)
                if value is not None:
                    self.write(name, seconds(value) if isinstance(value, Mapping) and "nanosec" in value else value)

    def stamped(self, value: Any) -> dict[str, Any]:
        """PoseStamped of a pose, of a PoseStamped's text, or of a place in the world model by its name.

        Raises:
            InputError: The pose is not known.
        """
        mission = self.mission
        pose = None if mission is None or value is None else pose_of(mission, value)
        if mission is None or pose is None or not math.isfinite(pose.x + pose.y):
            raise InputError(Fault(f"the pose of '{value}' is not known." if value else "there is no goal."))
        if math.isnan(pose.yaw):  # any heading: that of the straight line from the robot
            here = robot_pose(mission)
            yaw = math.atan2(pose.y - here.y, pose.x - here.x)
            pose = Pose2(pose.x, pose.y, yaw if math.isfinite(yaw) else 0.0)
        return stamped_message(pose, self.frame)


def field_of(received: RosMessage, name: str, default: Any) -> Any:
    """Field of a message; the default if the installed type does not have it."""
    try:
        return received.get((name,))
    except LookupError:
        return default


def stamped_message(pose: Pose2, frame: str) -> dict[str, Any]:
    """Plain values of a geometry_msgs/PoseStamped; its stamp is 0, which means the latest transform."""
    position, turned = {"x": pose.x, "y": pose.y}, {"z": math.sin(pose.yaw / 2.0), "w": math.cos(pose.yaw / 2.0)}
    return {"header": {"frame_id": frame}, "pose": {"position": position, "orientation": turned}}


def path_message(value: Any, frame: str) -> Mapping[str, Any]:
    """Plain values of a nav_msgs/Path.

    Args:
        value: Plain values of one; or corners, (x, y) in the frame [m], each of which gets the heading of the leg that
            begins there.
        frame: Name of the frame.

    Raises:
        InputError: The value is neither, or the path is empty.
    """
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise InputError(Fault(f"{value!r:.60} is no path.", hint="Write the key of a path."))
    return {"header": {"frame_id": frame}, "poses": [stamped_message(pose, frame) for pose in poses_in(value)]}
