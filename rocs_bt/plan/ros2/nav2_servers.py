"""Nodes that call the action servers of a running Nav2, with the names and ports of Nav2's own nodes.

They are available with `nodes = "nav2_servers"`. The nodes of `rocs_bt.plan.nav2` (`nodes = "nav2"`) have the same
names but need no ROS: they use the planners and actions of rocs_bt.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from ...action import Failure
from ...errors import Fault, InputError, unknown
from ...pipeline import Priority, Ticket, TicketState
from ...ros_link import RosActionClient, RosGoal, RosLink, RosSubscription
from ...trees.nodes import RUNNING, Input, Outcome, Output
from ..nav2.lenient import Lenient
from ..nav2.poses import PoseInput, PosesInput, list_of, poses_of
from .action import GoalLeaf
from .assignments import FieldOutputs
from .fields import duration, message, primitive, seconds
from .nav2_messages import corners_of, path_message, stamped
from .relay_twist import TWISTS, RelayTwist
from .uses_ros import interface_type, parse_name

NOT_SENT = 2
"""Error code of a goal that was not sent: SEND_GOAL_FAILURE since Lyrical."""


class Nav2Action(Lenient, GoalLeaf):
    """Base of nodes that call an action server of Nav2.

    The fields of a goal that the installed nav2_msgs does not have are omitted, because they differ between the
    distributions of ROS 2. Poses are names of places in the world model, or texts of a PoseStamped, in the frame of the
    port `frame`.

    Attributes:
        type: Type of the action.
    """

    type: ClassVar[str] = ""
    named = "server_name"
    parts = {"feedback": "_Feedback", "result": "_Result"}  # noqa: RUF012 - a table of the class

    server_name = Input(str, doc="name of the action", parse=parse_name)
    feedback = FieldOutputs("keys for fields of the feedback: path -> {key}")
    result = FieldOutputs("keys for fields of the result: path -> {key}")
    frame = Input(str, "map", "frame of the poses")
    server_timeout = Input(float, 0.0, "maximum time until the server accepts the goal [ms], at least 1 s; 0: 5 s")
    error_code_id = Output(int, "error code of nav2_msgs, 0 for none")
    error_msg = Output(str, "error message")

    def fields(self) -> dict[str, Any]:
        """Fields of the goal, as plain values.

        Raises:
            InputError: A place is not known.
        """
        raise NotImplementedError

    def names(self) -> tuple[str, str]:
        return self._name("server_name"), self.type

    @property
    def acknowledgement(self) -> float:
        # Nav2 gives 10 or 20 ms; an agent that ticks at 20 Hz on a loaded computer cannot judge that.
        return max(self.server_timeout * 1e-3, 1.0) if self.server_timeout else 5.0

    def initialise(self) -> None:
        self.error_code_id, self.error_msg = 0, ""
        super().initialise()

    def message(self) -> dict[str, Any]:
        types = self.link.types if self.link is not None else None
        known = None if types is None else types.fields(f"{self.type}_Goal")
        if types is None or known is None:
            raise InputError(Fault(f"the fields of {self.type} are not known here.", hint="Install nav2_msgs."))
        given = {name: value for name, value in self.fields().items() if name in known}
        return message(types, f"{self.type}_Goal", [((), given)])

    def on_feedback(self, goal: RosGoal) -> str:
        return self.put("feedback", goal.feedback)

    def on_result(self, goal: RosGoal) -> str:
        self.error_code_id, self.error_msg = self._error(goal)
        return self.put("result", goal.result)

    def detail(self, goal: RosGoal) -> str:
        code, text = self._error(goal)
        shown = ": ".join(filter(None, (f"error code {code}" if code else "", text)))
        return f" ({shown})" if shown else ""

    def failed(self, failure: Failure) -> Outcome:
        if self._goal is None:  # no server has given a code
            self.error_code_id, self.error_msg = NOT_SENT, str(failure)
        return super().failed(failure)

    def stamped(self, value: Any) -> dict[str, Any]:
        """PoseStamped of a place, in the frame of the port; see `nav2_messages.stamped`."""
        return stamped(self, value)

    def array(self, name: str, poses: list[dict[str, Any]]) -> Any:
        """Poses as a field of the installed nav2_msgs: an array, or a message that contains it."""
        types = None if self.link is None else self.link.types
        field = None if types is None else (types.fields(f"{self.type}_Goal") or {}).get(name)
        if types is None or field is None or field.array:
            return poses
        inner = types.fields(field.type) or {}
        name = next((n for n, f in inner.items() if f.array and not primitive(f)), "poses")
        return {"header": {"frame_id": self.frame}, name: poses}

    def put_result(self, goal: RosGoal, *names: str) -> None:
        """Write fields of the result to the ports of the same names, durations in seconds."""
        for name in names:
            try:
                value = None if goal.result is None else goal.result.get((name,))
            except LookupError:
                continue
            if value is not None:
                self.write(name, seconds(value) if isinstance(value, Mapping) and "nanosec" in value else value)

    def _error(self, goal: RosGoal) -> tuple[int, str]:
        found = []
        for name, default in (("error_code", 0), ("error_msg", "")):
            try:
                found.append(default if goal.result is None else goal.result.get((name,)))
            except LookupError:
                found.append(default)
        return int(found[0]), str(found[1])


def _parse_topic(text: str) -> str:
    return parse_name(text) if text.strip() else ""


def _parse_twist(text: str) -> str:
    if (type := interface_type("msg")(text)) not in TWISTS:
        raise InputError(unknown("type of twists", type, TWISTS))
    return type


class Nav2Motion(Nav2Action):
    """Base of nodes with which Nav2 moves the robot. Reflexes of the robot have priority: they cancel the goal.

    With `cmd_vel`, Nav2's commands pass the agent's safety gate: an action of the agent passes on the twists of that
    topic while the goal is pursued, and a reflex pre-empts that action like any other. While the safety gate holds the
    robot, as in an emergency stop, the goal is always cancelled, and sent again after the release.
    """

    cmd_vel = Input(str, "", "topic with Nav2's commands, for the agent to pass on; none if empty", parse=_parse_topic)
    cmd_vel_type = Input(str, "geometry_msgs/msg/TwistStamped", "type of that topic", parse=_parse_twist)
    cancel_on_reflex = Input(bool, True, "whether the goal is cancelled during a reflex, and sent again afterwards")

    _commands: RosSubscription | None = None
    _relay: Ticket | None = None

    @property
    def interruption(self) -> str:
        return super().interruption or self.held()

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        yield from super().bound_faults()
        if self.key("cmd_vel") is None and not self.cmd_vel:
            hint = (
                "Give it cmd_vel, the topic with Nav2's commands: if the agent is killed, Nav2 drives on "
                "(docs/ros2-missions.md)."
            )
            yield "", Fault("Nav2 commands the base past the safety gate.", hint=hint, warning=True)

    def connect(self, link: RosLink, name: str, type: str) -> RosActionClient:
        if self.cmd_vel and self._commands is None:
            self._commands = link.subscription(self.cmd_vel, self.cmd_vel_type, "reliable")
        return super().connect(link, name, type)

    def shutdown(self) -> None:
        super().shutdown()
        if self._commands is not None:
            self._commands.close()
            self._commands = None

    def update(self) -> Outcome:
        outcome = super().update()
        if outcome is not RUNNING or self._commands is None:
            return outcome
        if not self.pursued:
            self._end_relay()
        elif (failure := self._relayed(self._commands)) is not None:
            return self.failed(failure)
        return RUNNING

    def terminate(self, new_status: Outcome) -> None:
        self._end_relay()
        super().terminate(new_status)

    def _relayed(self, commands: RosSubscription) -> Failure | None:
        """Keep the action that passes on Nav2's commands; returns the reason if it has failed."""
        mission, ticket = self.mission, self._relay
        if mission is None or (ticket is not None and not ticket.state.done):
            return None
        if ticket is not None and ticket.state is TicketState.FAILED:
            return ticket.failure
        if not mission.pipeline.held:
            action = RelayTwist.of(commands, self.cmd_vel_type)
            self._relay = mission.pipeline.submit(action, Priority.NORMAL, by=mission.path(self))
        return None

    def _end_relay(self) -> None:
        if self._relay is not None and self.mission is not None:
            self.mission.pipeline.cancel(self._relay, by=self.mission.path(self))
        self._relay = None


class NavigateToPose(Nav2Motion):
    """Drives to a goal with Nav2's navigator."""

    type = "nav2_msgs/action/NavigateToPose"
    server_name = Input(str, "navigate_to_pose", "name of the action", parse=parse_name)
    goal = PoseInput("{goal}", "goal: name of a place, or text of a PoseStamped")
    behavior_tree = Input(str, "", "file of a behaviour tree of Nav2; its default if empty")

    def fields(self) -> dict[str, Any]:
        return {"pose": self.stamped(self.goal), "behavior_tree": self.behavior_tree}


class NavigateThroughPoses(Nav2Motion):
    """Drives to several goals in order with Nav2's navigator."""

    type = "nav2_msgs/action/NavigateThroughPoses"
    server_name = Input(str, "navigate_through_poses", "name of the action", parse=parse_name)
    goals = PosesInput("{goals}", "goals, separated by ;")
    behavior_tree = Input(str, "", "file of a behaviour tree of Nav2; its default if empty")

    def fields(self) -> dict[str, Any]:
        if self.mission is None:
            raise InputError("the node has no mission.")
        value = self.goals
        given = value if isinstance(value, (list, tuple)) else poses_of(self.mission, value)
        poses = [self.stamped(each) for each in given]
        return {"poses": self.array("poses", poses), "behavior_tree": self.behavior_tree}


class ComputePathToPose(Nav2Action):
    """Computes a path with Nav2's planner server."""

    type = "nav2_msgs/action/ComputePathToPose"
    server_name = Input(str, "compute_path_to_pose", "name of the action", parse=parse_name)
    goal = PoseInput("{goal}", "goal: name of a place, or text of a PoseStamped")
    start = PoseInput("", "start; the robot's pose if empty")
    use_start = Input(bool, True, "whether to use `start` if given")
    viapoints = PosesInput(None, "poses that the path should pass")
    planner_id = Input(str, "", "name of a planner of Nav2; its default if empty")
    path = Output(object, "path, as nav_msgs/Path")
    corners = Output(list, "path as corners, (x, y) in `frame` [m], for actions such as FollowRoute")

    def fields(self) -> dict[str, Any]:
        start, via = self.start, list_of(self.viapoints)
        use = bool(self.use_start and start)
        found = {"goal": self.stamped(self.goal), "planner_id": self.planner_id, "use_start": use}
        if via:
            found["viapoints"] = [self.stamped(each) for each in via]
        return {**found, "start": self.stamped(start)} if use else found

    def failed(self, failure: Failure) -> Outcome:
        self.path = {}
        return super().failed(failure)

    def on_result(self, goal: RosGoal) -> str:
        if goal.result is not None:
            path = goal.result.get(("path",))
            self.path, self.corners = path, corners_of(path)
        return super().on_result(goal)


class FollowPath(Nav2Motion):
    """Follows a path with Nav2's controller server."""

    type = "nav2_msgs/action/FollowPath"
    server_name = Input(str, "follow_path", "name of the action", parse=parse_name)
    path = Input(object, "{path}", "path: a nav_msgs/Path, or corners, (x, y) in `frame` [m]")
    controller_id = Input(str, "", "name of a controller of Nav2; its default if empty")
    goal_checker_id = Input(str, "", "name of a goal checker of Nav2; its default if empty")
    progress_checker_id = Input(str, "", "name of a progress checker of Nav2; its default if empty")
    path_handler_id = Input(str, "", "name of a path handler of Nav2; its default if empty")
    tracking_feedback = Output(object, "plain values of nav2_msgs/TrackingFeedback, while the robot drives")

    def on_feedback(self, goal: RosGoal) -> str:
        try:
            if goal.feedback is not None:
                self.tracking_feedback = goal.feedback.get(("tracking_feedback",))
        except LookupError:  # before Lyrical there is no such field
            pass
        return super().on_feedback(goal)

    def fields(self) -> dict[str, Any]:
        names = ("controller_id", "goal_checker_id", "progress_checker_id", "path_handler_id")
        return {"path": path_message(self.path, self.frame), **{name: self.read(name) for name in names}}


class _Behavior(Nav2Motion):
    """Base of nodes for Nav2's behavior server."""

    time_allowance = Input(float, 10.0, "maximum duration [s]")
    disable_collision_checks = Input(bool, False, "whether Nav2 does not check for collisions")

    def fields(self) -> dict[str, Any]:
        allowed = duration(self.time_allowance)
        return {"time_allowance": allowed, "disable_collision_checks": self.disable_collision_checks}


class Spin(_Behavior):
    """Turns on the spot with Nav2's behavior server."""

    type = "nav2_msgs/action/Spin"
    server_name = Input(str, "spin", "name of the action", parse=parse_name)
    spin_dist = Input(float, 1.57, "angle, left positive [rad]")
    is_recovery = Input(bool, True, "whether Nav2 counts it as a recovery; not used")

    def fields(self) -> dict[str, Any]:
        return {"target_yaw": self.spin_dist, **super().fields()}


class BackUp(_Behavior):
    """Drives backward with Nav2's behavior server."""

    type = "nav2_msgs/action/BackUp"
    server_name = Input(str, "backup", "name of the action", parse=parse_name)
    backup_dist = Input(float, 0.15, "distance [m]")
    backup_speed = Input(float, 0.025, "speed [m/s]")

    def fields(self) -> dict[str, Any]:
        return {"target": {"x": self.backup_dist}, "speed": self.backup_speed, **super().fields()}


class DriveOnHeading(_Behavior):
    """Drives straight with Nav2's behavior server."""

    type = "nav2_msgs/action/DriveOnHeading"
    server_name = Input(str, "drive_on_heading", "name of the action", parse=parse_name)
    dist_to_travel = Input(float, 0.15, "distance [m]")
    speed = Input(float, 0.025, "speed [m/s]")

    def fields(self) -> dict[str, Any]:
        return {"target": {"x": self.dist_to_travel}, "speed": self.speed, **super().fields()}


class Wait(Nav2Action):
    """Waits with Nav2's behavior server."""

    type = "nav2_msgs/action/Wait"
    server_name = Input(str, "wait", "name of the action", parse=parse_name)
    wait_duration = Input(float, 1.0, "duration [s]")

    def fields(self) -> dict[str, Any]:
        return {"time": duration(self.wait_duration)}


class DockRobot(Nav2Motion):
    """Docks with Nav2's docking server."""

    type = "nav2_msgs/action/DockRobot"
    server_name = Input(str, "dock_robot", "name of the action", parse=parse_name)
    use_dock_id = Input(bool, True, "whether the dock is given by its name in Nav2's database, not by its pose")
    dock_id = Input(str, "", "name of the dock in Nav2's database")
    dock_pose = PoseInput("", "pose of the dock: name of a place, or text of a PoseStamped")
    dock_type = Input(str, "", "plugin of Nav2 for this kind of dock")
    max_staging_time = Input(float, 1000.0, "maximum duration of the drive to the dock's staging pose [s]")
    navigate_to_staging_pose = Input(bool, True, "whether the robot first drives to the dock's staging pose")
    success = Output(bool, "whether the robot is docked")
    num_retries = Output(int, "number of further attempts")

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "success", "num_retries")
        return super().on_result(goal)

    def fields(self) -> dict[str, Any]:
        names = ("use_dock_id", "dock_id", "dock_type", "max_staging_time", "navigate_to_staging_pose")
        found = {name: self.read(name) for name in names}
        return found if self.dock_pose == "" else {**found, "dock_pose": self.stamped(self.dock_pose)}


class UndockRobot(Nav2Motion):
    """Undocks with Nav2's docking server."""

    type = "nav2_msgs/action/UndockRobot"
    server_name = Input(str, "undock_robot", "name of the action", parse=parse_name)
    dock_type = Input(str, "", "plugin of Nav2 for this kind of dock")
    max_undocking_time = Input(float, 30.0, "maximum duration [s]")
    success = Output(bool, "whether the robot is undocked")

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "success")
        return super().on_result(goal)

    def fields(self) -> dict[str, Any]:
        return {"dock_type": self.dock_type, "max_undocking_time": self.max_undocking_time}
