"""Publish and subscribe between the blocks of an agent: stamped samples are put into bounded inboxes.

These are the paper's Publisher and Observer. There is deliberately no generic `attach`: `Monitor.attach(Analyze)` and
`Analyze.attach(Plan)` are the only connections that the architecture allows (paper, 5.1).
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar

import msgspec

from ..base.errors import Fault, WiringError
from ..event import Change

T = TypeVar("T")

Signals = Mapping[str, Sequence[float]]
"""Values that a Monitor publishes, by signal name, SI units."""


class Stamped(msgspec.Struct, Generic[T], frozen=True):
    """Sample: a value with the time to which it refers [s] and its source, the name of a block or device."""

    t: float
    source: str
    value: T


class Inbox(Generic[T]):
    """Bounded, thread-safe queue of the samples that a subscriber has not read yet, oldest first.

    Any number of publishers may put samples into one inbox. A full inbox drops its oldest sample and counts this in
    `overflows`, because control needs new data more than old.
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
        """Whether there are unread samples."""
        return bool(self._samples)

    def drain(self) -> list[Stamped[T]]:
        """Remove all samples from the inbox and return them, oldest first."""
        with self._lock:
            samples = list(self._samples)
            self._samples.clear()
        return samples

    def wake(self) -> None:
        """Wake the waiting threads without a sample."""
        with self._lock:
            self._arrived.notify_all()

    def wait(self, timeout: float, stop: Callable[[], bool]) -> bool:
        """Wait until a sample exists, `stop()` is true, or the timeout [s] has passed; returns whether one exists."""
        with self._lock:
            self._waiting += 1
            try:
                self._arrived.wait_for(lambda: bool(self._samples) or stop(), timeout)
            finally:
                self._waiting -= 1
            return bool(self._samples)


class Publisher(Generic[T]):
    """Publisher of a block, which puts each sample into every connected inbox."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._inboxes: list[Inbox[T]] = []

    def connect(self, inbox: Inbox[T]) -> None:
        """Connect an inbox, to which samples are then published; connecting it twice has no effect."""
        if inbox not in self._inboxes:
            self._inboxes.append(inbox)

    def publish(self, t: float, value: T) -> None:
        """Put a value, stamped with time [s] and source, into every connected inbox."""
        sample = Stamped(t, self.name, value)
        for inbox in self._inboxes:
            inbox.put(sample)


class MonitorSubscriber:
    """Base of receivers of a monitor's samples; only analysers may receive them (paper, 4.2 and 5.1)."""

    def __init__(self) -> None:
        self.inbox: Inbox[Signals] = Inbox()


class AnalyzeSubscriber:
    """Base of receivers of an analyser's Changes; only a Plan may receive them (paper, 4.2 and 5.1)."""

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
