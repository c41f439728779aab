"""Form of signals, readings and commands in a recording: named numbers, which viewers plot, and each scan once.

In memory these events have packed values. In a recording, values are JSON numbers; only a reading of many values, such
as a scan, stays packed, and a signal that repeats a part of its sensor's last reading refers to it.
"""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import getitem
from typing import Any

import msgspec

from ...base.errors import RecordingError
from ...event import ActuatorCommanded, Event, SensorRead, SignalsWritten, unpack

WIDE = 16
"""Number of values from which on values stay packed, or refer to a reading."""

_LATEST = 1e10  # [s] times beyond it are not recorded
_DOUBLE = struct.Struct(">d")
_TAG = {"tag_field": "event", "frozen": True, "kw_only": True, "omit_defaults": True}

Number = float | None
"""Number of a message; None if it is not finite: `non_finite` has its bits."""

NonFinite = list[list[str | int]]


class Repeat(msgspec.Struct, frozen=True):
    """Values of the last reading of a sensor: `count` values from the index `first` on."""

    sensor: str
    first: int
    count: int


class Signals(msgspec.Struct, tag="Signals", **_TAG):
    """SignalsWritten with values by signal."""

    t: float
    agent: str
    monitor: str
    values: dict[str, Number | list[Number] | Repeat]
    stamp: float | None = None
    non_finite: NonFinite = []


class Reading(msgspec.Struct, tag="Reading", **_TAG):
    """SensorRead with its values as numbers."""

    t: float
    agent: str
    sensor: str
    stamp: float
    values: list[Number]
    non_finite: NonFinite = []


class Command(msgspec.Struct, tag="Command", **_TAG):
    """ActuatorCommanded with values by axis or wheel."""

    t: float
    agent: str
    actuator: str
    route: str
    values: dict[str, Number]
    non_finite: NonFinite = []


FORMS = Signals | Reading | Command
"""Forms of events in a recording."""


def device_of(message: Event | FORMS) -> str:
    """Sensor or actuator of a reading or a command in the form of a recording, the last part of its topic."""
    if isinstance(message, Reading):
        return message.sensor
    return message.actuator if isinstance(message, Command) else ""


class Outgoing:
    """Makes the messages of a recording from its events, in their order."""

    def __init__(self, axes: Mapping[str, Sequence[str]] = {}) -> None:
        self._axes = axes
        self._readings: dict[str, dict[str, bytes]] = {}
        self._found: dict[tuple[str, str], tuple[str, int]] = {}

    def forget(self) -> None:
        """Repeat no reading so far, because it may not have been recorded."""
        self._readings.clear()

    def form(self, event: Event) -> Event | FORMS:
        """The message of an event; the event itself if it has no other form."""
        # The type is compared, which is faster than isinstance: this is called for each event of a run.
        if type(event) is SignalsWritten:
            return self._signals(event) if _finite(event.t, event.stamp) else event
        if type(event) is SensorRead:
            return self._reading(event) if _finite(event.t, event.stamp) else event
        if type(event) is ActuatorCommanded:
            return self._command(event) if _finite(event.t, None) else event
        return event

    def _signals(self, event: SignalsWritten) -> Event | Signals:
        sizes = event.sizes
        fits = len(sizes) == len(set(event.signals)) == len(event.signals) and min(sizes, default=0) >= 0
        if not fits or 8 * sum(sizes) != len(event.data):
            return event
        values, lost, at = dict[str, Any](), NonFinite(), 0
        for name, size in zip(event.signals, sizes, strict=True):
            part = event.data[8 * at : 8 * (at + size)]
            at += size
            repeat = self._repeat(event.agent, name, part) if size > WIDE else None
            if repeat is None:
                numbers = unpack(part)
                values[name] = numbers[0] if size == 1 else numbers
                if not math.isfinite(sum(numbers)):
                    lost += non_finite(values[name], ("values", name))
            else:
                values[name] = repeat
        return Signals(
            t=event.t, agent=event.agent, monitor=event.monitor, values=values, stamp=event.stamp, non_finite=lost
        )

    def _repeat(self, agent: str, signal: str, part: bytes) -> Repeat | None:
        readings = self._readings.get(agent, {})
        sensor, at = self._found.get((agent, signal), ("", 0))
        if readings.get(sensor, b"")[at : at + len(part)] != part:
            places = ((sensor, data.find(part)) for sensor, data in readings.items())
            sensor, at = next(((sensor, at) for sensor, at in places if at >= 0 and at % 8 == 0), ("", -1))
            if at < 0:
                return None
            self._found[agent, signal] = sensor, at
        return Repeat(sensor, at // 8, len(part) // 8)

    def _reading(self, event: SensorRead) -> Event | Reading:
        count, rest = divmod(len(event.data), 8)
        if rest:
            return event
        if count > WIDE:
            if 0.0 <= event.t <= _LATEST:
                self._readings.setdefault(event.agent, {})[event.sensor] = event.data
            return event
        values, lost = unpack(event.data), NonFinite()
        if not math.isfinite(sum(values)):
            lost += non_finite(values, ("values",))
        return Reading(
            t=event.t, agent=event.agent, sensor=event.sensor, stamp=event.stamp, values=[*values], non_finite=lost
        )

    def _command(self, event: ActuatorCommanded) -> Event | Command:
        if len(event.data) % 8:
            return event
        values, lost = unpack(event.data), NonFinite()
        axes = self._axes.get(event.agent, ())
        if len(axes) != len(values):
            axes = ("left", "right") if len(values) == 2 else [f"wheel_{i}" for i in range(1, len(values) + 1)]
        given: dict[str, Number] = dict(zip(axes, values, strict=True))
        if not math.isfinite(sum(values)):
            lost += non_finite(given, ("values",))
        return Command(
            t=event.t, agent=event.agent, actuator=event.actuator, route=event.route, values=given, non_finite=lost
        )


class Incoming:
    """Makes events from the messages of a recording, in their order."""

    def __init__(self) -> None:
        self._readings: dict[tuple[str, str], bytes] = {}

    def event(self, message: Any) -> Event:
        """The event of a message.

        Raises:
            RecordingError: The message, of a damaged recording, repeats what was not read.
        """
        if isinstance(message, FORMS) and message.non_finite:
            restore({"values": message.values}, message.non_finite)
        if isinstance(message, Signals):
            return self._signals(message)
        if isinstance(message, Reading):
            return SensorRead(
                t=message.t, agent=message.agent, sensor=message.sensor, stamp=message.stamp, data=_pack(message.values)
            )
        if isinstance(message, Command):
            return ActuatorCommanded(
                t=message.t,
                agent=message.agent,
                actuator=message.actuator,
                route=message.route,
                data=_pack(message.values.values()),
            )
        event: Event = message
        if isinstance(event, SensorRead):
            self._readings[event.agent, event.sensor] = event.data
        return event

    def _signals(self, message: Signals) -> SignalsWritten:
        parts = [self._part(message, value) for value in message.values.values()]
        return SignalsWritten(
            t=message.t,
            agent=message.agent,
            monitor=message.monitor,
            signals=tuple(message.values),
            sizes=tuple(len(part) // 8 for part in parts),
            data=b"".join(parts),
            stamp=message.stamp,
        )

    def _part(self, message: Signals, value: Number | list[Number] | Repeat) -> bytes:
        if isinstance(value, Repeat):
            reading = self._readings.get((message.agent, value.sensor), b"")
            part = reading[8 * value.first : 8 * (value.first + value.count)]
            if len(part) != 8 * value.count or value.first < 0:
                raise RecordingError(
                    f"the signals of '{message.monitor}' repeat a reading of '{value.sensor}' at "
                    f"t = {message.t:g} s that was not recorded."
                )
            return part
        return _pack(value if isinstance(value, list) else (value,))


def non_finite(value: Any, where: tuple[str | int, ...] = ()) -> Iterator[list[str | int]]:
    """Places of the numbers in plain data that are not finite, each with the bits of the number."""
    if isinstance(value, float) and not math.isfinite(value):
        yield [*where, _DOUBLE.pack(value).hex()]
    elif isinstance(value, (dict, list, tuple)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from non_finite(inner, (*where, key))


def restore(value: Any, found: Iterable[Sequence[Any]]) -> None:
    """Put back into plain data the numbers that `non_finite` has found.

    Raises:
        RecordingError: A place does not exist, or has no bits.
    """
    try:
        for *where, last, bits in found:
            reduce(getitem, where, value)[last] = _DOUBLE.unpack(bytes.fromhex(bits))[0]
    except (LookupError, TypeError, ValueError, struct.error) as error:
        raise RecordingError(f"numbers of a message that are not finite cannot be read back: {error!r}.") from error


def _finite(t: float, stamp: float | None) -> bool:
    """Whether the time and the stamp of an event can be written into a message."""
    return math.isfinite(t if stamp is None else t + stamp)


def _pack(values: Iterable[Number]) -> bytes:
    return array("d", [math.nan if value is None else value for value in values]).tobytes()
