"""Quantities with units: texts in files, numbers in SI units in memory (docs/architecture.md).

A file contains `"0.5 m"` or `"60 deg"`; the engine uses metres and radians. The angle is a dimension of its own
here, so that a plain number is rejected where an angle is expected.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

from .errors import Fault, UnitError, did_you_mean

_BASE = ("m", "s", "rad", "kg", "A", "K", "bit")


@dataclass(frozen=True)
class Dimension:
    """Physical dimension: exponents of the base units m, s, rad, kg, A, K, bit."""

    exponents: tuple[int, ...] = (0,) * len(_BASE)

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, power: int) -> Dimension:
        return Dimension(tuple(a * power for a in self.exponents))

    def __str__(self) -> str:
        return _written(self.exponents)


@lru_cache(maxsize=256)  # a scan's signal has one dimension for each beam
def _written(exponents: tuple[int, ...]) -> str:
    def side(sign: int) -> list[str]:
        return [
            name if abs(e) == 1 else f"{name}{abs(e)}" for name, e in zip(_BASE, exponents, strict=True) if e * sign > 0
        ]

    above, below = side(1), side(-1)
    if not above and not below:
        return "1"
    return ("*".join(above) or "1") + "".join(f"/{b}" for b in below)


def _base(name: str) -> Dimension:
    return Dimension(tuple(int(name == b) for b in _BASE))


NONE = Dimension()
LENGTH, TIME, ANGLE, MASS, CURRENT, TEMPERATURE, DATA = (_base(b) for b in _BASE)
SPEED = LENGTH / TIME
TURN_RATE = ANGLE / TIME
ACCELERATION = SPEED / TIME
ANGULAR_ACCELERATION = TURN_RATE / TIME
FREQUENCY = NONE / TIME
FORCE = MASS * ACCELERATION

_UNITS: dict[str, tuple[float, Dimension]] = {
    "1": (1.0, NONE),
    "%": (0.01, NONE),
    "m": (1.0, LENGTH),
    "mm": (1e-3, LENGTH),
    "cm": (1e-2, LENGTH),
    "km": (1e3, LENGTH),
    "s": (1.0, TIME),
    "ms": (1e-3, TIME),
    "us": (1e-6, TIME),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "rad": (1.0, ANGLE),
    "deg": (math.pi / 180.0, ANGLE),
    "rev": (2.0 * math.pi, ANGLE),
    "Hz": (1.0, FREQUENCY),
    "kHz": (1e3, FREQUENCY),
    "kg": (1.0, MASS),
    "g": (1e-3, MASS),
    "N": (1.0, FORCE),
    "Nm": (1.0, FORCE * LENGTH),
    "J": (1.0, FORCE * LENGTH),
    "Wh": (3600.0, FORCE * LENGTH),
    "W": (1.0, FORCE * SPEED),
    "A": (1.0, CURRENT),
    "V": (1.0, FORCE * SPEED / CURRENT),
    "K": (1.0, TEMPERATURE),
    "bit": (1.0, DATA),
}

_FACTOR = re.compile(r"\s*([*/]?)\s*(1(?![0-9])|%|[A-Za-z]+)(?:\^?(-?[0-9]))?")
_NUMBER = re.compile(r"\s*([+-]?(?:inf|[0-9]+(?:\.[0-9]*)?(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?))\s*")


@dataclass(frozen=True)
class Quantity:
    """Number in SI units, with its dimension."""

    value: float
    dimension: Dimension

    def __str__(self) -> str:
        unit = "" if self.dimension == NONE else f" {self.dimension}"
        return f"{self.value:g}{unit}"


def unit_names() -> tuple[str, ...]:
    """Names of all units that `parse_unit` knows, without compound ones such as `m/s`."""
    return tuple(_UNITS)


@lru_cache(maxsize=32)
def units_of(dimension: Dimension) -> tuple[str, ...]:
    """Names of the units of a dimension; without a single one, quotients such as `m/s2`."""
    if single := [name for name, (_, of) in _UNITS.items() if of == dimension]:
        return tuple(single)
    over = [(over, under, p) for over in _UNITS for under in _UNITS for p in (1, 2) if under not in ("1", "%")]
    found = [(a, b, p) for a, b, p in over if _UNITS[a][1] / _UNITS[b][1] ** p == dimension]
    return tuple(f"{a}/{b}{'' if p == 1 else p}" for a, b, p in found)


@lru_cache(maxsize=256)  # a scan's signal names its unit once for each beam
def parse_unit(text: str) -> Quantity:
    """Parse a unit such as `m/s2`, `deg`, `1`; returns one unit as a quantity: its factor to SI, and its dimension.

    Raises:
        UnitError: The text is not a unit; the error lists the known units.
    """
    factor, dimension, at = 1.0, NONE, 0
    stripped = text.strip()
    if not stripped:
        return Quantity(1.0, NONE)
    while at < len(stripped):
        match = _FACTOR.match(stripped, at)
        if match is None or (at > 0 and not match[1]) or (at == 0 and match[1]):
            raise UnitError(Fault(f"'{text}' is not a unit.", hint="Write for example 'm', 'deg', 'm/s', 'm/s2'."))
        name, power = match[2], int(match[3] or 1)
        if name not in _UNITS:
            where = "" if name == stripped else f" in '{stripped}'"
            raise UnitError(Fault(f"'{name}'{where} is not a unit.", hint=did_you_mean(name, _UNITS, "The list")))
        sign = -1 if match[1] == "/" else 1
        factor *= _UNITS[name][0] ** (sign * power)
        dimension = dimension * _UNITS[name][1] ** (sign * power)
        at = match.end()
    return Quantity(factor, dimension)


def parse_quantity(text: str, wanted: Dimension | None = None) -> Quantity:
    """Parse a quantity such as `0.5 m`, `-60 deg`, `20 Hz`, or `3`, which has no dimension.

    Args:
        text: The quantity.
        wanted: Dimension of the example in the advice.

    Raises:
        UnitError: The text has no number or an unknown unit.
    """
    match = _NUMBER.match(text)
    if match is None:
        hint = f"Write a number and its unit, such as '0.5 {wanted or 'm'}'."
        raise UnitError(Fault(f"'{text}' is not a quantity.", hint=hint))
    unit = parse_unit(text[match.end() :])
    return Quantity(float(match[1]) * unit.value, unit.dimension)


def convert(value: object, dimension: Dimension, what: str = "this value") -> float:
    """Convert a value from a file to a number in SI units, and check its dimension.

    A plain number is accepted only if the expected dimension is NONE; all other values must have a unit.

    Raises:
        UnitError: The unit is missing, unknown or of another dimension.
    """
    if dimension == NONE and (isinstance(value, bool) or not _NUMBER.match(str(value))):
        raise UnitError(Fault(f"{what} must be a number, found {value!r}."))
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise UnitError(Fault(f"{what} must be a quantity in {dimension}, found {value!r}."))
    if isinstance(value, (int, float)):
        if dimension == NONE:
            return float(value)
        raise UnitError(
            Fault(
                f"{what} needs a unit, found the bare number {value}.",
                hint=f'Write "{value} {dimension}" or another unit of the same dimension.',
            )
        )
    quantity = parse_quantity(value, dimension)
    if quantity.dimension != dimension and dimension == NONE:
        raise UnitError(Fault(f"{what} has no unit, found '{value}'.", hint="Write a number without a unit."))
    if quantity.dimension != dimension:
        raise UnitError(
            Fault(
                f"{what} must be in {dimension}, found '{value}' which is in {quantity.dimension}.",
                hint=f"Write a number with a unit of {dimension}.",
            )
        )
    return quantity.value


def _plain(number: float) -> str:
    return str(int(number)) if number == int(number) else f"{number:g}"


@dataclass(frozen=True)
class Bounds:
    """Range of valid values of a parameter, in SI units; NaN is never valid."""

    low: float = -math.inf
    high: float = math.inf
    above: bool = False  # whether `low` itself is excluded
    below: bool = False  # whether `high` itself is excluded
    infinite: bool = False  # whether infinity is valid

    def admit(self, value: float) -> bool:
        """Whether a number lies within the bounds."""
        inside = (value > self.low if self.above else value >= self.low) and (
            value < self.high if self.below else value <= self.high
        )
        return inside and (self.infinite or not math.isinf(value))

    @property
    def words(self) -> str:
        """The bounds in words, such as `between 0 and 60`."""
        low, high = math.isfinite(self.low), math.isfinite(self.high)
        if low and high and not (self.above or self.below):
            return f"between {_plain(self.low)} and {_plain(self.high)}"
        least = f"{'above' if self.above else 'at least'} {self.low:g}"
        least = "positive" if self.above and self.low == 0.0 else least
        most = f"{'below' if self.below else 'at most'} {self.high:g}"
        return " and ".join([*([least] if low else []), *([most] if high else [])]) or "finite"

    def broken(self, found: float, dimension: Dimension) -> str:
        """What a number outside of the bounds must be, in words; `finite` for an infinite one above `low`."""
        unlimited = math.isinf(found) and not self.infinite and found > self.low and math.isinf(self.high)
        words = "finite" if unlimited or self == FINITE else self.words
        return f"{words} {dimension}" if dimension != NONE and words[-1].isdigit() else words

    def __str__(self) -> str:
        if math.isfinite(self.high):
            return self.words
        least = "positive" if self.above else f"{self.low:g} or more"
        words = [*([least] if math.isfinite(self.low) else []), *([] if self.infinite else ["finite"])]
        return " and ".join(words) or "a number"


FINITE = Bounds()
POSITIVE = Bounds(0.0, above=True)
NOT_NEGATIVE = Bounds(0.0)


def read_quantity(text: str, dimension: Dimension, what: str, bounds: Bounds = FINITE) -> float:
    """Read what a person types at a prompt: a quantity such as `3 s`, or a plain number in SI units.

    Raises:
        UnitError: The text is no quantity, or one of another dimension or out of its bounds.
    """
    unit = "" if dimension == NONE else f" {dimension}"
    wanted, example = f"{what} must be a {'quantity in' if unit else 'number'}{unit}", f"Write for example '3{unit}'."
    try:
        quantity = parse_quantity(text)
    except UnitError as error:
        raise UnitError(Fault(f"{wanted}, found '{text}'.", hint=example)) from error
    if quantity.dimension not in (dimension, NONE):
        raise UnitError(Fault(f"{wanted}, found '{text}', which is in {quantity.dimension}.", hint=example))
    if not bounds.admit(quantity.value):
        raise UnitError(Fault(f"{what} must be {bounds}, found {quantity.value:g}{unit}."))
    return quantity.value


# Annotations for parameters of actions and missions. Each means a float in SI units, which in files needs a unit of
# this dimension. Any finite number is valid, unless the type is Positive... or Annotated[Metres, NOT_NEGATIVE].
Metres = Annotated[float, LENGTH]
MetresPerSecond = Annotated[float, SPEED]
MetresPerSecondSquared = Annotated[float, ACCELERATION]
Radians = Annotated[float, ANGLE]
Kilograms = Annotated[float, MASS]
Joules = Annotated[float, FORCE * LENGTH]
Watts = Annotated[float, FORCE * SPEED]
RadiansPerSecond = Annotated[float, TURN_RATE]
Seconds = Annotated[float, TIME]
TimeLimit = Annotated[Seconds, Bounds(0.0, infinite=True)]
PositiveMetres = Annotated[Metres, POSITIVE]
PositiveMetresPerSecond = Annotated[MetresPerSecond, POSITIVE]
PositiveRadians = Annotated[Radians, POSITIVE]
PositiveRadiansPerSecond = Annotated[RadiansPerSecond, POSITIVE]
PositiveSeconds = Annotated[Seconds, POSITIVE]
Count = Annotated[int, NOT_NEGATIVE]
PositiveCount = Annotated[int, POSITIVE]
