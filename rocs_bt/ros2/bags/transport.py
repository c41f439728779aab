"""BagTransport: a bag in place of a ROS 2 network, by the clock of a run."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Collection
from typing import NoReturn

from ...base.clock import Clock
from ...base.errors import DeviceError, Fault, InputError, RecordingError
from ..messages.type_store import TypeStore
from ..network.qos import QoS
from ..network.transport import Endpoint, Sample
from .bag_file import Bag, BagMessage

CLOCK, CLOCK_TYPE = "/clock", "rosgraph_msgs/msg/Clock"

MAX_GAP = 3600.0
"""Time without any message that is not replayed [s]: the clock of the computer was set while it recorded."""


class BagTransport:
    """Transport that gives the messages of a bag to its readers, each when the clock reaches the time of its recording.

    `advance` must be called once per control period, before the sensors are read.

    Args:
        bag: Opened bag.
        topics: Full names of the topics that will be read.
        clock: Clock of the run; its time 0 is the start of the bag, or `start` after it.
        distro: Distribution of ROS 2, for types that the bag does not define.
        start: Time at which the run begins, since the start of the bag [s].
        duration: Maximum duration of the run [s].
        use_sim_time: Whether the time is that of the topic `/clock` in the bag, in place of the times of recording.

    Raises:
        InputError: A type is unknown, or is not that of the distribution; contains all faults.
        RecordingError: The bag is damaged.
    """

    name = "bag"

    def __init__(
        self,
        bag: Bag,
        topics: Collection[str],
        clock: Clock,
        *,
        distro: str = "jazzy",
        start: float = 0.0,
        duration: float = math.inf,
        use_sim_time: bool = False,
    ) -> None:
        self._bag = bag
        self._clock = clock
        clocks = [CLOCK] if use_sim_time and CLOCK in bag.topics else []
        self.types: TypeStore = bag.types(distro, [*topics, *clocks])
        self._ticks = [(m.time, self._tick(m)) for m in bag.messages(clocks)]
        self._times = [time for time, _ in self._ticks]
        self._begin = self._stamp(bag.start) + round(start * 1e9)
        self._end = self._begin + round(min(duration, 1e9) * 1e9)
        self._readers: dict[str, list[BagReader]] = {}
        self._messages = bag.messages(topics)
        self._next: BagMessage | None = None
        self._fetch(self._begin)

    def reader(self, topic: str, type: str, qos: QoS) -> BagReader:
        reader = BagReader(topic, type, qos.depth)
        self._readers.setdefault(topic, []).append(reader)
        return reader

    def writer(self, topic: str, type: str, qos: QoS) -> NoReturn:
        """Refuse a publisher.

        Raises:
            InputError: Always.
        """
        raise InputError(Fault(f"nothing can be published on '{topic}' ({type}): the bag is only read."))

    @property
    def _now(self) -> int:
        """Present time [ns since 1970]."""
        return self._begin + round(self._clock.now() * 1e9)

    def endpoints(self) -> list[Endpoint]:
        """Topics of the bag."""
        return [Endpoint(name, each.type, "bag", True, QoS.LATCHED) for name, each in self._bag.topics.items()]

    def now(self) -> float:
        return self._now * 1e-9

    def close(self) -> None:
        """Close the bag."""
        self._bag.close()

    @property
    def ended(self) -> bool:
        """Whether all messages of the run have been given."""
        return self._next is None

    def advance(self) -> None:
        """Give all messages up to the present time to their readers.

        Raises:
            RecordingError: The bag is damaged, or has a gap of more than an hour.
        """
        now = self._now
        while (message := self._next) is not None and (stamp := self._stamp(message.time)) <= now:
            sample = Sample(message.data, stamp * 1e-9)
            for reader in self._readers.get(message.topic, ()):
                reader.samples.append(sample)
            self._fetch(max(stamp, self._begin))

    def _fetch(self, before: int) -> None:
        """Fetch the next message; refuses a long time without a message, from a time [ns] on."""
        self._next = next(self._messages, None)
        if self._next is not None and self._stamp(self._next.time) > self._end:
            self._next = None
        if self._next is None or (gap := (self._stamp(self._next.time) - before) * 1e-9) <= MAX_GAP:
            return
        at = (before - self._stamp(self._bag.start)) * 1e-9
        raise RecordingError(
            f"the bag '{self._bag.path}' has no message for {gap:.0f} s from {at:.1f} s on: the clock was set while it "
            "was recorded. Replay a part of it with --from and --for."
        )

    def _tick(self, message: BagMessage) -> int:
        try:
            clock = self.types.deserialize(message.data, CLOCK_TYPE).clock
        except DeviceError as error:
            raise RecordingError(f"the bag '{self._bag.path}' is damaged: {CLOCK}: {error}.") from error
        return int(clock.sec) * 1_000_000_000 + int(clock.nanosec)

    def _stamp(self, time: int) -> int:
        """Time [ns] at which a message was recorded; with simulated time, that of the newest tick."""
        return self._ticks[max(0, bisect_right(self._times, time) - 1)][1] if self._ticks else time


class BagReader:
    """Subscription of a topic in a bag."""

    def __init__(self, topic: str, type: str, depth: int) -> None:
        self.topic = topic
        self.type = type
        self.samples: deque[Sample] = deque(maxlen=depth)

    def take(self) -> Sample | None:
        samples = self.take_all()
        return samples[-1] if samples else None

    def take_all(self) -> list[Sample]:
        samples = list(self.samples)
        self.samples.clear()
        return samples

    def close(self) -> None:
        """Drop all messages."""
        self.samples.clear()
