"""Nodes that call the services of a running Nav2, with the names and ports of Nav2's own nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final

from ...action import Failure, Reason
from ...errors import DeviceError, InputError
from ...ros_link import RosCall, RosLink, RosMessage, RosServiceClient
from ...trees.nodes import FAILURE, RUNNING, SUCCESS, Input, Leaf, Node, Outcome, Output
from ..nav2.lenient import Lenient
from ..nav2.path import PathInput, poses_in
from ..nav2.poses import PoseInput
from ..nav2.servers import CANCELLED
from .fields import message
from .nav2_messages import path_message, stamped
from .uses_ros import UsesRos, parse_name

PATIENCE = 5.0
"""Maximum time to wait for a service, and for its response [s]."""


class Nav2Service(Lenient, UsesRos[RosServiceClient], Leaf):
    """Base of nodes that call a service of Nav2: RUNNING until its response is there; FAILURE after 5 s without it.

    Fields that the installed types do not have are omitted.

    Attributes:
        type: Type of the service.
    """

    type: ClassVar[str] = ""
    named = "service_name"
    parts = {"request": "_Request", "response": "_Response"}  # noqa: RUF012 - a table of the class

    service_name = Input(str, doc="name of the service", parse=parse_name)
    server_timeout = Input(float, 0.0, "timeout in Nav2 [ms]; not used")
    frame = Input(str, "map", "frame of the poses")

    _call: RosCall | None = None

    def fields(self) -> Mapping[str, Any]:
        """Fields of the request, as plain values.

        Raises:
            InputError: A pose is not known.
        """
        return {}

    def responded(self, response: RosMessage) -> Outcome:
        """Outcome for a response: FAILURE if it says that there was no success."""
        return SUCCESS if _field(response, "success", True) else FAILURE

    def names(self) -> tuple[str, str]:
        return self._name(self.named), self.type

    def connect(self, link: RosLink, name: str, type: str) -> RosServiceClient:
        return link.service(name, type)

    def initialise(self) -> None:
        self._call = None
        self._until = self.runtime.now() + PATIENCE

    def deadline(self) -> float:
        return self._until

    def update(self) -> Outcome:
        client = self.opened()
        if isinstance(client, Failure):
            return self.failed(client)
        name, late = self.names()[0], self.runtime.now() >= self._until
        if self._call is None:
            if not client.ready():
                self.feedback_message = f"waits for a server of '{name}'"
                why = f"no server of the service '{name}' within {PATIENCE:g} s"
                return self.failed(Failure(Reason.UNHEARD, why)) if late else RUNNING
            try:
                self._call = client.call(self._request())
            except InputError as error:
                return self.failed(Failure.cannot(error))
            except DeviceError as error:
                return self.failed(Failure(Reason.REFUSED, str(error)))
            self._until, late = self.runtime.now() + PATIENCE, False
        if self._call.error:
            return self.failed(Failure(Reason.REFUSED, f"the service '{name}' failed: {self._call.error}"))
        if self._call.response is not None:
            return self.responded(self._call.response)
        self.feedback_message = f"waits for the response of '{name}'"
        why = f"no response of the service '{name}' within {PATIENCE:g} s"
        return self.failed(Failure(Reason.TIMEOUT, why)) if late else RUNNING

    def terminate(self, new_status: Outcome) -> None:
        if self._call is not None:
            self._call.forget()
            self._call = None

    def _request(self) -> dict[str, Any]:
        types = None if self.link is None else self.link.types
        known = None if types is None else types.fields(f"{self.type}_Request")
        if types is None or known is None:
            raise InputError(f"the fields of {self.type} are not known here; install its package.")
        given = {name: value for name, value in self.fields().items() if name in known}
        return message(types, f"{self.type}_Request", [((), given)])


def _field(response: RosMessage, name: str, default: Any) -> Any:
    try:
        return response.get((name,))
    except LookupError:
        return default


class _Clear(Nav2Service):
    plugins = Input(object, None, "names of the layers to clear, separated by ;; all if empty")

    def fields(self) -> Mapping[str, Any]:
        given: Any = self.plugins or ()
        names = [part.strip() for part in given.split(";")] if isinstance(given, str) else list(given)
        found: dict[str, Any] = {"plugins": names}
        if "reset_distance" in self.ports:
            found["reset_distance"] = self.read("reset_distance")
        if "pose" in self.ports:
            found["pose"] = stamped(self, self.read("pose"))
        return found


class ReinitializeGlobalLocalization(Nav2Service):
    """Makes the localisation start again: the robot may be anywhere."""

    type = "std_srvs/srv/Empty"
    service_name = Input(str, "reinitialize_global_localization", "name of the service", parse=parse_name)


class ToggleCollisionMonitor(Nav2Service):
    """Switches Nav2's collision monitor on or off."""

    type = "nav2_msgs/srv/Toggle"
    service_name = Input(str, "collision_monitor/toggle", "name of the service", parse=parse_name)
    enable = Input(bool, True, "whether it is on")

    def fields(self) -> Mapping[str, Any]:
        return {"enable": self.enable}


class ValidatePath(Nav2Service):
    """Asks Nav2's planner server whether a path is free."""

    type = "nav2_msgs/srv/IsPathValid"
    service_name = Input(str, "is_path_valid", "name of the service", parse=parse_name)
    path = PathInput("{path}", "path")
    max_cost = Input(int, 254, "least cost that is an obstacle")
    consider_unknown_as_obstacle = Input(bool, False, "whether unknown cells are obstacles")
    layer_name = Input(str, "", "layer of the costmap; all if empty")
    footprint = Input(str, "", "outline of the robot; that of the costmap if empty")
    stop_at_first_collision = Input(bool, True, "whether only the first bad pose is found")
    max_lookahead_distance = Input(float, -1.0, "length of the path that is tested [m]; all of it if not above 0")
    collision_poses = Output(object, "poses of the path that collide")

    def fields(self) -> Mapping[str, Any]:
        cost, ahead = (
            ("max_cost", "consider_unknown_as_obstacle"),
            ("stop_at_first_collision", "max_lookahead_distance"),
        )
        names = (*cost, "layer_name", "footprint", *ahead)
        return {"path": path_message(self.path, self.frame), **{name: self.read(name) for name in names}}

    def responded(self, response: RosMessage) -> Outcome:
        path = poses_in(self.path)
        found = [path[i] for i in _field(response, "invalid_pose_indices", ()) if 0 <= i < len(path)]
        if "collision_poses" in self.ports:
            self.collision_poses = found
        valid = super().responded(response) is SUCCESS and _field(response, "is_valid", False)
        return SUCCESS if valid else FAILURE


class IsPathValid(ValidatePath):
    """Asks Nav2's planner server whether a path is free; RUNNING until it has responded."""

    kind = "Condition"
    max_cost = Input(int, 253, "least cost that is an obstacle")


class CheckPoseOccupancy(Nav2Service):
    """SUCCESS if a pose is occupied in Nav2's global costmap."""

    type = "nav2_msgs/srv/GetCosts"
    service_name = Input(str, "/global_costmap/get_cost_global_costmap", "name of the service", parse=parse_name)
    pose = PoseInput(None, "pose")
    cost_threshold = Input(float, 254.0, "least cost that is an obstacle")
    use_footprint = Input(bool, True, "whether the outline of the robot counts")
    consider_unknown_as_obstacle = Input(bool, False, "whether unknown cells are obstacles")

    def fields(self) -> Mapping[str, Any]:
        return {"use_footprint": self.use_footprint, "poses": [stamped(self, self.pose)]}

    def responded(self, response: RosMessage) -> Outcome:
        costs = _field(response, "costs", ())
        if super().responded(response) is FAILURE or not len(costs):
            return FAILURE
        occupied = self.consider_unknown_as_obstacle if costs[0] == 255 else costs[0] >= self.cost_threshold
        return SUCCESS if occupied else FAILURE


class _Cancel(Nav2Service):
    """Base of nodes that cancel all goals of an action server."""

    type = "action_msgs/srv/CancelGoal"
    named = "server_name"
    server: ClassVar[str] = ""

    service_name = Input(str, "", "not used")
    error_code_id = Output(int, "never written")
    error_msg = Output(str, "never written")

    def names(self) -> tuple[str, str]:
        return f"{self._name('server_name')}/_action/cancel_goal", self.type


_SERVERS: Final = {"FollowPath": "follow_path", "BackUp": "backup"}
"""Names of action servers that are not the node's name in snake case."""

_CLEARED: Final[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
    "ClearEntireCostmap": ("ClearEntireCostmap", {}),
    "ClearCostmapExceptRegion": ("ClearCostmapExceptRegion", {"reset_distance": Input(float, 1.0, "size [m]")}),
    "ClearCostmapAroundRobot": ("ClearCostmapAroundRobot", {"reset_distance": Input(float, 1.0, "size [m]")}),
    "ClearCostmapAroundPose": (
        "ClearCostmapAroundPose",
        {"reset_distance": Input(float, 1.0, "size [m]"), "pose": PoseInput(None, "centre of the region")},
    ),
}


def service_nodes() -> Iterator[type[Node]]:
    """Nodes that call services, those of one shape from tables."""
    yield from (ReinitializeGlobalLocalization, ToggleCollisionMonitor, ValidatePath, IsPathValid, CheckPoseOccupancy)
    for tag, (name, ports) in _CLEARED.items():
        doc = "Clears one of Nav2's costmaps, or a part of it."
        yield _made(tag, _Clear, doc, {**ports, "type": f"nav2_msgs/srv/{name}"})
    for tag, server in CANCELLED.items():
        snake = "".join(f"_{c.lower()}" if c.isupper() else c for c in server).strip("_")
        port = Input(str, _SERVERS.get(server, snake), "name of the action", parse=parse_name)
        yield _made(tag, _Cancel, f"Cancels the goals of Nav2's server of {server}.", {"server_name": port})


def _made(tag: str, base: type[Node], doc: str, members: Mapping[str, Any]) -> type[Node]:
    return type(tag, (base,), {**members, "tag": tag, "__doc__": doc, "__module__": __name__})
