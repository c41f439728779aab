"""Monitor: the common part of all monitors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..channel import MonitorSubscriber, Publisher, Signals, check_wire
from ..clock import Rate
from ..device import Reading, Sensor
from ..errors import DeviceError
from ..event import EventSink, SensorFailed, SensorRead, SignalsWritten, pack
from ..knowledge import Knowledge
from ..signal import Signal

_MOVING = 0.05  # [m/s] of a wheel rim, above which the world must look different from one sample to the next


@dataclass
class Watched:
    """A sensor as its monitor sees it.

    Attributes:
        sensor: The device.
        rate: How often it is read, in control periods.
    """

    sensor: Sensor
    rate: Rate
    failed: bool = False
    last: bytes = b""
    still: float = 0.0  # [s] for how long it has said the same while the wheels turned
    read_at: float = -math.inf  # [s]


class Monitor(ABC):
    """Reads its sensors when they are due, interprets, writes the signals and publishes them.

    A user's monitor implements `interpret`, and `signals` where it writes other signals than its sensors' own
    (paper, 5.3: a deliberative extension point). A sensor that refuses, freezes or breaks makes its signals go
    stale or NaN, which is the one channel of failure.

    Args:
        name: What robot.toml calls it.
        watched: Its sensors, of one kind or several.
        knowledge: Where signals are written and anything may be looked up.
        sink: Where events go.
        frozen_after: A sensor that repeats finite values bit for bit for so long [s] while the wheels turn is
            taken for broken; +inf never.
    """

    def __init__(
        self,
        name: str,
        watched: Sequence[Watched],
        knowledge: Knowledge,
        sink: EventSink,
        *,
        frozen_after: float = math.inf,
    ) -> None:
        self.name = name
        self.watched = tuple(watched)
        self.knowledge = knowledge
        self._sink = sink
        self._frozen_after = frozen_after
        self._publisher: Publisher[Signals] = Publisher(name)

    @property
    def rate(self) -> Rate:
        """The rate of its fastest sensor."""
        return min((w.rate for w in self.watched), key=lambda r: r.every)

    @property
    def max_age(self) -> float:
        """How long its signals stay valid: three periods of its slowest sensor [s]."""
        return 3.0 * max(w.rate.period for w in self.watched)

    @abstractmethod
    def signals(self) -> Sequence[Signal]:
        """The signals that it writes; declared in Knowledge before the first period."""

    @abstractmethod
    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        """What the newest readings mean, as signals in SI units.

        Args:
            readings: The readings of this period by sensor; a sensor that was not due or that failed is missing.

        Returns:
            The signals to write; one that is left out keeps its old value, and its age.
        """

    def attach(self, analyze: MonitorSubscriber) -> None:
        """Publish to this Analyze too.

        Raises:
            WiringError: It is not an Analyze.
        """
        check_wire(f"Monitor '{self.name}'", analyze, MonitorSubscriber)
        self._publisher.connect(analyze.inbox)

    def due(self, count: int) -> bool:
        """Whether any of its sensors is due in this control period."""
        return any(w.rate.due(count) for w in self.watched)

    def run(self, t: float, count: int) -> None:
        """One turn: read what is due, interpret, write, publish."""
        readings = {}
        for watched in self.watched:
            if watched.rate.due(count):
                reading = self._read(watched, t)
                if reading is not None:
                    readings[watched.sensor.name] = reading
        if not readings:
            return
        # The oldest stamp counts: a signal made of two readings is as old as the older one.
        stamp = min(r.stamp for r in readings.values())
        written = self.interpret(readings)
        if written:
            self.knowledge.signals.update(written, stamp)
            self._note(t, written)
            self._publisher.publish(t, written)

    def _read(self, watched: Watched, t: float) -> Reading | None:
        name = watched.sensor.name
        try:
            reading = watched.sensor.read()
        except DeviceError as error:
            self._failed(watched, t, str(error))
            return None
        data = pack(reading.values)
        self._sink.emit(SensorRead(t=t, agent=self.knowledge.agent, sensor=name, stamp=reading.stamp, data=data))
        if self._frozen(watched, data, reading, t):
            self._failed(watched, t, f"frozen: the same values for {watched.still:.2f} s while the wheels turned")
            return Reading(reading.stamp, [math.nan] * len(reading.values))
        watched.failed = False
        return reading

    def _frozen(self, watched: Watched, data: bytes, reading: Reading, t: float) -> bool:
        if math.isinf(self._frozen_after):
            return False
        passed, watched.read_at = t - watched.read_at, t
        if data != watched.last or not any(math.isfinite(v) for v in reading.values):
            watched.last, watched.still = data, 0.0
        elif bool(np.any(np.abs(self.knowledge.robot.wheel_speeds()) > _MOVING)):
            watched.still += passed
        return watched.still > self._frozen_after

    def _failed(self, watched: Watched, t: float, detail: str) -> None:
        if not watched.failed:  # said once, not twenty times a second
            watched.failed = True
            event = SensorFailed(t=t, agent=self.knowledge.agent, sensor=watched.sensor.name, detail=detail)
            self._sink.emit(event)

    def _note(self, t: float, written: Signals) -> None:
        flat: list[float] = []
        for values in written.values():
            flat.extend(values)
        self._sink.emit(
            SignalsWritten(
                t=t,
                agent=self.knowledge.agent,
                monitor=self.name,
                signals=tuple(written),
                sizes=tuple(len(v) for v in written.values()),
                data=pack(flat),
            )
        )
