"""Switches: which child is ticked depends on a value."""

from __future__ import annotations

from typing import Any, ClassVar

from ....errors import InputError
from ...board import Enums, from_string, to_string
from ...status import IDLE, RUNNING, SKIPPED, Outcome
from ..family import Control, halt
from ..port import Input

EPSILON = 2.0**-23
"""Numbers no further apart are the same case: the epsilon of a C++ float."""


class _Switch(Control):
    """Ticks the child of the first case that equals `variable`, or the last child if none does or it has no value.

    Cases are compared as text, then as whole numbers, where enums count, then as numbers. When another case is met,
    the child that was RUNNING is halted. If the child is skipped, so is the switch.
    """

    cases: ClassVar[int] = 0
    variable = Input(str, None, "the value; usually a key")

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
            raise self.strange(child, outcome)
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
        """The first case that equals a value, counted from 0."""
        for case, port in enumerate(self._ports):
            other = self._text(port)
            if other is not None and same(value, other, enums):
                return case
        return self.cases

    def _text(self, port: str) -> str | None:
        value = self.value_of(port)
        return None if value is None else to_string(value)

    def value_of(self, port: str) -> Any:
        """A port's value as the board holds it; None where there is none."""
        key = self._keys[port]
        if key is None:
            return self.given.get(port)
        entry = self.board.entry(key)
        return None if entry is None else entry.value


def same(left: str, right: str, enums: Enums) -> bool:
    """Whether two texts are the same case."""
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
    ports = {
        f"case_{i}": Input(str, None, f"child {i} is ticked when the variable equals it") for i in range(1, cases + 1)
    }
    members: dict[str, Any] = {
        **ports,
        "cases": cases,
        "least": cases + 1,
        "most": cases + 1,
        "__doc__": _Switch.__doc__,
        "__module__": __name__,
    }
    return type(f"Switch{cases}", (_Switch,), members)


Switch2, Switch3, Switch4, Switch5, Switch6 = (_switch(cases) for cases in range(2, 7))
