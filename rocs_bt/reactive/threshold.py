"""Named thresholds: numbers of a rule file that a robot may override.

[threshold]                     # in rules/avoid_collision.toml
near = "0.40 m"

[rules.avoid_collision]         # in a robot's robot.toml
near = "0.50 m"
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..document import Table
from ..errors import Fault, InputError, did_you_mean
from ..expression import FUNCTIONS, Kind, Node
from ..units import NONE, Quantity, convert, parse_quantity, unit_names

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
WORDS = frozenset({"inf", "always", "within", "implies"})


@dataclass(frozen=True)
class Override:
    """Value that overrides a threshold of a rule file.

    Attributes:
        value: Value as written in the file, such as `0.5 m`.
        file: File that declares the value.
        line: Line, 1-based; 0 if unknown.
        column: Column, 1-based; 0 if unknown.
    """

    value: Any
    file: Path | None = None
    line: int = 0
    column: int = 0


def usable(name: str, taken: Collection[str]) -> bool:
    """Whether a word can be a new name in expressions.

    Args:
        name: Word.
        taken: Names that are already used.
    """
    words = {*FUNCTIONS, *unit_names(), *keyword.kwlist, *WORDS, *taken}
    return NAME.fullmatch(name) is not None and name not in words


def read_thresholds(table: Table, known: Mapping[str, Node], signals: Collection[str]) -> dict[str, Node]:
    """Read the `[threshold]` table of a file and add it to the thresholds of its included files.

    Args:
        table: Root table of the document.
        known: Thresholds of included files, which the file may override.
        signals: Names of signals, which a threshold cannot have.
    """
    thresholds = dict(known)
    written = table.table("threshold")
    for name in written.keys():  # noqa: SIM118 - a Table is no mapping and cannot be iterated
        value = written.raw(name)
        if not usable(name, signals):
            hint = "It must be a new word: no signal, function or unit."
            written.fault(name, f"'{name}' cannot be a threshold.", hint=hint)
            continue
        try:
            thresholds[name] = _node(name, value, known.get(name))
        except InputError as error:
            written.adopt(name, error)
    return thresholds


def override(
    thresholds: Mapping[str, Node], given: Mapping[str, Override], rules: str
) -> tuple[dict[str, Node], list[Fault]]:
    """Replace thresholds by the values that a robot declares; returns the thresholds and the faults of the values.

    Args:
        thresholds: Thresholds of the rule file.
        given: Values that the robot declares, keyed by threshold.
        rules: Name of the rule file.
    """
    result, faults = dict(thresholds), list[Fault]()
    for name, own in given.items():
        if name not in thresholds:
            hint = did_you_mean(name, thresholds, f"The rule file '{rules}'")
            fault = Fault(f"no threshold of '{rules}' is named '{name}'.", hint=hint)
            faults.append(replace(fault, file=own.file, line=own.line, column=own.column))
            continue
        try:
            result[name] = _node(name, own.value, thresholds[name])
        except InputError as error:
            faults.extend(error.at(own.file, own.line, own.column).faults)
    return result, faults


def _node(name: str, value: Any, before: Node | None) -> Node:
    """Expression node of a threshold.

    Args:
        name: Name of the threshold.
        value: Value as written.
        before: Node of the overridden threshold; the value must have its dimension. None for a new threshold.
    """
    if before is not None and before.kind.dimension is not None:
        number = convert(value, before.kind.dimension, what=f"'{name}'")
        quantity = Quantity(number, before.kind.dimension)
    elif isinstance(value, str):
        quantity = parse_quantity(value)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        quantity = Quantity(float(value), NONE)
    else:
        raise InputError(f"'{name}' must be a quantity, such as \"0.5 m\", found {value!r}.")
    return Node("number", Kind(quantity.dimension), value=quantity.value, text=name)
