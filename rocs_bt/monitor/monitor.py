"""Base class of all monitors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from operator import attrgetter
from typing import Annotated, Any

import numpy as np

from ..base.clock import Rate
from ..base.errors import DeviceError, interrupts
from ..base.raised import Raised
from ..base.signal import Signal
from ..base.units import Bounds, Seconds
from ..declare import Declared
from ..event import ContentRaised, EventSink, SensorFailed, SensorRead, SignalsWritten, pack
from ..interfaces.channel import MonitorSubscriber, Publisher, Signals, check_wire
from ..interfaces.device import Reading, Sensor
from ..knowledge import Knowledge

MOVING = 0.05
"""Wheel linear speed, or speed of an axis, above which samples of a sensor must differ by default [m/s, rad/s]."""

_STAMP = attrgetter("stamp")

_INVALID = "its signals are invalid; it is read again in the next period"

Problem = str | Raised
"""Fault of a sensor's reading; empty if there is none."""


@dataclass
class MonitoredSensor:
    """Sensor, with its rate and with the state that its monitor keeps about it.

    Attributes:
        sensor: Sensor device.
        rate: Rate at which the sensor is read, in control periods.
        max_age: Time for which a reading is valid [s]; None for three reading periods.
        optional: Whether the robot can do without the sensor.
        frame: Frame of a pose, as in `SensorSpec.frame`.
    """

    sensor: Sensor
    rate: Rate
    max_age: float | None = None
    optional: bool = False
    frame: str = ""
    failed: bool = False
    last: bytes = b""
    unchanged: float = 0.0  # [s] time with identical values while they should vary
    read_at: float = -math.inf  # [s] time of the newest sample's first reading
    stamp: float = -math.inf  # [s] of the newest sample
    size: int = 0  # number of values of the last sample


class Monitor(Declared, ABC):
    """Base class of monitors, which read sensors, interpret the readings, and write and publish signals.

    A user's monitor implements `interpret` and `signals` (paper, 5.3: a deliberative extension point). If a sensor
    fails or freezes, or the sensor's driver or the monitor raises an exception, the signals become stale or NaN; rules
    and plans notice a failure only by that. An event reports the start of a failure, and the sensor is read again in
    the next period. Annotations of the class declare its keys in robot.toml, as of an action; `__post_init__` may
    compute further attributes.

    Args:
        name: Name in robot.toml.
        monitored: Sensors of the monitor.
        knowledge: Knowledge to which signals are written.
        sink: Sink that receives the monitor's events.
        parameters: Values of the declared keys, SI units.

    Attributes:
        frozen_after: Time after which a sensor counts as broken if its finite values stay bit-identical although they
            must vary [s]; +inf for never.
    """

    frozen_after: Annotated[Seconds, Bounds(infinite=True)] = math.inf

    def __init__(
        self, name: str, monitored: Sequence[MonitoredSensor], knowledge: Knowledge, sink: EventSink, **parameters: Any
    ) -> None:
        self.name = name
        self.monitored = tuple(monitored)
        self.knowledge = knowledge
        self._sink = sink
        self._raises = False
        self._publisher: Publisher[Signals] = Publisher(name)
        self._sizes: dict[tuple[str, ...], tuple[int, ...]] = {}  # sizes of signals that were written as declared
        super().__init__(**parameters)

    @property
    def rate(self) -> Rate:
        """Rate of the monitor's fastest sensor."""
        return min((m.rate for m in self.monitored), key=lambda r: r.every)

    @cached_property
    def max_age(self) -> float:
        """Time for which the monitor's signals are valid [s]: the largest `max_age` of its sensors."""
        return max(3.0 * m.rate.period if m.max_age is None else m.max_age for m in self.monitored)

    @abstractmethod
    def signals(self) -> Sequence[Signal]:
        """Declarations of the signals that the monitor writes; they are added to Knowledge before the first period."""

    def expects(self) -> Mapping[str, int]:
        """Names of the sensors that the monitor needs, and the number of values of each; none by default."""
        return {}

    @abstractmethod
    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        """Convert the newest readings to signals in SI units.

        Args:
            readings: Readings of this period, keyed by sensor; sensors that were not due or failed are missing.

        Returns:
            Signals to write; an omitted signal keeps its value and its age.
        """

    def stamp(self, readings: Mapping[str, Reading]) -> float:
        """Time stamp of the signals that result from readings [s]: that of the oldest reading.

        A monitor that also uses readings of earlier periods must override this method to include these.
        """
        oldest: float = min(map(_STAMP, readings.values()))
        return oldest

    def varies(self, sensor: str) -> bool:
        """Whether consecutive samples of a sensor must differ at present; called only if `frozen_after` is finite.

        By default, samples must differ while the robot moves: while any wheel turns, or any axis of another body moves.
        """
        return bool(np.any(np.abs(self.knowledge.robot.motion()) > MOVING))

    def reject(self, sensor: str, reading: Reading) -> str:
        """Reason to reject an implausible reading, which then counts as NaN; empty to accept it.

        By default all readings are accepted. The method is called once per reading, in order.
        """
        return ""

    def attach(self, analyze: MonitorSubscriber) -> None:
        """Connect an analyser to the signals of this monitor.

        Raises:
            WiringError: The argument is not an analyser.
        """
        check_wire(f"Monitor '{self.name}'", analyze, MonitorSubscriber)
        self._publisher.connect(analyze.inbox)

    def due(self, count: int) -> bool:
        """Whether any sensor of the monitor is due in the control period with this number."""
        return any(m.rate.due(count) for m in self.monitored)

    def run(self, t: float, count: int) -> None:
        """Read the sensors that are due, interpret the readings, and write and publish the signals.

        Args:
            t: Present time [s].
            count: Number of the control period.
        """
        readings: dict[str, Reading] = {}
        problems: list[tuple[MonitoredSensor, Problem]] = []
        written: Signals = {}
        data, stamp, beyond = None, t, ""
        try:
            for monitored in self.monitored:
                if monitored.rate.due(count):
                    reading, problem = self._read(monitored, t)
                    if reading is not None:
                        readings[monitored.sensor.name] = reading
                    problems.append((monitored, problem))
            if readings and (written := self.interpret(readings)):
                stamp = self.stamp(readings)
                if (data := self.knowledge.signals.update(written, stamp)) is None:
                    written, beyond = self._bounded(written)
        except BaseException as error:  # a monitor or driver may raise anything
            if interrupts(error):
                raise
            written, stamp = self._all_invalid(), t
            data = self.knowledge.signals.update(written, stamp)
            self._report_exception(t, error)
        else:
            self._raises = self._raises and not readings
        for monitored, problem in problems:
            if problem or beyond or monitored.failed:
                self._report_fault(monitored, t, problem or beyond)
        if written:
            self._note(t, stamp, written, data)
            self._publisher.publish(stamp, written)

    def _read(self, monitored: MonitoredSensor, t: float) -> tuple[Reading | None, Problem]:
        """Read a sensor.

        Returns:
            Reading, with NaN if it was rejected or the sensor raised an exception, or None; and the fault.
        """
        sensor, raised = monitored.sensor, None
        try:
            reading = sensor.read()
            data = pack(reading.values)
        except DeviceError as error:
            return None, str(error)
        except BaseException as error:  # a monitor or driver may raise anything
            if interrupts(error):
                raise
            raised = Raised.of("sensor", sensor.name, error, sensor.read)
            if not monitored.size:
                return None, raised
            reading = Reading(t, [math.nan] * monitored.size)
            data = pack(reading.values)
        values = reading.values
        monitored.size = len(values)
        event = SensorRead(t=t, agent=self.knowledge.agent, sensor=sensor.name, stamp=reading.stamp, data=data)
        self._sink.emit(event)
        if self.frozen_after < math.inf and self._frozen(monitored, data, reading, t):
            problem = f"frozen: the same values for {monitored.unchanged:.2f} s while the robot moved"
        elif not (problem := self.reject(sensor.name, reading)):
            # NaN or an old time stamp already invalidates the signals, so the reading is passed on unchanged.
            if any(map(math.isnan, values)):
                problem = "the reading contains NaN"
            elif t - reading.stamp > self.max_age + 5e-7:
                problem = f"stale: its newest sample is {t - reading.stamp:.2f} s old"
            return reading, raised or problem
        return Reading(reading.stamp, [math.nan] * len(values)), raised or problem

    def _all_invalid(self) -> Signals:
        """All signals of the monitor as NaN."""
        return {signal.name: [math.nan] * signal.size for signal in self.signals()}

    def _frozen(self, monitored: MonitoredSensor, data: bytes, reading: Reading, t: float) -> bool:
        if reading.stamp <= monitored.stamp:  # the same sample again, of a slower sensor: its age tells
            return monitored.unchanged > self.frozen_after
        passed, monitored.read_at, monitored.stamp = t - monitored.read_at, t, reading.stamp
        if data != monitored.last or not any(math.isfinite(v) for v in reading.values):
            monitored.last, monitored.unchanged = data, 0.0
        elif self.varies(monitored.sensor.name):
            monitored.unchanged += passed
        return monitored.unchanged > self.frozen_after

    def _bounded(self, written: Signals) -> tuple[Signals, str]:
        """Replace values out of bounds by NaN, as Knowledge does; returns the signals and a message about one value."""
        bounded, beyond = {}, ""
        for name, values in written.items():
            low, high = self.knowledge.signals.spec(name).bounds
            bounded[name] = [v if low <= v <= high else math.nan for v in values]
            for value in (v for v in values if v < low or v > high):
                beyond = f"signal '{name}' is out of its bounds [{low:g}, {high:g}]: {value:g}"
        return bounded, beyond

    def _report_fault(self, monitored: MonitoredSensor, t: float, problem: Problem) -> None:
        agent = self.knowledge.agent
        if problem and not monitored.failed:  # only the start of a fault, not every period
            if isinstance(problem, Raised):
                self._sink.emit(ContentRaised.of(t, agent, problem, _INVALID))
            else:
                self._sink.emit(SensorFailed(t=t, agent=agent, sensor=monitored.sensor.name, detail=problem))
        monitored.failed = bool(problem)

    def _report_exception(self, t: float, error: BaseException) -> None:
        """Report an exception of the monitor itself, but only the first of consecutive periods in which it raises."""
        if not self._raises:
            self._raises = True
            raised = Raised.of("monitor", self.name, error, self.interpret)
            self._sink.emit(ContentRaised.of(t, self.knowledge.agent, raised, _INVALID))

    def _note(self, t: float, stamp: float, written: Signals, data: bytes | None) -> None:
        names = tuple(written)
        if data is None:
            sizes, data = tuple(map(len, written.values())), pack(chain.from_iterable(written.values()))
        elif (known := self._sizes.get(names)) is not None:
            sizes = known
        else:
            sizes = self._sizes[names] = tuple(map(len, written.values()))
        self._sink.emit(
            SignalsWritten(
                t=t,
                agent=self.knowledge.agent,
                monitor=self.name,
                signals=names,
                sizes=sizes,
                data=data,
                stamp=None if stamp == t else stamp,
            )
        )
