"""RangeMonitor: range readings, and the standard groups that rules use."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..channel import Signals
from ..device import Reading
from ..errors import Fault, InputError
from ..signal import Signal
from ..units import LENGTH
from .monitor import Monitor


@dataclass(frozen=True)
class _Group:
    beams: tuple[int, ...]
    weights: tuple[float, ...]


class RangeMonitor(Monitor):
    """Writes each range sensor's beams as a signal of its name, and its groups (DESIGN 4).

    A group gathers beams. Each beam has a weight in (0, 1]: an obstacle at range r on it counts as one at r / weight
    straight ahead, so that a rule can compare a whole group with one threshold.

    Args:
        beams: How many beams its sensor has.
        group: By name: `beams` (indices into the sensor's values) and `weights` (default 1).
    """

    def __init__(
        self, *args: Any, beams: int, group: Mapping[str, Mapping[str, Any]] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self._beams = int(beams)
        self._groups = {name: self._checked(name, g) for name, g in (group or {}).items()}

    def signals(self) -> Sequence[Signal]:
        def declare(name: str, size: int, doc: str) -> Signal:
            return Signal(name, size, (LENGTH,) * size, (0.0, math.inf), self.max_age, doc)

        raw = declare(self.watched[0].sensor.name, self._beams, "Range by beam; +inf without an echo.")
        groups = (
            declare(name, len(g.beams), f"Beams {list(g.beams)}, each range over its weight.")
            for name, g in self._groups.items()
        )
        return [raw, *groups]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        name, reading = next(iter(readings.items()))
        values = list(reading.values)
        written: dict[str, Sequence[float]] = {name: values}
        for group, g in self._groups.items():
            written[group] = [values[b] / w for b, w in zip(g.beams, g.weights, strict=True)]
        return written

    def _checked(self, name: str, group: Mapping[str, Any]) -> _Group:
        beams = tuple(int(b) for b in group.get("beams", ()))
        weights = tuple(float(w) for w in group.get("weights", (1.0,) * len(beams)))
        where = f"group '{name}' of monitor '{self.name}'"
        if not beams or any(b < 0 or b >= self._beams for b in beams):
            raise InputError(Fault(f"{where} must list beams between 0 and {self._beams - 1}, found {list(beams)}."))
        if len(weights) != len(beams) or any(not 0.0 < w <= 1.0 for w in weights):
            raise InputError(Fault(f"{where} must have one weight in (0, 1] for each beam, found {list(weights)}."))
        return _Group(beams, weights)
