"""What Python hands to a query beside its text: numbers, quantities, truths, texts, poses and paths, each under a name.

knowledge.ask("object where distance(pose, way) < reach", way=[Pose2(0, 0), Pose2(3, 1)], reach=parse_quantity("0.5 m"))
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from ...errors import KnowledgeError
from ...geometry import Pose2
from ...units import NONE, Dimension, Quantity

Point: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[Point, ...]


@dataclass(frozen=True)
class Parameter:
    """The type of a parameter.

    Attributes:
        type: `float`, `bool`, `str`, `Pose2`, or `tuple` for a path.
        dimension: Of a number.
    """

    type: type
    dimension: Dimension = NONE

    def __str__(self) -> str:
        words = {bool: "a truth value", str: "a text", Pose2: "a pose", tuple: "a path"}
        return words.get(self.type, f"a number [{self.dimension}]")


def read_parameter(name: str, value: Any) -> tuple[Parameter, Any]:
    """The type of a value, and the value as a query reads it.

    Args:
        name: What the query calls it; for messages.
        value: A number, a Quantity, a truth value, a text, a Pose2, or a path: poses or (x, y) [m], at least one.

    Raises:
        KnowledgeError: Anything else.
    """
    if isinstance(value, bool):
        return Parameter(bool), value
    if isinstance(value, Quantity):
        return Parameter(float, value.dimension), value.value
    if isinstance(value, (int, float)):
        return Parameter(float), float(value)
    if isinstance(value, str):
        return Parameter(str), value
    if isinstance(value, Pose2):
        return Parameter(Pose2), value
    points = _points(value)
    if not points or not all(map(math.isfinite, (number for point in points for number in point))):
        raise KnowledgeError(
            f"the parameter '{name}' must be a number, a Quantity, a text, True or False, a Pose2 or a path of poses "
            f"or (x, y); found {value!r}."
        )
    return Parameter(tuple), points


def read_parameters(given: Mapping[str, Any]) -> tuple[dict[str, Parameter], dict[str, Any]]:
    """The types and the values of all parameters.

    Raises:
        KnowledgeError: As `read_parameter`.
    """
    read = {name: read_parameter(name, value) for name, value in given.items()}
    return {name: kind for name, (kind, _) in read.items()}, {name: value for name, (_, value) in read.items()}


def _points(value: Any) -> Path:
    if not isinstance(value, Iterable):
        return ()
    try:
        return tuple((float(point[0]), float(point[1])) for point in value)
    except (TypeError, ValueError, IndexError, OverflowError):
        return ()
