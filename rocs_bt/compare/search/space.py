"""Space: the scenes that a search draws from: a family's parameters within ranges, and its indices."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...action import Parameter
from ...errors import Fault, InputError, unknown
from ...units import convert
from ..family import Family, Scene, family_parameters
from ..replay import parse_value

INDICES = 1_000_000
_DRAWS = 200  # of parameters in a row that make no scene, before the ranges are held to be wrong


@dataclass(frozen=True)
class SampledScene:
    """A scene that was drawn.

    Attributes:
        scene: The scene.
        index: Its index in its family.
        parameters: The family's, those that were varied, in SI units.
    """

    scene: Scene
    index: int
    parameters: Mapping[str, float]


@dataclass(frozen=True)
class SearchSpace:
    """Where scenes are drawn from.

    Attributes:
        family: The family, with all parameters that stay.
        ranges: Least and greatest of those that are varied, in SI units; both count.
    """

    family: Family
    ranges: Mapping[str, tuple[float, float]]

    @staticmethod
    def of(family: Family, fixed: Mapping[str, object], told: Mapping[str, str]) -> SearchSpace:
        """A family's numbers, each from half to twice what it is, but for those that are fixed or told.

        A whole number of 1 or less may be a flag, and is 0 or 1.

        Args:
            family: The family.
            fixed: Parameters that were set, and stay.
            told: Ranges of others, as a person writes them: `{"boxes": "0..6", "side": "3 m..6 m"}`.

        Raises:
            InputError: A range is none, or is of no number of the family.
        """
        declared = family_parameters(type(family))
        numbers = {n: p for n, p in declared.items() if p.type in (int, float) and n not in family.NOT_SAMPLED}
        ranges = {n: _around(getattr(family, n)) for n in numbers if n not in fixed}
        for name, text in told.items():
            if name not in numbers:
                raise InputError(unknown("number", name, numbers, f"The family {family.name}"))
            ranges[name] = _range(numbers[name], text)
        return SearchSpace(family, ranges)

    def sample(self, rng: np.random.Generator) -> SampledScene:
        """A scene. Parameters that make none, such as a hall that is too small, are drawn anew.

        Raises:
            InputError: Nothing within the ranges makes a scene, as far as can be seen.
        """
        for _ in range(_DRAWS):
            values: dict[str, Any] = {name: self._value(rng, name) for name in self.ranges}
            index = int(rng.integers(INDICES))
            try:
                return SampledScene(dataclasses.replace(self.family, **values).scene(index), index, values)
            except InputError as error:
                refused = error
        raise refused

    def _value(self, rng: np.random.Generator, name: str) -> float:
        low, high = self.ranges[name]
        if isinstance(getattr(self.family, name), int):
            return int(rng.integers(round(low), round(high) + 1))
        return float(f"{rng.uniform(low, high):.3g}")


def _around(value: Any) -> tuple[float, float]:
    if isinstance(value, int):
        return (value // 2, 2 * value) if value > 1 else (0, 1)
    return min(value / 2.0, value * 2.0), max(value / 2.0, value * 2.0)


def _range(parameter: Parameter, text: str) -> tuple[float, float]:
    name = parameter.name
    ends = text.split("..")
    hint = f"Write --vary {name}=LOW..HIGH, each with its unit."
    if len(ends) != 2:
        raise InputError(Fault(f"'{text}' is no range of {name}.", hint=hint))
    low, high = (_end(parameter, end.strip(), hint) for end in ends)
    if faults := [*parameter.bound_faults(low, name), *parameter.bound_faults(high, name)]:
        raise InputError(*faults)
    if low > high:
        raise InputError(Fault(f"the range of {name} ends before it begins: {text}.", hint=hint))
    return low, high


def _end(parameter: Parameter, text: str, hint: str) -> float:
    """One end of a range in SI units."""
    value = parse_value(text)
    if parameter.dimension is not None:
        return convert(value, parameter.dimension, parameter.name)
    if type(value) is not int:
        raise InputError(Fault(f"'{text}' is no whole number for {parameter.name}.", hint=hint))
    return value
