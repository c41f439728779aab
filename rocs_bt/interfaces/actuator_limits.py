"""Limits of actuators, to which their safety gates reduce commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..base.errors import InputError


@dataclass(frozen=True)
class ActuatorLimits:
    """Limits of an actuator's commands: range and rate of change, in SI units of the command.

    Attributes:
        low: Minimum of each value, shape (n,), or (1,) for all values.
        high: Maximum of each value, of the same shape as `low`.
        max_change: Maximum rate of change [1/s], of all values, or shape (n,) of each; +inf for no limit.
        together: Whether values are scaled by one factor, which preserves the curvature of a path; otherwise each value
            is limited separately.
        apart: Indices of values that are limited separately although the others are scaled together, such as the
            vertical speed of a flying body.

    Raises:
        InputError: A bound is not finite, `low` is not below `high`, `max_change` is not positive, or the range of
            values that are scaled together does not contain 0.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    max_change: float | tuple[float, ...] = math.inf
    together: bool = False
    apart: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if len(self.low) != len(self.high) or not self.low:
            raise InputError("a range needs one lower bound for each upper bound.")
        for low, high in zip(self.low, self.high, strict=True):
            if not (math.isfinite(low) and math.isfinite(high) and low < high):
                raise InputError(f"a range goes from a finite number to a larger one, found {low:g} to {high:g}.")
            if self.together and not low <= 0.0 <= high:
                raise InputError(f"the range of wheel speeds must contain 0 m/s, found {low:g} to {high:g} m/s.")
        if isinstance(self.max_change, tuple) and len(self.max_change) != len(self.low):
            raise InputError(f"max_change needs one rate for each of {len(self.low)} values, or one for all.")
        for change in self.changes:
            if not change > 0.0:
                raise InputError(f"max_change must be positive, found {change:g}.")

    @property
    def changes(self) -> tuple[float, ...]:
        """Maximum rate of change of each value, of the shape of `low` [1/s]."""
        return self.max_change if isinstance(self.max_change, tuple) else (self.max_change,) * len(self.low)

    @property
    def largest(self) -> float:
        """Largest magnitude that every value can have in both directions; for wheels the speed limit [m/s]."""
        return min(min(-low, high) for low, high in zip(self.low, self.high, strict=True))

    def of_size(self, size: int) -> ActuatorLimits:
        """Copy of these limits with one pair of bounds for each of `size` values.

        Raises:
            InputError: Bounds are declared for another number of values.
        """
        if len(self.low) == size:
            return self
        if len(self.low) > 1:
            raise InputError(f"the range has bounds for {len(self.low)} values, but a command has {size}.")
        return replace(self, low=self.low * size, high=self.high * size)

    def rest(self) -> list[float]:
        """Command within the range that is nearest to zero, shape (n,)."""
        return [min(max(0.0, low), high) for low, high in zip(self.low, self.high, strict=True)]

    def apply(self, wanted: Sequence[float], last: Sequence[float], period: float) -> list[float]:
        """Reduce a command to the limits.

        Args:
            wanted: Requested command, shape (n,), finite.
            last: Last command, shape (n,), within the range.
            period: Time since the last command [s].

        Returns:
            Command within the range and within `max_change * period` of `last`, shape (n,).
        """
        given = self._within(wanted, self.low, self.high)
        if self.max_change == math.inf:
            return given
        allowed, steps = [change * period for change in self.changes], [g - v for g, v in zip(given, last, strict=True)]
        steps = self._within(steps, [-limit for limit in allowed], allowed)
        return _clipped([v + s for v, s in zip(last, steps, strict=True)], self.low, self.high)

    def _within(self, values: Sequence[float], low: Sequence[float], high: Sequence[float]) -> list[float]:
        """Values reduced to bounds: those that are limited together by one factor, the others separately."""
        if self.together:
            factor = 1.0
            for i, (v, least, most) in enumerate(zip(values, low, high, strict=True)):
                if not least <= v <= most and i not in self.apart:
                    factor = min(factor, (most if v > 0.0 else least) / v)
            if factor < 1.0:
                values = [v if i in self.apart else v * factor for i, v in enumerate(values)]
        return _clipped(values, low, high)


def _clipped(values: Sequence[float], low: Sequence[float], high: Sequence[float]) -> list[float]:
    return list(map(min, map(max, values, low), high))
