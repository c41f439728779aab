"""Mission: what a mission file's `build` is given to make its leaves with."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from py_trees.behaviour import Behaviour

from ..action import make_action, parameters_of, refuse_misfits
from ..errors import Fault, InputError, unknown
from ..knowledge import WorldModel
from ..raised import CodeLocation, called_at
from ..trees.nodes import BUILTIN, Node, Registry, SubTree
from ..units import NOT_NEGATIVE, TIME, Dimension, convert
from .act import MAX_PREEMPTIONS, Act
from .action_node import action_nodes
from .context import MissionContext, Question
from .leaves import Condition, Enter, Wait
from .xml_mission import embedded


@dataclass(frozen=True)
class MissionLine:
    """The line of a Python mission that made a node; the counterpart of an element of an XML mission.

    Attributes:
        location: The line.
    """

    location: CodeLocation

    @classmethod
    def here(cls) -> MissionLine | None:
        """The line of content that is being executed; None if none is."""
        location = called_at()
        return None if location is None else cls(location)

    def fault(
        self, message: str, hint: str = "", *, attribute: str = "", column: int | None = None, warning: bool = False
    ) -> Fault:
        """A fault at the line; attribute and column are not used."""
        return Fault(message, self.location.file, self.location.line, hint=hint, warning=warning)


def unseen_goal(world: WorldModel, action: str, goal: str, later: Collection[str] | None) -> Fault | None:
    """The fault of an action whose goal has no pose at the start; None for none.

    Where the robot knows of no place at all, nothing is said.

    Args:
        world: What the robot knows at the start.
        action: The action.
        goal: Its goal.
        later: Nodes that may become known during the run; None where any may. The goal is an error where it is none of
            them, else a warning.
    """
    known = [*world.goals(), *world.places(), *world.objects(), *world.peers()]
    if not known or world.pose_of(goal) is not None:
        return None
    if goal in known:
        hint = f"{action} fails unless it is found on the way."
        return Fault(f"the position of '{goal}' is not known at the start.", hint=hint, warning=True)
    found = unknown("place", goal, known, "The world")
    if later is not None and goal not in later and not world.graph.has(goal):
        hint = f"{action} cannot reach it. If it becomes known only during the run, declare it in a [[fact]]."
        return Fault(found.message, hint=f"{found.hint} {hint}")
    return Fault(found.message, hint=f"{found.hint} {action} fails unless it is found on the way.", warning=True)


L = TypeVar("L", bound=Node)


class Mission(MissionContext):
    """What a mission in Python makes its leaves with; the rest is its context (see MissionContext).

    A mission file says in its docstring what the mission is for, and holds

        def build(mission: Mission, *, goal: str = "goal", cruise: PositiveMetresPerSecond = 0.5) -> Behaviour:

    which returns a py_trees tree. Its keyword-only parameters are the mission's parameters: scenarios set them, and
    their annotations say in which unit, and which numbers make sense. Composites and decorators are py_trees' own.

    """

    _nodes: Registry | None = None

    def act(self, action: str, /, *, name: str = "", max_preemptions: int = MAX_PREEMPTIONS, **parameters: Any) -> Act:
        """A leaf that has an action done.

        Args:
            action: Its name in the action table, such as `GoTo`.
            name: What displays call the leaf; the action and its goal where empty.
            max_preemptions: How many pre-emptions by reflexes without progress are too many.
            parameters: The action's parameters: SI numbers, or quantities such as `"0.5 m/s"`.

        Raises:
            InputError: The action or a parameter does not exist, one is missing, or a unit or a value is wrong.
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
        if self.survey and isinstance(goal, str):
            self._look_for(action, goal)
        if self.survey and isinstance(leader, str):
            self._look_for_robot(action, leader)
        shown = name or (f"{action} {goal}" if isinstance(goal, str) else action)
        return self._made(Act(shown, self, lambda: make_action(self.actions, action, given), max_preemptions))

    def when(self, expression: str, /, *, name: str = "") -> Condition:
        """A leaf that asks an expression over the signals, such as `min(front) > 0.5 m`.

        Raises:
            InputError: It is no expression, or it names no signal.
        """
        question: Question | None = None
        try:
            question = self.ask(expression)
        except InputError as error:
            self._fault(error)
        leaf = Condition(
            name or expression,
            expression,
            holds=lambda: question is not None and question.holds(),
            reading=lambda: "" if question is None else question.reading(),
        )
        return self._made(leaf)

    def node(self, tag: str, /, *children: Behaviour, name: str = "", **attributes: Any) -> Node:
        """A node by the name that XML files call it: a built-in one, one of `planners/nodes`, or an action.

            mission.node("Inverter", mission.node("Known", node="dock", _skipIf="blind"))

        Args:
            tag: Its class's name.
            children: Its children, for a control or a decorator.
            name: What displays call it; the tag where empty.
            attributes: Its ports, `"{key}"` for a key of the board, and conditions such as `_skipIf`.

        Raises:
            InputError: No such node, the wrong number of children, or faulty attributes: all that is wrong.
        """
        if self._nodes is None:
            self._nodes = BUILTIN.with_(action_nodes(self.actions))
        if tag not in self._nodes:  # where nobody has it, all are loaded, to tell what there is
            self._nodes = self._nodes.with_(self.content.load_nodes({tag}) or self.content.load_nodes())
        given = {port.rstrip("_"): value for port, value in attributes.items()}  # `if_` is the port `if`
        made = self._nodes.make(tag, name or tag, children, given)
        made.origin = MissionLine.here()
        return made

    def enter(self, mode: str, /, *, name: str = "") -> Enter:
        """A leaf that puts the agent in another mode, such as `dock`: rules that list modes live in those alone."""
        return self._made(Enter(name or f"enter {mode}", mode, self.knowledge))

    def wait(self, duration: float | str, /, *, name: str = "") -> Wait:
        """A leaf that lets time pass, on the agent's own clock.

        Args:
            duration: Seconds, or a quantity such as `"2 s"`.
            name: What displays call the leaf.

        Raises:
            InputError: It is no time that can be waited for.
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
        """A tree that stands in XML, as a part of a mission in Python.

            mission.tree(Path(__file__).with_name("dock.xml"), goal="dock", speed="{cruise}")

        Args:
            source: A file, or the text of a document.
            main: The ID of the tree; the document's main tree by default.
            nodes: Node classes of one's own that it names; the robot's actions are there anyway.
            values: Values of the tree's keys, or `"{key}"` for a key of the mission's own board.

        Raises:
            InputError: All that is wrong with it, each at its line and column.
        """
        return embedded(self, source, nodes, main, values)

    def _made(self, leaf: L) -> L:
        """Note a new leaf and the line of the mission that made it."""
        leaf.origin = MissionLine.here()
        self.leaves.append(leaf)
        return leaf

    def _in_si(self, action: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
        declared = parameters_of(self.actions[action]) if action in self.actions else {}
        given, faults = dict(parameters), list[Fault]()
        for name, value in parameters.items():
            dimension = declared[name].dimension if name in declared else None
            if dimension is None:
                continue
            try:
                given[name] = _converted(value, dimension, f"{name} of {action}")
            except InputError as error:
                faults.extend(error.faults)
        if faults:
            raise InputError(*faults)
        return given

    def _look_for(self, action: str, goal: str) -> None:
        if (fault := unseen_goal(self.knowledge.world, action, goal, self._later)) is not None:
            self._warn(fault, about=goal)

    def _look_for_robot(self, action: str, leader: str) -> None:
        known = self.knowledge.world.peers()
        if known and leader not in known:
            found = unknown("other robot", leader, known, "The world")
            hint = f"{found.hint} {action} fails at once."
            self._warn(Fault(found.message, hint=hint, warning=True), about=leader)

    def _fault(self, error: InputError) -> None:
        """Raise the faults, or collect them in a survey. Columns that count within an expression are removed."""
        faults = [replace(fault, column=0) if fault.file is None else fault for fault in error.faults]
        if not self.survey:
            raise type(error)(*faults) from error
        self._warn(*faults)

    def _warn(self, *faults: Fault, about: object = None) -> None:
        """Collect faults of a survey, at the line of the mission that is being executed.

        Args:
            faults: The faults.
            about: The value that is wrong; the faults get no line if it is a parameter of the mission.
        """
        here = None if about in self.passed else called_at()
        self.faults.extend(faults if here is None else (fault.at(here.file, here.line) for fault in faults))


def _converted(value: Any, dimension: Dimension, what: str) -> Any:
    """A value whose quantities, also those in lists, are SI numbers."""
    if isinstance(value, str):
        return convert(value, dimension, what)
    if isinstance(value, (list, tuple)):
        return [_converted(part, dimension, what) for part in value]
    return value
