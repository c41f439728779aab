"""Mission: what a mission file's `build` is given to make its leaves with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from py_trees.behaviour import Behaviour

from ..action import Action, make_action, parameters_of
from ..clock import Clock
from ..errors import Fault, InputError, unknown
from ..event import Event, EventSink
from ..expression import TRUTH, Expression, reading
from ..knowledge import Knowledge
from ..pipeline import Pipeline
from ..units import NOT_NEGATIVE, TIME, convert
from .act import MAX_PREEMPTIONS, Act
from .condition import Condition
from .wait import Wait


class Mission:
    """The context of one agent's mission.

    A mission file says in its docstring what the mission is for, and holds

        def build(mission: Mission, *, goal: str = "goal", cruise: PositiveMetresPerSecond = 0.5) -> Behaviour:

    which returns a py_trees tree. Its keyword-only parameters are the mission's parameters: scenarios set them, and
    their annotations say in which unit, and which numbers make sense. Composites and decorators are py_trees' own.

    Args:
        name: The mission's name.
        knowledge: All that the robot knows.
        pipeline: Where leaves submit their actions.
        actions: The action table.
        clock: Time.
        sink: Where events go.
        compile_guard: Compiles an expression over the signals; None where there are no expressions.
        rule_reading: Tells a rule's guard with its present readings, for the reason of a robot that is stuck.
        survey: Whether this is a check: leaves with faults are made all the same, and the faults collected.

    Attributes:
        leaves: The leaves that `build` has made, in that order.
        faults: What was found in a survey.
    """

    def __init__(
        self,
        name: str,
        *,
        knowledge: Knowledge,
        pipeline: Pipeline,
        actions: Mapping[str, type[Action]],
        clock: Clock,
        sink: EventSink,
        compile_guard: Callable[[str], Expression] | None = None,
        rule_reading: Callable[[str], str] = lambda rule: "",
        survey: bool = False,
    ) -> None:
        self.name = name
        self.knowledge = knowledge
        self.pipeline = pipeline
        self.actions = actions
        self.clock = clock
        self.sink = sink
        self.rule_reading = rule_reading
        self.leaves: list[Behaviour] = []
        self.faults: list[Fault] = []
        self._compile = compile_guard
        self._survey = survey
        self._paths: Mapping[Any, str] = {}
        self._time = clock.now()
        self._snapshot: list[float] | None = None

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
        except InputError as error:
            self._fault(error)
        goal = given.get("goal")
        if self._survey and isinstance(goal, str):
            self._look_for(action, goal)
        shown = name or (f"{action} {goal}" if isinstance(goal, str) else action)
        leaf = Act(shown, self, lambda: make_action(self.actions, action, given), max_preemptions)
        self.leaves.append(leaf)
        return leaf

    def when(self, expression: str, /, *, name: str = "") -> Condition:
        """A leaf that asks an expression over the signals, such as `min(front) > 0.5 m`.

        Raises:
            InputError: It is no expression, or it names no signal.
        """
        guard: Expression | None = None
        try:
            guard = self._guard(expression)
        except InputError as error:
            self._fault(error)
        leaf = Condition(
            name or expression,
            expression,
            holds=lambda: guard is not None and bool(guard(self._seen(), self._time)),
            reading=lambda: "" if guard is None else reading(guard.node, self._seen()),
        )
        self.leaves.append(leaf)
        return leaf

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
        leaf = Wait(name or f"wait {seconds:g} s", seconds, self.clock)
        self.leaves.append(leaf)
        return leaf

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event of this agent, now."""
        self.sink.emit(event(t=self.clock.now(), agent=self.knowledge.agent, **values))

    def path(self, node: Behaviour) -> str:
        """A node's path from the root, names joined by `/`; its name while it is in no tree."""
        return self._paths.get(node.id, node.name)

    def begin(self, t: float, paths: Mapping[Any, str]) -> None:
        """A tick begins: conditions see one snapshot, taken when the first of them asks."""
        self._time, self._paths, self._snapshot = t, paths, None

    def _guard(self, text: str) -> Expression:
        if self._compile is None:
            raise InputError(f"'{text}' cannot be asked: this mission was given no signals.")
        try:
            guard = self._compile(text)
        except InputError as error:
            raise InputError(*(replace(f, message=f"in '{text}': {f.message}") for f in error.faults)) from error
        if guard.node.kind != TRUTH:
            raise InputError(
                Fault(
                    f"'{text}' is {guard.node.kind.words}, not true or false.",
                    hint=f"Compare it with something, such as '{text} > ...'.",
                )
            )
        return guard

    def _seen(self) -> list[float]:
        """The snapshot of this tick."""
        if self._snapshot is None:
            self._snapshot = self.knowledge.signals.snapshot(self._time).tolist()
        return self._snapshot

    def _in_si(self, action: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
        declared = parameters_of(self.actions[action]) if action in self.actions else {}
        given, faults = dict(parameters), list[Fault]()
        for name, value in parameters.items():
            dimension = declared[name].dimension if name in declared else None
            if dimension is None or not isinstance(value, str):
                continue
            try:
                given[name] = convert(value, dimension, f"{name} of {action}")
            except InputError as error:
                faults.extend(error.faults)
        if faults:
            raise InputError(*faults)
        return given

    def _look_for(self, action: str, goal: str) -> None:
        world = self.knowledge.world
        known = [*world.goals(), *world.places(), *world.objects(), *world.peers()]
        if known and world.pose_of(goal) is None:
            found = unknown("place", goal, known, "The world")
            hint = f"{found.hint} {action} fails unless it is found on the way."
            self.faults.append(Fault(found.message, hint=hint, warning=True))

    def _fault(self, error: InputError) -> None:
        if not self._survey:
            raise error
        self.faults.extend(error.faults)
