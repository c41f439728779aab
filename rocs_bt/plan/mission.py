"""Mission: argument of `build` in a mission file, which creates leaves with it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from py_trees.behaviour import Behaviour

from ..actions.heading import looked_at
from ..base.errors import Fault, InputError, unknown
from ..base.raised import CodeLocation, called_at
from ..base.units import NONE, NOT_NEGATIVE, TIME, convert
from ..declare import Field, read_fields
from ..interfaces.action import make_action, parameters_of, refuse_misfits
from ..knowledge import WorldModel
from ..trees.nodes import Node, Registry, SubTree
from .act import MAX_PREEMPTIONS, Act
from .context import MissionContext, Position, SignalCondition
from .leaves import Condition, Enter, Wait
from .xml_mission import embedded, mission_nodes


@dataclass(frozen=True)
class MissionLine:
    """Origin of a node in a Python mission: the source line that created it.

    The origin of a node in an XML mission is an `Element` instead.
    """

    location: CodeLocation

    @classmethod
    def here(cls) -> MissionLine | None:
        """Origin for the line of a mission that is being executed; None if no line of user content is."""
        location = called_at()
        return None if location is None else cls(location)

    def fault(
        self, message: str, hint: str = "", *, attribute: str = "", column: int | None = None, warning: bool = False
    ) -> Fault:
        """Create a fault at this line; `attribute` and `column` are ignored, as a line has neither."""
        return Fault(message, self.location.file, self.location.line, hint=hint, warning=warning)


def named_place(parameter: str, value: object) -> str:
    """Node of which an action needs the pose: its `goal`, or the place in `heading = "look_at PLACE"`; else empty."""
    if not isinstance(value, str):
        return ""
    if parameter == "heading":
        return looked_at(value)
    return value if parameter == "goal" else ""


def unknown_goal(world: WorldModel, action: str, goal: str, later: Collection[str] | None) -> Fault | None:
    """Check that the goal of an action has a known pose at the beginning of the run.

    No fault is returned if the robot knows no place at all.

    Args:
        world: World model at the beginning of the run.
        action: Name of the action.
        goal: Name of the action's goal.
        later: Names of nodes that may become known during the run; None if any node may. An unknown goal is an error if
            it is not among them, else a warning.

    Returns:
        Fault, or None if the goal is known.
    """
    known = [*world.goals(), *world.places(), *world.objects(), *world.peers()]
    if not known or world.pose_of(goal) is not None:
        return None
    if goal in known:
        hint = f"{action} fails unless the position becomes known during the run."
        return Fault(f"the position of '{goal}' is not known at the start.", hint=hint, warning=True)
    if later is not None and goal not in later and not world.graph.has(goal):
        hint = f"{action} cannot reach it. If it becomes known only during the run, declare it in a [[fact]]."
        return unknown("place", goal, known, "The world", hint)
    hint = f"{action} fails unless it becomes known during the run."
    return replace(unknown("place", goal, known, "The world", hint), warning=True)


def unknown_leader(world: WorldModel, action: str, leader: str) -> Fault | None:
    """Warning about a leader that is no other robot; None if it is one, or if no other robot is known."""
    known = world.peers()
    if not known or leader in known:
        return None
    return replace(unknown("other robot", leader, known, "The world", f"{action} fails at once."), warning=True)


L = TypeVar("L", bound=Node)


class Mission(MissionContext):
    """Factory for the leaves of a Python mission, with access to the mission's context (see MissionContext).

    The docstring of a mission file describes the mission; the file defines

        def build(mission: Mission, *, goal: str = "goal", cruise: PositiveMetresPerSecond = 0.5) -> Behaviour:

    which returns a py_trees tree. Its keyword-only parameters are the mission's parameters: scenarios set them, and
    their annotations define units and valid ranges. Composites and decorators are py_trees' own.
    """

    _nodes: Registry | None = None

    def act(self, action: str, /, *, name: str = "", max_preemptions: int = MAX_PREEMPTIONS, **parameters: Any) -> Act:
        """Create a leaf that executes an action.

        Args:
            action: Name in the action table, such as `GoTo`.
            name: Name of the leaf in displays; by default the action and its goal.
            max_preemptions: Maximum number of pre-emptions by reflexes without progress; then the leaf fails.
            parameters: Parameters of the action: SI numbers, or quantities such as `"0.5 m/s"`.

        Raises:
            InputError: The action or a parameter is unknown, a parameter is missing, or a unit or value is wrong.
        """
        given = dict(parameters)
        try:
            given = self._in_si(action, parameters)
            make_action(self.actions, action, given)
            if self.fit:
                refuse_misfits(self.actions[action], given, self.knowledge)
        except InputError as error:
            self._fault(error)
        goal, leader = given.get("goal"), given.get("leader")
        if self.check_options:
            for place in filter(None, (named_place(name, value) for name, value in given.items())):
                later = self.check_options.later
                self._doubt(unknown_goal(self.knowledge.world, action, place, later), place)
        if self.check_options and isinstance(leader, str):
            self._doubt(unknown_leader(self.knowledge.world, action, leader), leader)
        shown = name or (f"{action} {goal}" if isinstance(goal, str) else action)
        return self._made(Act(shown, self, lambda: make_action(self.actions, action, given), max_preemptions))

    def when(self, expression: str, /, *, name: str = "") -> Condition:
        """Create a leaf that succeeds while an expression over the signals is true, such as `min(front) > 0.5 m`.

        Raises:
            InputError: The text is not an expression or names an unknown signal.
        """
        condition: SignalCondition | None = None
        try:
            condition = self.signal_condition(expression)
        except InputError as error:
            self._fault(error)
        leaf = Condition(
            name or expression,
            expression,
            holds=lambda: condition is not None and condition.holds(),
            reading=lambda: "" if condition is None else condition.reading(),
        )
        return self._made(leaf)

    def node(self, tag: str, /, *children: Behaviour, name: str = "", **attributes: Any) -> Node:
        """Create a node by the name of its class in XML files: a built-in node, one of `planners/nodes`, or an action.

            mission.node("Inverter", mission.node("Known", node="dock", _skipIf="blind"))

        Args:
            tag: Name of the node class.
            children: Children, for a control or decorator.
            name: Name of the node in displays; by default the name of its class.
            attributes: Ports, with `"{key}"` for a key of the blackboard, and conditions such as `_skipIf`.

        Raises:
            InputError: The class is unknown, the number of children is wrong, or attributes are faulty.
        """
        if self._nodes is None:
            self._nodes = mission_nodes(self.actions, dialect=self.dialect)
        if tag not in self._nodes:  # if unknown, load all, for the list of names in the error
            self._nodes = self._nodes.with_(self.content.load_nodes({tag}) or self.content.load_nodes())
        given = {port.rstrip("_"): value for port, value in attributes.items()}  # `if_` is the port `if`
        made = self._nodes.make(tag, name or tag, children, given)
        made.origin = MissionLine.here()
        return made

    def enter(self, mode: str, /, *, name: str = "") -> Enter:
        """Create a leaf that sets the agent's mode, such as `dock`. A rule that lists modes is active only in these."""
        return self._made(Enter(name or f"enter {mode}", mode, self.knowledge))

    def wait(self, duration: float | str, /, *, name: str = "") -> Wait:
        """Create a leaf that waits, on the agent's clock.

        Args:
            duration: Seconds, or a quantity such as `"2 s"`.
            name: Name of the leaf in displays.

        Raises:
            InputError: The duration is not a time, or is negative.
        """
        seconds = 0.0
        try:
            seconds = convert(duration, TIME, "wait") if isinstance(duration, str) else float(duration)
            if not NOT_NEGATIVE.admit(seconds):
                raise InputError(f"wait must be {NOT_NEGATIVE}, found {seconds:g} s.")
        except InputError as error:
            self._fault(error)
        return self._made(Wait(name or f"wait {seconds:g} s", seconds, self.clock))

    def tree(
        self, source: Path | str, /, *, main: str = "", nodes: Sequence[type[Node]] = (), **values: Any
    ) -> SubTree:
        """Load an XML tree as part of a Python mission.

            mission.tree(Path(__file__).with_name("dock.xml"), goal="dock", speed="{cruise}")

        Args:
            source: Path of a file, text of a document, or name of a mission in XML, such as `navigate`.
            main: ID of the tree; the document's main tree by default.
            nodes: Node classes in addition to the robot's actions, the nodes of `planners/nodes`, and the nodes of the
                scenario's dialect.
            values: Values of blackboard keys of the tree, or `"{key}"` to refer to a key of the mission's blackboard.

        Raises:
            InputError: The document has errors; the exception lists all of them, each with its line and column.
        """
        return embedded(self, source, nodes, main, values)

    def _made(self, leaf: L) -> L:
        """Record a new leaf and the source line of the mission that created it; returns the leaf."""
        leaf.origin = MissionLine.here()
        self.leaves.append(leaf)
        return leaf

    def _in_si(self, action: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
        declared = parameters_of(self.actions[action]) if action in self.actions else {}
        numbers = [replace(e, key=f"{n} of {action}") for n, e in declared.items() if e.dimension is not None]
        texts = {e.key: _in_file(e, parameters[e.name]) for e in numbers if _has_text(parameters.get(e.name))}
        return {**parameters, **read_fields(numbers, texts, f"the action {action}")}

    def _doubt(self, fault: Fault | None, about: str) -> None:
        if fault is not None:
            self._warn(fault, about=about)

    def _fault(self, error: InputError) -> None:
        """Raise faults, or collect them if the mission is being checked.

        Columns are removed, because they refer to an expression and not to the line of the mission.
        """
        faults = [replace(fault, column=0) if fault.file is None else fault for fault in error.faults]
        if not self.check_options:
            raise type(error)(*faults) from error
        self._warn(*faults)

    def _warn(self, *faults: Fault, about: str = "") -> None:
        """Collect faults in a check, located at the line of the mission that is being executed.

        If `about` is the value of a mission parameter, the faults get its position.
        """
        here = called_at()
        at: Position = (here.file, here.line, 0) if here else (None, 0, 0)
        self.faults.extend(fault.at(*self.passed.get(about, at)) for fault in faults)


def _has_text(value: Any) -> bool:
    """Whether a value is a quantity as text, or a list with one."""
    return isinstance(value, str) or (isinstance(value, (list, tuple)) and any(map(_has_text, value)))


def _in_file(each: Field, value: Any) -> Any:
    """Quantities as a file has them; numbers beside them in a list are in SI units."""
    if isinstance(value, (list, tuple)):
        return [_in_file(each, part) for part in value]
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return f"{value!r} {each.dimension}" if is_number and each.dimension != NONE else value
