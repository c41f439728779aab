"""The touch-points with the robot: Sensor and Actuator (paper, 4.1 and 5.3).

Only these two differ between simulation and hardware.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import msgspec


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
            DeviceError: The device does not take the command. As at any other exception, the robot is stopped and the
                run ends with the outcome `error`.
        """

    @abstractmethod
    def neutral(self) -> None:
        """Stop acting, safely; must not raise, may be called at any time and from any thread."""

    def close(self) -> None:
        """Let go of what the device holds; called once at the end."""
