"""Publishing between blocks: stamped samples into bounded inboxes.

The paper's Publisher and Observer. There is no generic `attach` here on purpose: `Monitor.attach(Analyze)` and
`Analyze.attach(Plan)` are the only wires (paper, 5.1).
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar

import msgspec

from .errors import Fault, WiringError
from .event import Change

T = TypeVar("T")

Signals = Mapping[str, Sequence[float]]
"""What a Monitor publishes: the values of its signals by name, SI units."""


class Stamped(msgspec.Struct, Generic[T], frozen=True):
    """A value with the time it is about [s] and the block or device it comes from."""

    t: float
    source: str
    value: T


class Inbox(Generic[T]):
    """What an observer has not looked at yet: bounded, thread-safe, oldest first.

    Any number of publishers may put into one inbox. When it is full the oldest sample is dropped and counted:
    for control, new data is worth more than old.

    Args:
        capacity: How many samples it holds.
    """

    def __init__(self, capacity: int = 64) -> None:
        self._samples: deque[Stamped[T]] = deque(maxlen=capacity)
        self._lock = threading.Lock()
        self._arrived = threading.Condition(self._lock)
        self._waiting = 0
        self.overflows = 0

    def put(self, sample: Stamped[T]) -> None:
        """Leave a sample, and wake whoever waits."""
        with self._lock:
            if len(self._samples) == self._samples.maxlen:
                self.overflows += 1
            self._samples.append(sample)
            if self._waiting:
                self._arrived.notify_all()

    @property
    def pending(self) -> bool:
        """Whether something is there to drain."""
        return bool(self._samples)

    def drain(self) -> list[Stamped[T]]:
        """Take everything that is there; empty when nothing is."""
        with self._lock:
            samples = list(self._samples)
            self._samples.clear()
        return samples

    def wake(self) -> None:
        """Wake whoever waits, without a sample."""
        with self._lock:
            self._arrived.notify_all()

    def wait(self, timeout: float, stop: Callable[[], bool]) -> bool:
        """Wait until something is there, `stop()` is true, or the timeout [s] passed; True when something is."""
        with self._lock:
            self._waiting += 1
            try:
                self._arrived.wait_for(lambda: bool(self._samples) or stop(), timeout)
            finally:
                self._waiting -= 1
            return bool(self._samples)


class Publisher(Generic[T]):
    """The publishing end of a block: hands each sample to every inbox that was connected."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._inboxes: list[Inbox[T]] = []

    def connect(self, inbox: Inbox[T]) -> None:
        """Hand samples to this inbox too; connecting the same one twice changes nothing."""
        if inbox not in self._inboxes:
            self._inboxes.append(inbox)

    def publish(self, t: float, value: T) -> None:
        """Hand a value, stamped and signed, to every inbox."""
        sample = Stamped(t, self.name, value)
        for inbox in self._inboxes:
            inbox.put(sample)


class MonitorSubscriber:
    """The end of the wire from Monitor: Analyze is one, and nothing else may be attached (paper, 4.2 and 5.1)."""

    def __init__(self) -> None:
        self.inbox: Inbox[Signals] = Inbox()


class AnalyzeSubscriber:
    """The end of the wire from Analyze: Plan is one, and nothing else may be attached (paper, 4.2 and 5.1)."""

    def __init__(self) -> None:
        self.inbox: Inbox[Change] = Inbox()


def check_wire(source: str, target: object, wanted: type) -> None:
    """Refuse a wire that the architecture does not have.

    Raises:
        WiringError: The target is not of the wanted kind.
    """
    if not isinstance(target, wanted):
        want = "an Analyze" if wanted is MonitorSubscriber else "a Plan"
        raise WiringError(
            Fault(
                f"{source} can be attached to {want} only, found {type(target).__name__}.",
                hint="The wires are Monitor -> Analyze -> Plan.",
            )
        )
