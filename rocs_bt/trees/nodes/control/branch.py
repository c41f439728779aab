"""Control nodes that choose which child to tick: by a condition, by a value, or after a failure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, cast

from py_trees.behaviour import Behaviour

from ....base.errors import Fault, InputError
from ...error import TreeError
from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ...value import Enums, from_string, to_string
from ..base_classes import Control, halt
from ..port import port_of


class _Branch(Control):
    """Base of IfThenElse and WhileDoElse. Their children are: condition, then branch, optional else branch."""

    min_children, max_children = 2, 3

    def _fails(self, outcome: Outcome) -> bool:
        """Return False for a condition with the outcome FAILURE, and raise for any outcome that does not decide."""
        if outcome is SKIPPED:
            hint = "Put the skip condition on the whole node instead."
            raise TreeError(Fault(f"the condition of '{self.name}' ({self.tag}) was skipped.", hint=hint))
        if outcome is IDLE:
            raise self.no_outcome(self.children[0], outcome)
        return False

    def _finish(self, outcome: Outcome) -> Outcome:
        """End the node with the outcome of its current child."""
        if outcome is IDLE and self.current_child is not None:
            raise self.no_outcome(self.current_child, outcome)
        self.halt_children()
        self._index = 0
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


class IfThenElse(_Branch):
    """Ticks its first child, the condition; then the second child if the condition succeeded, else the third.

    Without a third child the result is FAILURE if the condition fails. The condition is not ticked again while a branch
    is RUNNING.
    """

    def tick_once(self) -> Outcome:
        children = self.children
        self.status = RUNNING
        if self._index == 0:
            condition: Any = children[0]
            outcome = condition.tick_once() or condition.status
            self.current_child = condition
            if outcome is RUNNING:
                return outcome
            self._index = 1 if outcome is SUCCESS or self._fails(outcome) else 2
            if self._index == len(children):
                return self._finish(FAILURE)
        branch: Any = children[self._index]
        outcome = branch.tick_once() or branch.status
        self.current_child = branch
        return outcome if outcome is RUNNING else self._finish(outcome)


class WhileDoElse(_Branch):
    """Ticks its first child, the condition, in each tick; then the second child while it succeeds, else the third.

    When the condition changes, the RUNNING branch is halted. Without a third child the result is FAILURE if the
    condition fails. As in BehaviorTree.CPP, a condition with a state is ticked only once per run of the node, because
    nothing resets it while a branch is RUNNING.
    """

    run_aware_children = cast("Sequence[Any]", ())  # keep state after they have ended; notified when a new run begins

    def __init__(
        self, name: str, children: tuple[Behaviour, ...] | list[Behaviour] = (), /, **attributes: object
    ) -> None:
        super().__init__(name, children, **attributes)
        self._answer: Outcome | None = None

    def halted(self) -> None:
        super().halted()
        self._answer = None

    def tick_once(self) -> Outcome:
        children = self.children
        for node in self.run_aware_children if self.status is not RUNNING else ():
            node.begin()
        self.status = RUNNING
        condition: Any = children[0]
        outcome = self._answer or condition.tick_once() or condition.status
        if outcome is RUNNING:
            self.current_child = condition
            return outcome
        holds = outcome is SUCCESS or self._fails(outcome)
        if getattr(condition, "latches", False):
            self._answer = outcome
        if len(children) == 3:
            other = children[2 if holds else 1]
            if other.status is RUNNING:
                halt(other)
        elif not holds:
            return self._finish(FAILURE)
        branch: Any = children[1 if holds else 2]
        outcome = branch.tick_once() or branch.status
        self.current_child = branch
        return outcome if outcome is RUNNING else self._finish(outcome)

    def _finish(self, outcome: Outcome) -> Outcome:
        self._answer = None
        return super()._finish(outcome)


EPSILON = 2.0**-23
"""Maximum difference of numbers that count as equal: the epsilon of a C++ float."""


class _Switch(Control):
    """Ticks the child of the first case that equals `variable`, or the last child if no case does.

    The last child is ticked too if the variable has no value. Cases are compared as text, then as integers or enum
    names, then as numbers. If the case changes, the RUNNING child is halted. If the child is skipped, so is the switch.
    """

    cases: ClassVar[int] = 0
    variable: Annotated[str | None, "value to compare, usually a key"] = None

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._ports = [f"case_{i}" for i in range(1, self.cases + 1)]
        self._keys = {port: self.key(port) for port in ("variable", *self._ports)}
        self._fixed = not any(self._keys[port] for port in self._ports)
        self._known: tuple[str, Enums, int] | None = None

    def tick_once(self) -> Outcome:
        match = self._match()
        child: Any = self.children[match]
        running = self.children[self._index - 1] if self._index else None
        if running is not None and running is not child:
            halt(running)
        outcome: Outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise self.no_outcome(child, outcome)
        self.current_child = child
        self._index = match + 1 if outcome is RUNNING else 0
        if outcome is SKIPPED:
            return outcome
        if outcome is not RUNNING:
            self.halt_children()
        self.status = outcome
        return outcome

    def _match(self) -> int:
        value, enums = self._text("variable"), self.board.enums
        if value is None:
            return self.cases
        if self._known is None or self._known[0] != value or self._known[1] is not enums or not self._fixed:
            self._known = value, enums, self._compared(value, enums)
        return self._known[2]

    def _compared(self, value: str, enums: Enums) -> int:
        """Index of the first case that equals a value, counted from 0."""
        for case, port in enumerate(self._ports):
            other = self._text(port)
            if other is not None and same(value, other, enums):
                return case
        return self.cases

    def _text(self, port: str) -> str | None:
        value = self.value_of(port)
        return None if value is None else to_string(value)

    def value_of(self, port: str) -> Any:
        """Value of a port without conversion: its literal or the value of its blackboard key; None if there is none."""
        key = self._keys[port]
        if key is None:
            return self.given.get(port)
        entry = self.board.entry(key)
        return None if entry is None else entry.value


def same(left: str, right: str, enums: Enums) -> bool:
    """Whether two texts are equal in a Switch: as text, as integers or enum names, or as numbers."""
    if left == right:
        return True
    for kind in (int, float):
        try:
            a, b = from_string(left, kind, enums), from_string(right, kind, enums)
        except InputError:
            continue
        if abs(a - b) <= (EPSILON if kind is float else 0):
            return True
    return False


def _switch(cases: int) -> type[_Switch]:
    ports = {f"case_{i}": port_of(str, f"value that selects child {i}", default=None) for i in range(1, cases + 1)}
    members: dict[str, Any] = {
        **ports,
        "cases": cases,
        "min_children": cases + 1,
        "max_children": cases + 1,
        "__doc__": _Switch.__doc__,
        "__module__": __name__,
    }
    return type(f"Switch{cases}", (_Switch,), members)


Switch2, Switch3, Switch4, Switch5, Switch6 = (_switch(cases) for cases in range(2, 7))


class TryCatch(Control):
    """Ticks all children but the last as a Sequence; if one fails, ticks the last child and then returns FAILURE."""

    min_children = 2
    catch_on_halt: Annotated[bool, "whether a halt ticks the last child once"] = False

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._catching = False

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._skipped = 0
            self._catching = False
            self.status = RUNNING
        children = self.children
        last = len(children) - 1
        while not self._catching and self._index < last:
            outcome = self._tick(self._index)
            if outcome is RUNNING:
                return outcome
            if outcome is FAILURE:
                self.halt_children()
                self._catching = True
            else:
                self._skipped += outcome is SKIPPED
                self._index += 1
        if not self._catching:
            return self._finish(SKIPPED if self._skipped == last else SUCCESS)
        return RUNNING if self._tick(last) is RUNNING else self._finish(FAILURE)

    def halted(self) -> None:
        if self.catch_on_halt and not self._catching:
            for child in self.children[:-1]:
                halt(child)
            self._tick(len(self.children) - 1)
        super().halted()
        self._catching = False

    def _tick(self, index: int) -> Outcome:
        child: Any = self.children[index]
        outcome: Outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise self.no_outcome(child, outcome)
        self.current_child = child
        return outcome

    def _finish(self, outcome: Outcome) -> Outcome:
        self.halt_children()
        self._index = self._skipped = 0
        self._catching = False
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome
