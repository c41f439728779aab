"""RosActionServer: a part of a mission that other programs start as a ROS 2 action."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from ...base.errors import InputError
from ...interfaces.action import Failure
from ...trees.nodes import FAILURE, RUNNING, SKIPPED, SUCCESS, Decorator, Outcome, Syntax, halt
from ..ros_link import AcceptedGoal, GoalState, RosLink
from ..ros_link import RosActionServer as Server
from .assignments import FieldInputs, FieldOutputs
from .uses_ros import UsesRos, interface_type, parse_name


class RosActionServer(UsesRos[Server], Decorator):
    """Serves one goal of a ROS 2 action with its child; needs rclpy.

        <RosActionServer action="fetch" type="my_msgs/action/Fetch" goal="shelf -> {shelf}" result="weight = {weight}">
          <SubTree ID="fetch" shelf="{shelf}" weight="{weight}"/>
        </RosActionServer>

    RUNNING until a goal arrives, and while the child is RUNNING. The goal ends as the child does: SUCCESS is succeeded,
    FAILURE is aborted. A goal that its client cancels halts the child and is FAILURE. A halted node aborts its goal.
    Goals are accepted while the node waits; at all other times they are rejected. To serve goals for ever, put the node
    into a Repeat and a ForceSuccess.
    """

    named = "action"
    parts: ClassVar = {"goal": "_Goal", "feedback": "_Feedback", "result": "_Result"}

    action: Annotated[str, Syntax(parse_name), "name of the action"]
    type_: Annotated[str, Syntax(interface_type("action")), "action type"]
    goal: Annotated[FieldOutputs, "keys for fields of the goal: path -> {key}"] = ""
    feedback: Annotated[FieldInputs, "fields of the feedback, published when they change: path = {key}"] = ""
    result: Annotated[FieldInputs, "fields of the result: path = {key}; keys without a value are omitted"] = ""

    _goal: AcceptedGoal | None = None
    _sent: Any = None

    def connect(self, link: RosLink, name: str, type: str) -> Server:
        return link.action_server(name, type)

    def tick_once(self) -> Outcome:
        server = self.opened()
        if isinstance(server, Failure):
            self.status = self.failed(server)
            return self.status
        self.status = RUNNING
        if self._goal is None:
            server.open(True)
            self._goal = server.goal()
            if self._goal is None:
                self.feedback_message = f"waits for a goal of '{self.action}'"
                return RUNNING
            server.open(False)
            self._sent = None
            if missing := self.put("goal", self._goal.request):
                return self._ended(GoalState.ABORTED, missing)
        if self._goal.cancel_requested:
            halt(self.decorated)
            return self._ended(GoalState.CANCELED, "its client cancelled the goal")
        outcome = self.tick_child()
        if outcome is RUNNING:
            self._publish_feedback()
            return RUNNING
        if outcome is SKIPPED:
            halt(self.decorated)
        succeeded = outcome is SUCCESS
        return self._ended(GoalState.SUCCEEDED if succeeded else GoalState.ABORTED, "" if succeeded else self._reason())

    def halted(self) -> None:
        super().halted()
        self._end(GoalState.ABORTED)
        if self._endpoint is not None:
            self._endpoint.open(False)

    def _ended(self, state: GoalState, reason: str) -> Outcome:
        faults = self._end(state)
        self.feedback_message = reason or faults or f"'{self.action}' {state.value}"
        self.status = SUCCESS if state is GoalState.SUCCEEDED and not faults else FAILURE
        return self.status

    def _end(self, state: GoalState) -> str:
        """End the goal; returns the reason why its result could not be made, or an empty text."""
        goal, self._goal = self._goal, None
        if goal is None:
            return ""
        try:
            goal.end(state, self._known("result"))
        except InputError as error:
            goal.end(GoalState.ABORTED, {})
            return str(Failure.cannot(error))
        return ""

    def _publish_feedback(self) -> None:
        self.feedback_message = f"serves a goal of '{self.action}'"
        try:
            values = self._known("feedback")
        except InputError as error:
            self.feedback_message = f"no feedback: {error}"
            return
        if values and values != self._sent and self._goal is not None:
            self._sent = values
            self._goal.feedback(values)

    def _known(self, port: str) -> dict[str, Any]:
        return self.message_of(port, optional=True)

    def _reason(self) -> str:
        tip = self.decorated.tip()
        return "" if tip is None else f"{tip.name}: {tip.feedback_message}".rstrip(": ")
