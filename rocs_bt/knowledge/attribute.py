"""Attributes of the knowledge graph: their types, and the check of every value that is written."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import KnowledgeError, did_you_mean
from ..base.geometry import Pose2
from ..base.toml_table import Table
from ..base.units import NONE, Bounds, Dimension, Metres, Radians
from ..declare import MISSING, Field, Keys, Scope, Value
from ..event import Value as PlainValue


class Live:
    """Type of attributes that cannot be written: live view of the signal that the node's attribute `signal` names."""


class PoseAttributeKeys(Value):
    """Keys x, y and yaw of an attribute that is a pose, in a file."""

    x: Metres
    y: Metres
    yaw: Radians = 0.0

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        for extra in sorted({*table.data} - {*cls._names}):
            hint = "Write z as an attribute of the node." if extra == "z" else did_you_mean(extra, cls._names, "It")
            table.fault(None, f"a pose has no '{extra}'.", hint)

    def _made(self) -> Pose2:
        return Pose2(self.x, self.y, self.yaw)


@dataclass(frozen=True)
class Attribute:
    """One attribute of a kind or of a relation.

    Attributes:
        type: Python type: `float`, `int`, `bool`, `str`, `tuple` (of floats), `Pose2` or `Live`.
        dimensions: Dimension of each number; one for a float, three for a pose.
        required: Whether a node cannot be added without a value of this attribute.
        default: Value until the first write; None for unknown.
        low: Lowest allowed number, SI units.
        high: Highest allowed number, SI units.
        size: Number of elements of a tuple; 0 for any.
        choices: Allowed texts; empty for any.
        doc: Description, one sentence.
    """

    type: type
    dimensions: tuple[Dimension, ...] = (NONE,)
    required: bool = False
    low: float = -math.inf
    high: float = math.inf
    default: Any = None
    size: int = 0
    choices: tuple[str, ...] = ()
    doc: str = ""

    def __post_init__(self) -> None:
        if self.type not in _WORDS:
            names = ", ".join(t.__name__ for t in _WORDS)
            raise KnowledgeError(f"no attribute can be of the type {self.type!r}; use one of: {names}.")
        if self.default is not None:
            try:
                self.check(self.default)
            except KnowledgeError as error:
                raise KnowledgeError(f"default {error}") from None

    def check(self, value: Any) -> Any:
        """Check a value and convert it to the immutable Python value that is stored.

        Args:
            value: Value to write; None if unknown, which a required attribute refuses.

        Raises:
            KnowledgeError: Wrong type, NaN, or outside `low` and `high`. The message lacks the attribute's name, which
                the caller puts in front.
        """
        if self.type is float and type(value) is float and self.low <= value <= self.high:
            return value  # the common case
        if value is None and not self.required:
            return None
        if self.type is float:
            return self._number(value)
        if self.type is tuple:
            return self._numbers(value)
        if self.type is Pose2:
            return self._pose(value)
        if self.type is Live:
            raise KnowledgeError("is the live view of a signal; write to the signal table instead.")
        if self.type is int and isinstance(value, (int, np.integer)) and not isinstance(value, bool):
            self._within(int(value))
            return int(value)
        if type(value) is not self.type:
            raise KnowledgeError(f"must be {self}, found {value!r}.")
        if self.choices and value not in self.choices:
            raise KnowledgeError(f"must be one of {', '.join(self.choices)}, found {value!r}.")
        return value

    def field(self, name: str) -> Field:
        """Declaration of a value in a file; `check` judges its bounds."""
        many = "list" if self.type is tuple else ""
        hint = float if many else self.type
        marks = (Keys(PoseAttributeKeys),) if hint is Pose2 else (self.dimensions[0], Bounds(infinite=True))
        return Field(name, name, hint, marks, MISSING, many, Value)

    def narrows(self, wider: Attribute) -> bool:
        """Whether this attribute accepts only values that `wider` accepts: same type and unit, and bounds no wider."""
        if (self.type, self.dimensions) != (wider.type, wider.dimensions) or wider.required > self.required:
            return False
        fewer = not wider.choices or (self.choices and {*self.choices} <= {*wider.choices})
        return bool(fewer) and wider.size in (0, self.size) and wider.low <= self.low and self.high <= wider.high

    @property
    def description(self) -> str:
        """Type, bounds, choices and `required`, for messages."""
        span = "" if math.isinf(self.low) and math.isinf(self.high) else f" in [{self.low:g}, {self.high:g}]"
        few = f" of {', '.join(self.choices)}" if self.choices else ""
        return f"{self}{span}{few}{', required' if self.required else ''}"

    def _number(self, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (float, int, np.floating, np.integer)):
            raise KnowledgeError(f"must be {self}, found {value!r}.")
        try:
            number = float(value)
        except OverflowError:
            raise KnowledgeError(f"must be {self}, found a number too large for float64.") from None
        self._within(number)
        return number

    def _numbers(self, value: Any) -> tuple[float, ...]:
        if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
            raise KnowledgeError(f"must be {self}, found {value!r}.")
        numbers = tuple(self._number(v) for v in value)
        if self.size and len(numbers) != self.size:
            raise KnowledgeError(f"must be {self}, found {len(numbers)}.")
        return numbers

    def _pose(self, value: Any) -> Pose2:
        if not isinstance(value, Pose2):
            raise KnowledgeError(f"must be {self}, found {value!r}.")
        x, y, yaw = value
        plain = type(x) is type(y) is type(yaw) is float and math.isfinite(x + y + yaw)
        if plain and self.low <= min(value) and max(value) <= self.high:
            return value  # the common case
        pose = Pose2(*(self._number(v) for v in value))
        if not all(map(math.isfinite, pose)):
            raise KnowledgeError(f"must be finite, found {value!r}.")
        return pose

    def _within(self, value: float) -> None:
        # NaN compares false, so this form rejects it too.
        if not self.low <= value <= self.high:
            span = "" if math.isinf(self.low) and math.isinf(self.high) else f" in [{self.low:g}, {self.high:g}]"
            raise KnowledgeError(f"must be {self}{span}, found {value!r}.")

    def __str__(self) -> str:
        units = ", ".join(dict.fromkeys(str(d) for d in self.dimensions))
        return _WORDS[self.type].format(units=units, count=f"{self.size} " if self.size else "")


def plain(value: Any) -> PlainValue:
    """A value of the graph in the form that events and messages hold: a list for a tuple or a pose."""
    found: PlainValue = list(value) if isinstance(value, tuple) else value
    return found


_WORDS: dict[type, str] = {
    float: "a number [{units}]",
    int: "a whole number",
    bool: "True or False",
    str: "a text",
    tuple: "a list of {count}numbers [{units}]",
    Pose2: "a Pose2 [{units}]",
    Live: "a live view",
}
