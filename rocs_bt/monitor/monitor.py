"""Monitor: the common part of all monitors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from operator import attrgetter

import numpy as np

from ..channel import MonitorSubscriber, Publisher, Signals, check_wire
from ..clock import Rate
from ..device import Reading, Sensor
from ..errors import DeviceError, interrupts
from ..event import EventSink, SensorFailed, SensorRead, SignalsWritten, pack
from ..knowledge import Knowledge
from ..raised import Raised
from ..signal import Signal

MOVING = 0.05
"""Speed of a wheel rim above which the world must look different from one sample to the next [m/s]."""

_STAMP = attrgetter("stamp")

_INVALID = "its signals are invalid; it is read again in the next period"

Problem = str | Raised
"""What is wrong with a sensor's reading; empty when nothing is."""


@dataclass
class Watched:
    """A sensor as its monitor sees it.

    Attributes:
        sensor: The device.
        rate: How often it is read, in control periods.
        max_age: How long a reading stays valid [s]; None for three of its periods.
    """

    sensor: Sensor
    rate: Rate
    max_age: float | None = None
    failed: bool = False
    last: bytes = b""
    still: float = 0.0  # [s] for how long it has said the same while the wheels turned
    read_at: float = -math.inf  # [s]
    size: int = 0  # of its last sample


class Monitor(ABC):
    """Reads its sensors when they are due, interprets, writes the signals and publishes them.

    A user's monitor implements `interpret`, and `signals` where it writes other signals than its sensors' own
    (paper, 5.3: a deliberative extension point). A sensor that refuses, freezes or breaks makes its signals go
    stale or NaN, which is the one channel of failure. So does a sensor or a monitor that raises; it is reported when it
    begins to, and read again in the next period.

    Args:
        name: What robot.toml calls it.
        watched: Its sensors, of one kind or several.
        knowledge: Where signals are written and anything may be looked up.
        sink: Where events go.
        frozen_after: A sensor that repeats finite values bit for bit for so long [s] while it must vary is taken for
            broken; +inf never.
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
        self._raises = False
        self._publisher: Publisher[Signals] = Publisher(name)
        self._sizes: dict[tuple[str, ...], tuple[int, ...]] = {}  # of signals that were written as they are declared

    @property
    def rate(self) -> Rate:
        """The rate of its fastest sensor."""
        return min((w.rate for w in self.watched), key=lambda r: r.every)

    @cached_property
    def max_age(self) -> float:
        """How long its signals stay valid [s]: as long as readings of the sensor that allows the most."""
        return max(3.0 * w.rate.period if w.max_age is None else w.max_age for w in self.watched)

    @abstractmethod
    def signals(self) -> Sequence[Signal]:
        """The signals that it writes; declared in Knowledge before the first period."""

    def expects(self) -> Mapping[str, int]:
        """The sensors that it must have, and how many values each must give; none as shipped."""
        return {}

    @abstractmethod
    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        """What the newest readings mean, as signals in SI units.

        Args:
            readings: The readings of this period by sensor; a sensor that was not due or that failed is missing.

        Returns:
            The signals to write; one that is left out keeps its old value, and its age.
        """

    def stamp(self, readings: Mapping[str, Reading]) -> float:
        """When what `interpret` made of these readings was true [s].

        A signal made of two readings is as old as the older one; a monitor that keeps readings must count those too.
        """
        oldest: float = min(map(_STAMP, readings.values()))
        return oldest

    def varies(self, sensor: str) -> bool:
        """Whether a sensor cannot say the same twice now; asked of those that may be `frozen_after` a while.

        As shipped: when any wheel turns, the world looks different from one sample to the next.
        """
        return bool(np.any(np.abs(self.knowledge.robot.wheel_speeds()) > MOVING))

    def doubt(self, sensor: str, reading: Reading) -> str:
        """Why a reading cannot be true; empty when it may be. What is in doubt counts as NaN.

        As shipped nothing is in doubt. Called once for each reading, in their order.
        """
        return ""

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
        readings: dict[str, Reading] = {}
        problems: list[tuple[Watched, Problem]] = []
        written: Signals = {}
        data, stamp, beyond = None, t, ""
        try:
            for watched in self.watched:
                if watched.rate.due(count):
                    reading, problem = self._read(watched, t)
                    if reading is not None:
                        readings[watched.sensor.name] = reading
                    problems.append((watched, problem))
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
        for watched, problem in problems:
            if problem or beyond or watched.failed:
                self._tell(watched, t, problem or beyond)
        if written:
            self._note(t, stamp, written, data)
            self._publisher.publish(t, written)

    def _read(self, watched: Watched, t: float) -> tuple[Reading | None, Problem]:
        """A sensor's sample, NaN where it cannot be true or the sensor raised, and what is wrong with it."""
        sensor, raised = watched.sensor, None
        try:
            reading = sensor.read()
            data = pack(reading.values)
        except DeviceError as error:
            return None, str(error)
        except BaseException as error:  # a monitor or driver may raise anything
            if interrupts(error):
                raise
            raised = Raised.of("sensor", sensor.name, error, sensor.read)
            if not watched.size:
                return None, raised
            reading = Reading(t, [math.nan] * watched.size)
            data = pack(reading.values)
        values = reading.values
        watched.size = len(values)
        event = SensorRead(t=t, agent=self.knowledge.agent, sensor=sensor.name, stamp=reading.stamp, data=data)
        self._sink.emit(event)
        if self._frozen_after < math.inf and self._frozen(watched, data, reading, t):
            problem = f"frozen: the same values for {watched.still:.2f} s while the wheels turned"
        elif not (problem := self.doubt(sensor.name, reading)):
            # What is wrong with a reading that speaks for itself, as NaN or by its stamp.
            if any(map(math.isnan, values)):
                problem = "it says NaN"
            elif t - reading.stamp > self.max_age + 5e-7:
                problem = f"stale: its newest sample is {t - reading.stamp:.2f} s old"
            return reading, raised or problem
        return Reading(reading.stamp, [math.nan] * len(values)), raised or problem

    def _all_invalid(self) -> Signals:
        """All signals of the monitor as NaN."""
        return {signal.name: [math.nan] * signal.size for signal in self.signals()}

    def _frozen(self, watched: Watched, data: bytes, reading: Reading, t: float) -> bool:
        passed, watched.read_at = t - watched.read_at, t
        if data != watched.last or not any(math.isfinite(v) for v in reading.values):
            watched.last, watched.still = data, 0.0
        elif self.varies(watched.sensor.name):
            watched.still += passed
        return watched.still > self._frozen_after

    def _bounded(self, written: Signals) -> tuple[Signals, str]:
        """The signals with NaN for what is out of their bounds, as Knowledge holds them; and what that was."""
        bounded, beyond = {}, ""
        for name, values in written.items():
            low, high = self.knowledge.signals.spec(name).bounds
            kept = bounded[name] = [v if low <= v <= high else math.nan for v in values]
            for value in values if kept != values else ():
                if value < low or value > high:
                    beyond = f"signal '{name}' is out of its bounds [{low:g}, {high:g}]: {value:g}"
        return bounded, beyond

    def _tell(self, watched: Watched, t: float, problem: Problem) -> None:
        agent = self.knowledge.agent
        if problem and not watched.failed:  # once, not twenty times a second
            if isinstance(problem, Raised):
                self._sink.emit(problem.event(t, agent, _INVALID))
            else:
                self._sink.emit(SensorFailed(t=t, agent=agent, sensor=watched.sensor.name, detail=problem))
        watched.failed = bool(problem)

    def _report_exception(self, t: float, error: BaseException) -> None:
        """Report an exception of the monitor itself, once while it goes on to raise."""
        if not self._raises:
            self._raises = True
            raised = Raised.of("monitor", self.name, error, self.interpret)
            self._sink.emit(raised.event(t, self.knowledge.agent, _INVALID))

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
