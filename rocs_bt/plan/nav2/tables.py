"""Nodes of Nav2 that have one shape: selectors, recovery conditions, clearing of costmaps, batteries and others."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final

from ...trees.nodes import FAILURE, SUCCESS, Input, Instant, Node, Outcome, Output
from ..context import mission_of
from .lenient import Lenient, Served, Serviced
from .planning import route_planners
from .poses import PoseInput, PosesInput, known, pose_of, robot_pose


class Selector(Lenient, Instant):
    """Base of nodes that write a name: in Nav2 the last text on a topic, without ROS always the default."""

    what: ClassVar[str] = ""
    _kept = ""

    topic_name = Input(str, "", "topic; for a running Nav2 only")

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

    error_code = Input(int, None, "error code of the node that failed")
    error_codes_to_check = Input(str, "", "port in Nav2's palette; for a running Nav2 only")

    def update(self) -> Outcome:
        return SUCCESS if self.error_code in self.helped else FAILURE


class _Clear(Serviced, Instant):
    """Base of nodes that forget obstacles of the robot's map, and the paths of the route planners.

    What the scanner sees, and what is outside of its field of view, stays: the robot's rules read the same map.
    """

    around_pose: ClassVar[bool] = False
    outside: ClassVar[bool] = False

    plugins = Input(object, None, "layers of the costmap; for a running Nav2 only")

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


class _Nothing(Serviced, Instant):
    def update(self) -> Outcome:
        return SUCCESS


class Battery(Lenient, Instant):
    """Base of conditions on the state of a battery; FAILURE without ROS."""

    kind = "Condition"
    battery_topic = Input(str, "/battery_status", "topic; for a running Nav2 only")

    def update(self) -> Outcome:
        return FAILURE


class _Unavailable(Served, Instant):
    """Base of nodes that cannot work here and fail with an error code."""

    code: ClassVar[int] = 0
    why: ClassVar[str] = ""

    def update(self) -> Outcome:
        self.put_error(self.code, self.why)
        self.feedback_message = self.why
        return FAILURE


_RESET = {"reset_distance": Input(float, 1.0, "diameter of the region [m]; in Nav2 the side of a square")}
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
        {**_RESET, "pose": PoseInput(None, "centre of the region"), "around_pose": True},
    ),
}
_NO_BATTERY = "FAILURE: the robots of the simulator have no battery, as if no message had arrived."
_TREE = {"behavior_tree": Input(str, "", "file of a behaviour tree; for a running Nav2 only")}
_UNDOCK = {
    "dock_type": Input(str, "", "plugin; for a running Nav2 only"),
    "max_undocking_time": Input(float, 30.0, "maximum duration in Nav2 [s]; for a running Nav2 only"),
    "success": Output(bool, "for a running Nav2 only"),
}
_DOCK = {
    "use_dock_id": Input(bool, True, "whether the dock is given by its name, not its pose; for a running Nav2 only"),
    "dock_id": Input(str, "", "name of the dock; for a running Nav2 only"),
    "dock_pose": PoseInput(None, "pose of the dock; for a running Nav2 only"),
    "dock_type": Input(str, "", "plugin; for a running Nav2 only"),
    "max_staging_time": Input(float, 1000.0, "maximum duration in Nav2 [s]; for a running Nav2 only"),
    "navigate_to_staging_pose": Input(bool, True, "whether to drive to the staging pose; for a running Nav2 only"),
    "success": Output(bool, "for a running Nav2 only"),
    "num_retries": Output(int, "for a running Nav2 only"),
}
_OTHERS: Final[Mapping[str, tuple[type[Node], str, Mapping[str, Any]]]] = {
    "ReinitializeGlobalLocalization": (_Nothing, "SUCCESS: the robot's localisation is not started again here.", {}),
    "ToggleCollisionMonitor": (
        _Nothing,
        "SUCCESS: the robot's reflexes stay on, whatever the value of `enable`.",
        {"enable": Input(bool, True, "whether Nav2's collision monitor is on; for a running Nav2 only")},
    ),
    "IsBatteryLow": (
        Battery,
        _NO_BATTERY,
        {
            "min_battery": Input(float, 0.0, "threshold; for a running Nav2 only"),
            "is_voltage": Input(bool, False, "whether the threshold is a voltage; for a running Nav2 only"),
        },
    ),
    "IsBatteryCharging": (Battery, _NO_BATTERY, {}),
    **{
        tag: (
            _Unavailable,
            f"FAILURE with the code {code}: there is no {what} here; with `nav2_servers` it calls that of Nav2.",
            {"code": code, "why": f"there is no {what} without ROS; use ComputePathToPose and FollowPath", **ports},
        )
        for tag, code, what, ports in (
            ("NavigateToPose", 9001, "navigator", {"goal": PoseInput("{goal}", "goal"), **_TREE}),
            ("NavigateThroughPoses", 9101, "navigator", {"goals": PosesInput("{goals}", "goals"), **_TREE}),
            ("DockRobot", 999, "docking server", _DOCK),
            ("UndockRobot", 999, "docking server", _UNDOCK),
        )
    },
    "FollowObject": (
        _Unavailable,
        "FAILURE with the code 902 (FAILED_TO_DETECT_OBJECT): there is no topic with the pose of an object here.",
        {
            "code": 902,
            "why": "no object is detected: there is no topic with its pose here; use FollowRobot",
            "pose_topic": Input(str, "dynamic_pose", "topic; for a running Nav2 only"),
            "max_duration": Input(float, 0.0, "maximum duration in Nav2 [s]; for a running Nav2 only"),
            "tracked_frame": Input(str, "", "frame; for a running Nav2 only"),
            "total_elapsed_time": Output(float, "for a running Nav2 only"),
        },
    ),
}


def table_nodes() -> Iterator[type[Node]]:
    """Create the nodes of this module."""
    for camel in _SELECTED:
        what = re.sub(r"(?<=.)([A-Z])", r"_\1", camel).lower()
        ports: Mapping[str, Any] = {
            f"default_{what}": Input(str, "", f"name of the {what.replace('_', ' ')}"),
            f"selected_{what}": Output(str, "the same"),
            "what": what,
        }
        yield made_node(f"{camel}Selector", Selector, f"Writes `default_{what}` to `selected_{what}`.", ports)
    for camel, (nodes, codes) in _HELPED.items():
        doc = f"SUCCESS if a recovery may help after this error code of {nodes}."
        yield made_node(f"WouldA{camel}RecoveryHelp", _WouldHelp, doc, {"helped": codes})
    for tag, (doc, ports) in _CLEARED.items():
        yield made_node(tag, _Clear, doc, ports)
    for tag, (base, doc, members) in _OTHERS.items():
        yield made_node(tag, base, doc, members)


def made_node(tag: str, base: type[Node], doc: str, members: Mapping[str, Any], module: str = __name__) -> type[Node]:
    """Create a node class from a row of a table.

    Args:
        tag: Name of the class.
        base: Base class.
        doc: Docstring.
        members: Ports and other attributes.
        module: Module that defines the row.
    """
    return type(tag, (base,), {**members, "tag": tag, "__doc__": doc, "__module__": module})
