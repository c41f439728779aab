"""Interfaces to the robot's devices: Sensor and Actuator (paper, 4.1 and 5.3).

Only their implementations differ between simulation and hardware.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import msgspec


class Reading(msgspec.Struct, frozen=True):
    """Sample of a sensor.

    Attributes:
        stamp: Time at which the device took the sample [s]. A frozen device repeats an old stamp, so its signals
            become stale.
        values: Values, SI units, sensor frame; +inf is a range without echo, NaN is an invalid value.
    """

    stamp: float
    values: Sequence[float]


class Sensor(ABC):
    """Sensor device.

    Attributes:
        name: Name in robot.toml.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def read(self) -> Reading:
        """Newest sample; must return without waiting.

        Raises:
            DeviceError: The device has no sample; its signals become stale and thus invalid.
        """

    def close(self) -> None:
        """Release the resources of the device; called once at the end."""


class Actuator(ABC):
    """Actuator device.

    Attributes:
        name: Name in robot.toml.
        size: Number of values of a command.
    """

    def __init__(self, name: str, size: int) -> None:
        self.name = name
        self.size = size

    @abstractmethod
    def command(self, values: Sequence[float]) -> None:
        """Command the device.

        Args:
            values: Values of the command, SI units, shape (size,). Wheels take linear speeds [m/s], in the order of the
                drive's wheels.

        Raises:
            DeviceError: The device rejects the command. As at any other exception, the robot is stopped and the run
                ends with the outcome `error`.
        """

    @abstractmethod
    def neutral(self) -> None:
        """Go to a safe state without motion; must not raise, and may be called at any time from any thread."""

    def close(self) -> None:
        """Release the resources of the device; called once at the end."""
