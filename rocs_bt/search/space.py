"""SearchSpace: ranges of a family's parameters from which a search samples scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import Fault, InputError, unknown
from ..compare.family import Family, Scene, scene_of
from ..compare.replay import parse_value
from ..declare import Field, fields_of, read_value, replaced

INDICES = 1_000_000
_ATTEMPTS = 200  # consecutive samples of parameters without a valid scene, after which the ranges are rejected


@dataclass(frozen=True)
class SampledScene:
    """Scene that a search has sampled."""

    scene: Scene
    index: int
    parameters: Mapping[str, float]


@dataclass(frozen=True)
class SearchSpace:
    """Distribution from which a search samples scenes of a family.

    Attributes:
        family: Family with the values of the fixed parameters.
        ranges: Minimum and maximum (inclusive) of each varied parameter, in SI units.
    """

    family: Family
    ranges: Mapping[str, tuple[float, float]]

    @staticmethod
    def of(family: Family, fixed: Mapping[str, object], varied: Mapping[str, str]) -> SearchSpace:
        """Search space of a family. By default, numbers that are not fixed vary from half to twice their value.

        Integers of 0 or 1, which may be flags, vary from 0 to 1.

        Args:
            family: The family.
            fixed: Parameters that stay fixed.
            varied: Ranges of other parameters as written by a user: `{"boxes": "0..6", "side": "3 m..6 m"}`.

        Raises:
            InputError: A range is invalid, does not belong to a number of the family, or its parameter is fixed.
        """
        declared = [each for each in fields_of(type(family)) if each.name not in family.NOT_SAMPLED]
        numbers = {each.name: each for each in declared if each.hint in (int, float)}
        ranges = {n: _around(getattr(family, n)) for n in numbers if n not in fixed}
        for name, text in varied.items():
            if name not in numbers:
                raise InputError(unknown("number", name, numbers, f"The family {family.name}"))
            if name in fixed:
                raise InputError(
                    Fault(f"the parameter '{name}' is fixed and varied.", hint="Remove one of --set and --vary.")
                )
            ranges[name] = _range(numbers[name], text)
        return SearchSpace(family, ranges)

    def sample(self, rng: np.random.Generator) -> SampledScene:
        """Sample a scene. Parameters that give no valid scene, such as a hall that is too small, are sampled again.

        Raises:
            InputError: No sampled parameters gave a valid scene.
        """
        for _ in range(_ATTEMPTS):
            values: dict[str, Any] = {name: self._value(rng, name) for name in self.ranges}
            index = int(rng.integers(INDICES))
            try:
                return SampledScene(scene_of(replaced(self.family, **values), index), index, values)
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


def _range(parameter: Field, text: str) -> tuple[float, float]:
    name = parameter.name
    ends = text.split("..")
    hint = f"Write --vary {name}=LOW..HIGH, each with its unit."
    if len(ends) != 2:
        raise InputError(Fault(f"'{text}' is not a range of {name}.", hint=hint))
    low, high = (read_value(parameter, parse_value(end.strip())) for end in ends)
    if low > high:
        raise InputError(Fault(f"the range of {name} has its bounds swapped: {text}.", hint=hint))
    return low, high
