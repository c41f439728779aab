"""Action nodes of XML missions, one class for each action: `<GoTo goal="dock" cruise="0.5 m/s"/>`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar

from py_trees.common import Status

from ..base.errors import Fault
from ..base.units import NONE
from ..declare import Field
from ..interfaces.action import Action, make_action, misfits_of, parameters_of
from ..trees.nodes import Leaf
from .act import MAX_PREEMPTIONS, Act
from .context import MissionContext, mission_of


class ActionNode(Act):
    """Base class of tree nodes that execute an action of the robot; `action_nodes` creates the classes.

    The ports are the action's parameters. They are read when the action is submitted, and again when it is submitted
    after a reflex. Parameters that the action declares as live are read in each tick. A port that is omitted takes the
    action's default.

    Attributes:
        action: Name of the action in the action table.
    """

    action: ClassVar[str] = ""
    max_preemptions: Annotated[int, "maximum number of reflexes without progress"] = MAX_PREEMPTIONS

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        Leaf.__init__(self, name, **attributes)
        self._set_up(self._made, MAX_PREEMPTIONS)
        self._submitted: Mapping[str, Any] = {}

    def initialise(self) -> None:
        self._max_preemptions = self.read("max_preemptions")
        super().initialise()

    def update(self) -> Status:
        ticket = self.ticket
        if ticket is not None and not ticket.state.done:
            for port in ticket.action.live:
                if port in self.given and (value := self.read(port)) is not self._submitted.get(port):
                    self._submitted = {**self._submitted, port: value}
                    self.mission.pipeline.update(ticket, {port: value})
        return super().update()

    def begins_running(self) -> bool:
        return True

    def written(self) -> None:
        """Write the node's own tag and ports, because a document can contain it."""

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        mission = self.runtime.owner
        if not (isinstance(mission, MissionContext) and mission.fit and self.action in mission.actions):
            return
        known = {n: self.read(n) for n in self.given if n != "max_preemptions" and self.key(n) is None}
        for name, reason in misfits_of(mission.actions[self.action], known, mission.knowledge):
            yield name, Fault(f"{reason}.")

    @property
    def mission(self) -> MissionContext:
        return mission_of(self)

    def _made(self) -> Action:
        actions = self.mission.actions
        parameters = {port: self.read(port) for port in self.given if port != "max_preemptions"}
        self._submitted = parameters
        return make_action(actions, self.action, parameters)


def action_nodes(actions: Mapping[str, type[Action]]) -> list[type[ActionNode]]:
    """Create a node class for each action of a table. The class has the action's name, and its parameters as ports."""
    return [_node(name, action) for name, action in sorted(actions.items())]


def _node(name: str, action: type[Action]) -> type[ActionNode]:
    ports = {each.name: _in_files(each) for each in parameters_of(action).values() if each.is_plain}
    members: dict[str, Any] = {"action": name, "tag": name, "__doc__": action.__doc__, "__module__": action.__module__}
    return type(name, (ActionNode,), {**ports, **members})


def _in_files(each: Field) -> Field:
    """The parameter as a port: its numbers are quantities, also those without a unit, such as `50 %`."""
    return replace(each, marks=(NONE, *each.marks)) if each.dimension == NONE else each
