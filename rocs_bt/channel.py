"""Publishing between blocks: stamped samples into bounded inboxes.

The paper's Publisher and Observer. There is deliberately no generic `attach`: `Monitor.attach(Analyze)` and
`Analyze.attach(Plan)` are the only connections (paper, 5.1).
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
"""Values that a Monitor publishes, by signal name, SI units."""


class Stamped(msgspec.Struct, Generic[T], frozen=True):
    """A value, the time it refers to [s] and its source: a block or device."""

    t: float
    source: str
    value: T


class Inbox(Generic[T]):
    """Bounded, thread-safe queue of the samples that an observer has not read yet, oldest first.

    Any number of publishers may put into one inbox. A full inbox drops its oldest sample and counts it in
    `overflows`: for control, new data is worth more than old.

    Args:
        capacity: Maximum number of samples.
    """

    def __init__(self, capacity: int = 64) -> None:
        self._samples: deque[Stamped[T]] = deque(maxlen=capacity)
        self._lock = threading.Lock()
        self._arrived = threading.Condition(self._lock)
        self._waiting = 0
        self.overflows = 0

    def put(self, sample: Stamped[T]) -> None:
        """Add a sample and wake the waiting threads."""
        with self._lock:
            if len(self._samples) == self._samples.maxlen:
                self.overflows += 1
            self._samples.append(sample)
            if self._waiting:
                self._arrived.notify_all()

    @property
    def pending(self) -> bool:
        """Whether there are samples to drain."""
        return bool(self._samples)

    def drain(self) -> list[Stamped[T]]:
        """Remove and return all samples."""
        with self._lock:
            samples = list(self._samples)
            self._samples.clear()
        return samples

    def wake(self) -> None:
        """Wake the waiting threads without a sample."""
        with self._lock:
            self._arrived.notify_all()

    def wait(self, timeout: float, stop: Callable[[], bool]) -> bool:
        """Wait until there is a sample, `stop()` is true or the timeout [s] has passed; True if there is a sample."""
        with self._lock:
            self._waiting += 1
            try:
                self._arrived.wait_for(lambda: bool(self._samples) or stop(), timeout)
            finally:
                self._waiting -= 1
            return bool(self._samples)


class Publisher(Generic[T]):
    """Publishing end of a block: puts each sample into every connected inbox."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._inboxes: list[Inbox[T]] = []

    def connect(self, inbox: Inbox[T]) -> None:
        """Also publish to this inbox; connecting it twice has no effect."""
        if inbox not in self._inboxes:
            self._inboxes.append(inbox)

    def publish(self, t: float, value: T) -> None:
        """Put a value, stamped with its time and source, into every inbox."""
        sample = Stamped(t, self.name, value)
        for inbox in self._inboxes:
            inbox.put(sample)


class MonitorSubscriber:
    """Receiver of a Monitor's samples; only an Analyze is one (paper, 4.2 and 5.1)."""

    def __init__(self) -> None:
        self.inbox: Inbox[Signals] = Inbox()


class AnalyzeSubscriber:
    """Receiver of an Analyze's changes; only a Plan is one (paper, 4.2 and 5.1)."""

    def __init__(self) -> None:
        self.inbox: Inbox[Change] = Inbox()


def check_wire(source: str, target: object, wanted: type) -> None:
    """Reject a connection that the architecture does not allow.

    Raises:
        WiringError: The target is not of the wanted type.
    """
    if not isinstance(target, wanted):
        want = "an Analyze" if wanted is MonitorSubscriber else "a Plan"
        raise WiringError(
            Fault(
                f"{source} can be attached to {want} only, found {type(target).__name__}.",
                hint="The connections are Monitor -> Analyze -> Plan.",
            )
        )
