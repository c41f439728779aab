"""BatteryMonitor: charge of the battery."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..base.signal import OPTIONAL_SIGNALS, Signal
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .monitor import Monitor


class BatteryMonitor(Monitor):
    """Writes the signal `battery`, the charge from 0 (empty) to 1 (full), from its only sensor."""

    def signals(self) -> Sequence[Signal]:
        return [replace(OPTIONAL_SIGNALS["battery"], max_age=self.max_age)]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        (reading,) = readings.values()
        return {"battery": reading.values}
