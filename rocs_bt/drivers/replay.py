"""Replay: sensors that say again what a recording holds, and actuators that only note what they are asked."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from ..clock import Clock
from ..device import Actuator, Reading, Sensor
from ..errors import DeviceError
from ..event import ContentRaised, Event, SensorFailed, SensorRead
from ..knowledge.share import MessageQueue, packed
from ..raised import Raised, RecordedException

SensorEvent = SensorRead | SensorFailed | ContentRaised
"""What a recording holds of a sensor."""

_SAME = 5e-7  # [s] within which two times are one


class ReplaySensor(Sensor):
    """Says at each time what the recorded sensor said then; refuses or raises where that one did.

    Args:
        name: The sensor's name.
        clock: Time.
        events: Its events, in the order they were recorded.
    """

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
                    raise RecordedException(Raised.recorded(event))
                found = event
        if found is None:
            raise DeviceError(self._detail)
        return Reading(found.stamp, found.values)


class ReplayMailbox(Sensor):
    """A mailbox, into which what was said comes again as the replayed minds say it to each other."""

    def __init__(self, name: str, clock: Clock) -> None:
        super().__init__(name)
        self.message_queue = MessageQueue()
        self._clock = clock

    def read(self) -> Reading:
        return Reading(self._clock.now(), packed(self.message_queue.take()))


class ReplayActuator(Actuator):
    """Notes commands and moves nothing.

    Attributes:
        commands: The commands so far: when [s], and the values [SI]; neutral is all zeros.
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
    """One agent's sensors, fed from recorded events; a sensor that was never read refuses.

    Args:
        events: A recording's, in their order.
        agent: Whose sensors.
        names: The sensors that there must be.
        clock: Time.
    """
    mine: dict[str, list[SensorEvent]] = {name: [] for name in names}
    for event in events:
        if isinstance(event, SensorEvent) and event.agent == agent and (name := _sensor_of(event)) in mine:
            mine[name].append(event)
    return {name: ReplaySensor(name, clock, found) for name, found in mine.items()}


def _sensor_of(event: SensorEvent) -> str:
    """The sensor that an event is about; empty for an exception of other content."""
    if isinstance(event, ContentRaised):
        return event.content if event.kind == "sensor" else ""
    return event.sensor
