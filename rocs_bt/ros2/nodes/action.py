"""RosAction: goal of a ROS 2 action."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar

from ...base.errors import DeviceError, InputError
from ...base.units import TimeLimit
from ...interfaces.action import Failure, Reason
from ...trees.nodes import RUNNING, SUCCESS, Leaf, Outcome, Syntax
from ..ros_link import GoalState, RosActionClient, RosGoal, RosLink
from .assignments import FieldInputs, FieldOutputs
from .uses_ros import FOREVER, UsesRos, interface_type, mismatched, parse_name

GRACE = 2.0
"""Time after which a goal counts as still pursued, if the server has not cancelled it during a reflex [s]."""

LOOK_AGAIN = 0.5
"""Time between two looks whether a server was restarted [s]."""


class GoalLeaf(UsesRos[RosActionClient], Leaf):
    """Base of leaves that send a goal to an action server.

    RUNNING while the goal is pursued, SUCCESS if it succeeds. FAILURE with the reason if it is rejected, aborted or
    cancelled by the server, if no server is there within `wait`, if the goal is not acknowledged within
    `server_timeout`, after `timeout`, without feedback for `feedback_timeout`, or if the server disappears or is
    restarted. A leaf that is halted or has timed out asks the server to cancel the goal, and does not wait for it.
    """

    named = "action"

    wait: Annotated[TimeLimit, "maximum time to wait for a server [s]"] = 5.0
    server_timeout: Annotated[TimeLimit, "maximum time until the server accepts or rejects the goal [s]"] = 5.0
    timeout: Annotated[TimeLimit, "maximum duration of the goal [s]"] = FOREVER
    feedback_timeout: Annotated[TimeLimit, "maximum time between two feedback messages [s]"] = FOREVER
    cancel_on_reflex: Annotated[bool, "whether a reflex or emergency stop cancels the goal; it is sent again"] = False

    _goal: RosGoal | None = None
    _resending = False

    def message(self) -> dict[str, Any]:
        """Fields of the goal.

        Raises:
            InputError: A value is missing or does not fit.
        """
        raise NotImplementedError

    def on_feedback(self, goal: RosGoal) -> str:
        """Write the newest feedback to the keys; returns the reason why it cannot, or an empty text."""
        return ""

    def on_result(self, goal: RosGoal) -> str:
        """Write the result to the keys; returns the reason why it cannot, or an empty text."""
        return ""

    def connect(self, link: RosLink, name: str, type: str) -> RosActionClient:
        return link.action(name, type)

    def initialise(self) -> None:
        self._goal, self._resending, self._count = None, False, 0
        self._begun = self.runtime.now()
        self._heard = self._begun

    def update(self) -> Outcome:
        client = self.opened()
        if isinstance(client, Failure):
            return self.failed(client)
        if self._goal is None:
            return self._send(client)
        goal, name = self._goal, self.names()[0]
        state = goal.state
        missing = self._new_feedback(goal)
        if state.done:
            return self._ended(goal, state, missing)
        if missing:
            return self.failed(Failure(Reason.CANNOT, missing))
        now = self.runtime.now()
        if lost := self._lost(client, now):
            return self.failed(Failure(Reason.UNHEARD, f"the server of '{name}' {lost}"))
        if state is GoalState.SENT and now - self._begun >= self.acknowledgement:
            evidence = f"the server of '{name}' has not acknowledged the goal within {self.acknowledgement:g} s"
            return self.failed(Failure(Reason.TIMEOUT, evidence))
        if now - self._begun >= self.timeout:
            return self.failed(Failure(Reason.TIMEOUT, f"'{name}' is not done after {self.timeout:g} s"))
        if now - self._heard >= self.feedback_timeout:
            evidence = f"no feedback of '{name}' for {self.feedback_timeout:g} s" + mismatched(client)
            return self.failed(Failure(Reason.UNHEARD, evidence))
        interrupted = bool(self.interruption)
        if interrupted and not self._resending:
            self._resending, self._cancelled_at = True, now
            goal.cancel()
        if self._resending and not interrupted and now - self._cancelled_at >= GRACE:
            self._resending = False  # the server has not cancelled the goal, so it is still pursued
        self.feedback_message = f"'{name}': {state.value}"
        return RUNNING

    def terminate(self, new_status: Outcome) -> None:
        if self._goal is not None and not self._goal.state.done:
            self._goal.cancel()
        self._goal = None

    def deadline(self) -> float:
        if self._goal is None:
            return math.inf if self.interruption else self._begun + self.wait
        sent = self._goal.state is GoalState.SENT
        return self._begun + min(self.acknowledgement if sent else math.inf, self.timeout)

    @property
    def acknowledgement(self) -> float:
        """Maximum time until the server accepts or rejects the goal [s]."""
        return float(self.server_timeout)

    @property
    def pursued(self) -> bool:
        """Whether a goal was sent that is not to be cancelled."""
        return self._goal is not None and not self._resending

    @property
    def interruption(self) -> str:
        """Reason for which the goal must not be pursued now: a reflex or a held safety gate; empty if none."""
        if self.mission is None or not self.cancel_on_reflex:
            return ""
        pipeline = self.mission.pipeline
        return f"waits for {pipeline.holder or 'a reflex'}" if pipeline.held else self.held()

    def held(self) -> str:
        """Reason for which the safety gate holds the robot, such as an emergency stop; empty if it does not."""
        reason = "" if self.mission is None else self.mission.motion_held()
        return f"waits: the robot is held ({reason})" if reason else ""

    def _send(self, client: RosActionClient) -> Outcome:
        now, name = self.runtime.now(), self.names()[0]
        if why := self.interruption:
            self._begun = now
            self.feedback_message = f"'{name}' {why}"
            return RUNNING
        if not client.ready():
            if now - self._begun >= self.wait:
                evidence = f"no server of the action '{name}' within {self.wait:g} s" + mismatched(client)
                return self.failed(Failure(Reason.UNHEARD, evidence))
            self.feedback_message = f"waits for a server of '{name}'"
            return RUNNING
        try:
            self._goal = client.send(self.message())
            self._servers, self._looked = dict(client.servers()), now
        except InputError as error:
            return self.failed(Failure.cannot(error))
        except DeviceError as error:
            return self.failed(Failure(Reason.REFUSED, str(error)))
        self._begun = self._heard = now
        self._count, self._resending = 0, False
        self.feedback_message = f"'{name}': goal sent"
        return RUNNING

    def _lost(self, client: RosActionClient, now: float) -> str:
        """What has happened to the server that got the goal; empty if it is still there."""
        if not client.ready():
            return "disappeared"
        if now - self._looked < LOOK_AGAIN:
            return ""
        self._looked, found = now, client.servers()
        known = self._servers = {each: found.get(each) or node for each, node in self._servers.items()}
        if not known or not found:  # not discovered completely
            return ""
        # A killed server is still listed until it expires; its successor has the same node.
        twin = any(node and node in known.values() for each, node in found.items() if each not in known)
        return "was restarted, and has lost the goal" if twin or known.keys().isdisjoint(found) else ""

    def _new_feedback(self, goal: RosGoal) -> str:
        if goal.feedback_count == self._count:
            return ""
        self._count, self._heard = goal.feedback_count, self.runtime.now()
        return self.on_feedback(goal)

    def _ended(self, goal: RosGoal, state: GoalState, missing: str) -> Outcome:
        name = self.names()[0]
        if self._resending and state in (GoalState.CANCELED, GoalState.ABORTED):
            self._goal, self._begun = None, self.runtime.now()
            self.feedback_message = f"'{name}' {self.interruption or 'is sent again'}"
            return RUNNING
        missing = missing or self.on_result(goal)
        if state is GoalState.SUCCEEDED:
            self.feedback_message = f"'{name}' succeeded"
            return self.failed(Failure(Reason.CANNOT, missing)) if missing else SUCCESS
        evidence = {
            GoalState.REJECTED: f"the server of '{name}' rejected the goal",
            GoalState.ABORTED: f"the server of '{name}' aborted the goal",
            GoalState.CANCELED: f"the server of '{name}' cancelled the goal",
        }.get(state, f"'{name}' failed: {goal.error}")
        return self.failed(Failure(Reason.REFUSED, evidence + self.detail(goal)))

    def detail(self, goal: RosGoal) -> str:
        """Text from the result of a goal that did not succeed, for the reason of the failure; may be empty."""
        return ""


class RosAction(GoalLeaf):
    """Sends a goal to an action server and waits for its result; needs rclpy.

        <RosAction action="fibonacci" type="example_interfaces/action/Fibonacci" goal="order = {n}"
                   feedback="sequence -> {partial}" result="sequence -> {sequence}" timeout="10 s"/>

    RUNNING while the goal is pursued, SUCCESS if it succeeds. A halted leaf asks the server to cancel the goal.
    """

    parts: ClassVar = {"goal": "_Goal", "feedback": "_Feedback", "result": "_Result"}

    action: Annotated[str, Syntax(parse_name), "name of the action"]
    type_: Annotated[str, Syntax(interface_type("action")), "action type"]
    goal: Annotated[FieldInputs, "fields of the goal: path = value; path = {key}"] = ""
    feedback: Annotated[FieldOutputs, "keys for fields of the feedback, written when it arrives: path -> {key}"] = ""
    result: Annotated[FieldOutputs, "keys for fields of the result, also if the goal fails: path -> {key}"] = ""

    def message(self) -> dict[str, Any]:
        return self.message_of("goal")

    def on_feedback(self, goal: RosGoal) -> str:
        return self.put("feedback", goal.feedback)

    def on_result(self, goal: RosGoal) -> str:
        return self.put("result", goal.result)
