"""Bases of the nodes that call the action servers of a running Nav2."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from ...base.errors import Fault, InputError, unknown
from ...base.geometry import Twist3
from ...interfaces.action import AtomicAction, Body, Failure, Progress
from ...interfaces.pipeline import Priority, Ticket, TicketState
from ...nav2.lenient import Served
from ...nav2.path import corners_of
from ...trees.nodes import RUNNING, SUCCESS, Outcome, Syntax
from ..ros_link import Received, RosActionClient, RosField, RosGoal, RosLink, RosSubscription, RosTypes
from .action import GoalLeaf
from .assignments import FieldOutputs
from .nav2_messages import Nav2Caller, field_of
from .uses_ros import interface_type, parse_name

NOT_SENT = 2
"""Error code of a goal that was not sent: SEND_GOAL_FAILURE since Lyrical."""


class Nav2Action(Nav2Caller, Served, GoalLeaf):
    """Base of nodes that call an action server of Nav2."""

    named = "server_name"
    parts: ClassVar = {"feedback": "_Feedback", "result": "_Result"}
    emptied: ClassVar[tuple[str, ...]] = ()

    server_name: Annotated[str, Syntax(parse_name), "name of the action"]
    feedback: Annotated[FieldOutputs, "keys for fields of the feedback: path -> {key}"] = ""
    result: Annotated[FieldOutputs, "keys for fields of the result: path -> {key}"] = ""
    server_timeout: Annotated[float, "maximum time until the server accepts the goal [ms], at least 1 s; 0: 5 s"] = 0.0

    @property
    def acknowledgement(self) -> float:
        # Nav2 gives 10 or 20 ms; an agent that ticks at 20 Hz on a loaded computer cannot judge that.
        return max(self.server_timeout * 1e-3, 1.0) if self.server_timeout else 5.0

    def initialise(self) -> None:
        self.put_error()
        super().initialise()

    def message(self) -> dict[str, Any]:
        return self.filled("Goal")

    def on_feedback(self, goal: RosGoal) -> str:
        self.write_fields(goal.feedback)
        return self.put("feedback", goal.feedback)

    def on_result(self, goal: RosGoal) -> str:
        self.write_fields(goal.result)
        self.put_error(*self._error(goal))
        return self.put("result", goal.result)

    def detail(self, goal: RosGoal) -> str:
        code, text = self._error(goal)
        shown = ": ".join(filter(None, (f"error code {code}" if code else "", text)))
        return f" ({shown})" if shown else ""

    def failed(self, failure: Failure) -> Outcome:
        if self._goal is None:  # no server has given a code
            self.put_error(NOT_SENT, str(failure))
        for port in self.emptied:
            self.write(port, {})
        return super().failed(failure)

    def _error(self, goal: RosGoal) -> tuple[int, str]:
        if goal.result is None:
            return 0, ""
        return int(field_of(goal.result, "error_code", 0)), str(field_of(goal.result, "error_msg", ""))


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

    cmd_vel: Annotated[str, Syntax(_parse_topic), "topic with Nav2's commands, to pass on; none if empty"] = ""
    cmd_vel_type: Annotated[str, Syntax(_parse_twist), "type of that topic"] = "geometry_msgs/msg/TwistStamped"
    cancel_on_reflex: Annotated[bool, "whether the goal is cancelled during a reflex, and sent again afterwards"] = True

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


class Planning(Nav2Action):
    """Base of nodes that compute a path; `use_start` says whether the goal contains a start."""

    emptied = ("path",)

    def fields(self, known: Mapping[str, RosField], types: RosTypes) -> dict[str, Any]:
        found = super().fields(known, types)
        found["use_start"] = "start" in found and found.get("use_start", True)
        if not found["use_start"]:
            found.pop("start", None)
        return found

    def on_result(self, goal: RosGoal) -> str:
        if "corners" in self.ports and goal.result is not None:
            self.write("corners", corners_of(field_of(goal.result, "path", {})))
        return super().on_result(goal)


class Routing(Nav2Action):
    """Base of nodes that compute a route, between numbers of nodes or between poses."""

    emptied = ("path", "route")

    def fields(self, known: Mapping[str, RosField], types: RosTypes) -> dict[str, Any]:
        used = {"goal": self.read("use_poses"), "start": self.read("use_poses") and self.read("use_start")}
        return super().fields({name: field for name, field in known.items() if used.get(name, True)}, types)


class Teleop(Nav2Motion):
    """Base of nodes with which a person drives; the end of a goal is SUCCESS unless it is a recovery."""

    def failed(self, failure: Failure) -> Outcome:
        sent, outcome = self._goal is not None, super().failed(failure)
        return SUCCESS if sent and not self.read("is_recovery") else outcome


MAX_AGE = 0.5
"""Maximum age of a twist [s]; the body rests without a newer one, as with ros2_control."""

TWISTS = {"geometry_msgs/msg/Twist": (), "geometry_msgs/msg/TwistStamped": ("twist",)}
"""Path of the twist in each message type."""


class RelayTwist(AtomicAction):
    """Commands the newest twist of a topic each period, until it is cancelled; rests while there is no recent one."""

    _topic: RosSubscription | None = None
    _type: str = ""

    @classmethod
    def of(cls, topic: RosSubscription, type: str) -> RelayTwist:
        """Create the action for a subscription, which only it reads, with messages of one of `TWISTS`."""
        made = cls()
        made._topic, made._type = topic, type
        return made

    def act(self, body: Body) -> Progress | Failure:
        newest = None if self._topic is None else self._topic.newest()
        twist = None if newest is None or newest.age > MAX_AGE else self._twist(newest)
        if twist is None:
            body.rest()
        else:
            body.move(twist)
        return Progress.RUNNING

    def _twist(self, received: Received) -> Twist3 | None:
        """Twist of a message; None if it is not finite."""
        values = received.message.get(TWISTS[self._type])
        linear, angular = values["linear"], values["angular"]
        numbers = (linear["x"], linear["y"], linear["z"], angular["z"])
        return Twist3(*map(float, numbers)) if all(map(math.isfinite, numbers)) else None
