"""The touch-points with the robot: Sensor and Actuator (paper, 4.1 and 5.3), and the actuator's watchdog.

Only these two differ between simulation and hardware.
"""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import msgspec

from .clock import Clock
from .errors import DeviceError


class Reading(msgspec.Struct, frozen=True):
    """One sample of a sensor.

    Attributes:
        stamp: When the device took it [s]. A frozen device repeats an old stamp, and so goes stale.
        values: SI units, in the sensor's frame; a range without echo is +inf, NaN is a broken value.
    """

    stamp: float
    values: Sequence[float]


class Sensor(ABC):
    """A sensing device.

    Attributes:
        name: The name that robot.toml gives it.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def read(self) -> Reading:
        """The newest sample; must return at once.

        Raises:
            DeviceError: The device refuses; its signals go stale and so invalid.
        """

    def close(self) -> None:
        """Let go of what the device holds; called once at the end."""


class Actuator(ABC):
    """An acting device.

    Attributes:
        name: The name that robot.toml gives it.
        size: How many values a command has.
    """

    def __init__(self, name: str, size: int) -> None:
        self.name = name
        self.size = size

    @abstractmethod
    def command(self, values: Sequence[float]) -> None:
        """Act on these values, in SI units (wheels: rim speeds [m/s], in the drive's order).

        Raises:
            DeviceError: The device refuses; Execute stops the robot and reports it.
        """

    @abstractmethod
    def neutral(self) -> None:
        """Stop acting, safely; must not raise, may be called at any time and from any thread."""

    def close(self) -> None:
        """Let go of what the device holds; called once at the end."""


class Watchdog(Actuator):
    """An actuator that goes to neutral when no command has come for `max_age` [s]: a dead mind cannot drive.

    It stands on the actuator's side: whoever moves the device (the physics loop, a driver's own thread) calls `check`.

    Args:
        actuator: The guarded device.
        clock: Where time is read.
        max_age: Longest silence [s].
        on_expiry: Called once when it goes to neutral, with the time [s].

    Attributes:
        actuator: The guarded device.
    """

    def __init__(
        self,
        actuator: Actuator,
        clock: Clock,
        max_age: float,
        on_expiry: Callable[[float], None] = lambda t: None,
    ) -> None:
        super().__init__(actuator.name, actuator.size)
        self.actuator = actuator
        self._clock = clock
        self._max_age = max_age
        self._on_expiry = on_expiry
        self._lock = threading.Lock()
        self._last: float | None = None
        self._shut = False
        self._stops = 0  # how often it was sent to neutral

    @property
    def expiry(self) -> float:
        """When it goes to neutral unless a command comes before [s]; +inf while it is neutral."""
        last = self._last
        return math.inf if last is None else last + self._max_age

    def command(self, values: Sequence[float]) -> None:
        with self._lock:
            if self._shut:
                raise DeviceError(f"actuator '{self.name}' was shut after a failure and takes no more commands.")
            stops = self._stops
            self.actuator.command(values)
            self._last = self._clock.now()
            if self._stops != stops:  # somebody stopped it while the command was on its way: that holds
                self.actuator.neutral()
                self._last = None

    def neutral(self) -> None:
        self._neutral()

    def shut(self) -> None:
        """Go to neutral for good: whoever still commands is refused. Works while a command hangs in the device."""
        self._shut = True
        self._neutral()

    def check(self) -> bool:
        """Go to neutral if the last command is too old; True if it did so now."""
        last, now = self._last, self._clock.now()
        # Half a microsecond forgives the rounding of k * step: an age of exactly max_age still drives.
        if last is None or now - last <= self._max_age + 5e-7:
            return False
        self._neutral()
        self._on_expiry(now)
        return True

    def close(self) -> None:
        self.actuator.close()

    def _neutral(self) -> None:
        # A device may hang in `command` while it holds the lock; stopping must not wait for it. Counted first, so that
        # a command that comes out of the device after this finds that it was stopped.
        self._stops += 1
        held = self._lock.acquire(timeout=0.02)
        try:
            self.actuator.neutral()
            self._last = None
        finally:
            if held:
                self._lock.release()
