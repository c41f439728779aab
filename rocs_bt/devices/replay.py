"""Replay backend: sensors that return recorded readings, and actuators that only log commands."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from ..base.clock import Clock
from ..base.errors import DeviceError
from ..base.raised import RecordedException
from ..event import ContentRaised, Event, SensorFailed, SensorRead
from ..interfaces.device import Actuator, Reading, Sensor
from ..interfaces.message import MessageQueue, packed

SensorEvent = SensorRead | SensorFailed | ContentRaised
"""Recorded events from which a sensor is replayed."""

_SAME = 5e-7  # [s] maximum difference of times that count as equal


class ReplaySensor(Sensor):
    """Sensor that returns the recorded reading of the present time, or fails or raises as in the recording."""

    def __init__(self, name: str, clock: Clock, events: Iterable[SensorEvent]) -> None:
        super().__init__(name)
        self._clock = clock
        self._events = deque(events)
        self._detail = f"the recording has no reading of sensor '{name}' at this time"

    def read(self) -> Reading:
        now, found = self._clock.now(), None
        while self._events and self._events[0].t <= now + _SAME:
            event = self._events.popleft()
            if isinstance(event, SensorFailed):
                self._detail = event.detail
            elif event.t >= now - _SAME:
                if isinstance(event, ContentRaised):
                    raise RecordedException(event.raised)
                found = event
        if found is None:
            raise DeviceError(self._detail)
        return Reading(found.stamp, found.values)


class ReplayMailbox(Sensor):
    """Mailbox with the messages that the replayed agents send each other during the replay."""

    def __init__(self, name: str, clock: Clock) -> None:
        super().__init__(name)
        self.message_queue = MessageQueue()
        self._clock = clock

    def read(self) -> Reading:
        return Reading(self._clock.now(), packed(self.message_queue.take()))


class ReplayActuator(Actuator):
    """Actuator that only logs its commands.

    Attributes:
        commands: Commands so far, each as time [s] and values, SI units; neutral is logged as zeros.
    """

    def __init__(self, name: str, size: int, clock: Clock) -> None:
        super().__init__(name, size)
        self._clock = clock
        self.commands: list[tuple[float, tuple[float, ...]]] = []

    def command(self, values: Sequence[float]) -> None:
        self.commands.append((self._clock.now(), tuple(float(v) for v in values)))

    def neutral(self) -> None:
        self.commands.append((self._clock.now(), (0.0,) * self.size))


def replay_sensors(events: Iterable[Event], agent: str, names: Iterable[str], clock: Clock) -> dict[str, ReplaySensor]:
    """Create the sensors of one agent that replay recorded events; a sensor without events fails when it is read."""
    mine: dict[str, list[SensorEvent]] = {name: [] for name in names}
    for event in events:
        if isinstance(event, SensorEvent) and event.agent == agent and (name := _sensor_of(event)) in mine:
            mine[name].append(event)
    return {name: ReplaySensor(name, clock, found) for name, found in mine.items()}


def _sensor_of(event: SensorEvent) -> str:
    """Name of the sensor that an event is about; empty for an exception of other content."""
    if isinstance(event, ContentRaised):
        return event.content if event.kind == "sensor" else ""
    return event.sensor
