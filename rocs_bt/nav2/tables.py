"""Nodes of Nav2 that have one shape: selectors, recovery conditions, clearing of costmaps, batteries and others."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final

from ..plan.context import mission_of
from ..trees.nodes import FAILURE, SUCCESS, Direction, Instant, Node, Outcome, port_of
from .lenient import Lenient, Served, Serviced, error_messages
from .planning import route_planners
from .poses import PosesText, PoseText, known, pose_of, robot_pose


class Selector(Lenient, Instant):
    """Base of nodes that write a name: in Nav2 the last text on a topic, without ROS always the default."""

    what: ClassVar[str] = ""
    _kept = ""

    topic_name: Annotated[str, "topic; for a running Nav2 only"] = ""

    def selected(self) -> str:
        """Name that another program has selected; empty without one."""
        return ""

    def update(self) -> Outcome:
        self._kept = self.selected() or self.read(f"default_{self.what}") or self._kept
        if not self._kept:
            return FAILURE
        self.write(f"selected_{self.what}", self._kept)
        return SUCCESS


class _WouldHelp(Lenient, Instant):
    """Base of conditions on an error code; FAILURE if the node that writes the code has not failed yet."""

    kind = "Condition"
    helped: ClassVar[tuple[int, ...]] = ()

    error_code: Annotated[int | None, "error code of the node that failed"] = None
    error_codes_to_check: Annotated[str, "port in Nav2's palette; for a running Nav2 only"] = ""

    def update(self) -> Outcome:
        code = self.error_code
        if code in self.helped:
            return SUCCESS
        what = " ".join(filter(None, (str(code), error_messages(mission_of(self)).get(code or 0, ""))))
        self.feedback_message = f"no recovery helps after the error {what}" if code else "there is no error"
        return FAILURE


class _Clear(Serviced, Instant):
    """Base of nodes that forget obstacles of the robot's map, and the paths of the route planners.

    What the scanner sees, and what is outside of its field of view, stays: the robot's rules read the same map.
    """

    around_pose: ClassVar[bool] = False
    outside: ClassVar[bool] = False

    plugins: Annotated[Any, "layers of the costmap; for a running Nav2 only"] = None

    def update(self) -> Outcome:
        mission = mission_of(self)
        route_planners(mission).clear()
        grid = mission.knowledge.world.occupancy
        if grid is None:
            return SUCCESS
        half = 0.5 * self.read("reset_distance") if "reset_distance" in self.ports else math.inf
        given = self.read("pose") if self.around_pose else None
        centre = pose_of(mission, given) if given is not None else known(robot_pose(mission))
        if centre is None:
            return FAILURE if math.isfinite(half) else SUCCESS
        grid.clear(centre.x, centre.y, half, outside=self.outside)
        return SUCCESS


class _WithoutRos(Lenient, Instant):
    """Base of nodes that cannot do here what they do in Nav2, and end at once."""

    outcome: ClassVar[Outcome] = FAILURE
    code: ClassVar[int] = 0
    why: ClassVar[str] = ""

    def update(self) -> Outcome:
        if isinstance(self, Served):
            self.put_error(self.code, self.why)
        self.feedback_message = self.why
        return self.outcome


class _NoServer(Served, _WithoutRos): ...


class _NoService(Serviced, _WithoutRos):
    outcome = SUCCESS


class BatteryCondition(_WithoutRos):
    """Base of conditions on the state of a battery; FAILURE without ROS."""

    kind = "Condition"
    why = "whether the battery is charging is not known here, as if no message had arrived"
    battery_topic: Annotated[str, "topic; for a running Nav2 only"] = "/battery_status"


class _BatteryLow(BatteryCondition):
    min_battery: Annotated[float, "threshold: charge from 0 to 1"] = 0.0
    is_voltage: Annotated[bool, "whether the threshold is a voltage; for a running Nav2 only"] = False
    why = "the robot has no signal `battery`, as if no message had arrived"

    def update(self) -> Outcome:
        mission = mission_of(self)
        signals = mission.knowledge.signals
        if "battery" not in signals or self.is_voltage:
            return super().update()
        charge = signals.value("battery", mission.clock.now())
        self.feedback_message = f"battery = {charge:.3g}"
        return SUCCESS if charge <= self.min_battery else FAILURE


_RESET = {"reset_distance": port_of(float, "diameter of the region [m]; in Nav2 the side of a square", default=1.0)}
_SELECTED: Final = ("Planner", "Controller", "Smoother", "GoalChecker", "ProgressChecker", "PathHandler")
_HELPED: Final[Mapping[str, tuple[str, tuple[int, ...]]]] = {
    "Planner": ("ComputePathToPose or ComputePathThroughPoses", (200, 207, 208, 300, 307, 308)),
    "Controller": ("FollowPath", (100, 104, 105, 106)),
    "Smoother": ("SmoothPath", (500, 502, 503, 504)),
    "Route": ("ComputeRoute", (400, 404, 405)),
}
_CLEARED: Final[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
    "ClearEntireCostmap": (
        "Forgets all obstacles of the robot's map, except those in sight.",
        {},
    ),
    "ClearCostmapExceptRegion": ("Forgets obstacles of the robot's map outside a region.", {**_RESET, "outside": True}),
    "ClearCostmapAroundRobot": ("Forgets obstacles of the robot's map around the robot.", _RESET),
    "ClearCostmapAroundPose": (
        "Forgets obstacles of the robot's map around a pose.",
        {**_RESET, "pose": port_of(PoseText, "centre of the region", default=None), "around_pose": True},
    ),
}
_TREE = {"behavior_tree": port_of(str, "file of a behaviour tree; for a running Nav2 only", default="")}
_UNDOCK = {
    "dock_type": port_of(str, "plugin; for a running Nav2 only", default=""),
    "max_undocking_time": port_of(float, "maximum duration in Nav2 [s]; for a running Nav2 only", default=30.0),
    "success": port_of(bool, "for a running Nav2 only", Direction.OUTPUT),
}
_DOCK = {
    "use_dock_id": port_of(bool, "whether a name, not a pose, gives the dock; for a running Nav2 only", default=True),
    "dock_id": port_of(str, "name of the dock; for a running Nav2 only", default=""),
    "dock_pose": port_of(PoseText, "pose of the dock; for a running Nav2 only", default=None),
    "dock_type": port_of(str, "plugin; for a running Nav2 only", default=""),
    "max_staging_time": port_of(float, "maximum duration in Nav2 [s]; for a running Nav2 only", default=1000.0),
    "navigate_to_staging_pose": port_of(bool, "whether to drive there first; for a running Nav2 only", default=True),
    "success": port_of(bool, "for a running Nav2 only", Direction.OUTPUT),
    "num_retries": port_of(int, "for a running Nav2 only", Direction.OUTPUT),
}
_LOW: Final = "SUCCESS if the signal `battery` is at most `min_battery`; FAILURE without the signal, or for a voltage."
_LACKS: Final = "there is no {} without ROS; use ComputePathToPose and FollowPath"
_WITHOUT: Final[Mapping[str, tuple[type[_WithoutRos], int, str, Mapping[str, Any]]]] = {
    "ReinitializeGlobalLocalization": (_NoService, 0, "the robot's localisation is not started again here", {}),
    "ToggleCollisionMonitor": (
        _NoService,
        0,
        "the robot's reflexes stay on, whatever the value of `enable`",
        {"enable": port_of(bool, "whether Nav2's collision monitor is on; for a running Nav2 only", default=True)},
    ),
    "IsBatteryCharging": (BatteryCondition, 0, BatteryCondition.why, {}),
    "NavigateToPose": (
        _NoServer,
        9001,
        _LACKS.format("navigator"),
        {"goal": port_of(PoseText, "goal", default="{goal}"), **_TREE},
    ),
    "NavigateThroughPoses": (
        _NoServer,
        9101,
        _LACKS.format("navigator"),
        {"goals": port_of(PosesText, "goals", default="{goals}"), **_TREE},
    ),
    "DockRobot": (_NoServer, 999, _LACKS.format("docking server"), _DOCK),
    "UndockRobot": (_NoServer, 999, _LACKS.format("docking server"), _UNDOCK),
    "FollowObject": (
        _NoServer,
        902,
        "no object is detected: there is no topic with its pose here; use FollowRobot",
        {
            "pose_topic": port_of(str, "topic; for a running Nav2 only", default="dynamic_pose"),
            "max_duration": port_of(float, "maximum duration in Nav2 [s]; for a running Nav2 only", default=0.0),
            "tracked_frame": port_of(str, "frame; for a running Nav2 only", default=""),
            "total_elapsed_time": port_of(float, "for a running Nav2 only", Direction.OUTPUT),
        },
    ),
}


def table_nodes() -> Iterator[type[Node]]:
    """Create the nodes of this module."""
    for camel in _SELECTED:
        what = re.sub(r"(?<=.)([A-Z])", r"_\1", camel).lower()
        ports: Mapping[str, Any] = {
            f"default_{what}": port_of(str, f"name of the {what.replace('_', ' ')}", default=""),
            f"selected_{what}": port_of(str, "the same", Direction.OUTPUT),
            "what": what,
        }
        yield made_node(f"{camel}Selector", Selector, f"Writes `default_{what}` to `selected_{what}`.", ports)
    for camel, (nodes, codes) in _HELPED.items():
        doc = f"SUCCESS if a recovery may help after this error code of {nodes}."
        yield made_node(f"WouldA{camel}RecoveryHelp", _WouldHelp, doc, {"helped": codes})
    for tag, (doc, ports) in _CLEARED.items():
        yield made_node(tag, _Clear, doc, ports)
    yield made_node("IsBatteryLow", _BatteryLow, _LOW, {})
    for tag, (without, code, why, ports) in _WITHOUT.items():
        doc = f"{without.outcome.name}{f' with the code {code}' if code else ''}: {why}."
        yield made_node(tag, without, doc, {"code": code, "why": why, **ports})


def made_node(tag: str, base: type[Node], doc: str, members: Mapping[str, Any], module: str = __name__) -> type[Node]:
    """Create a node class from a row of a table."""
    return type(tag, (base,), {**members, "tag": tag, "__doc__": doc, "__module__": module})
