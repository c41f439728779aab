"""Interfaces of the robot's devices: Sensor and Actuator (paper, 4.1 and 5.3).

Simulation and hardware differ only in the implementations of these interfaces.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import msgspec

NOTABLE_AHEAD = 0.05
"""Time by which stamps are in the future from which clocks are reported [s]."""


class Reading(msgspec.Struct, frozen=True):
    """Reading of a sensor: values with a time stamp.

    Attributes:
        stamp: Time at which the device took the sample [s]. A device that is frozen repeats an old stamp, so that its
            signals become stale.
        values: Values, SI units, sensor frame; +inf is a range without echo, NaN is an invalid value.
    """

    stamp: float
    values: Sequence[float]


class Sensor(ABC):
    """Base class of sensor devices.

    Attributes:
        name: Name of the sensor in robot.toml.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def read(self) -> Reading:
        """Return the newest sample; it must not wait for a new one.

        Raises:
            DeviceError: The device has no sample. The signals of the sensor then become stale, and thus invalid.
        """

    @property
    def clock_ahead(self) -> float:
        """Time by which the clock of the newest stamp is ahead of that of this computer [s]; 0 if it is unknown."""
        return 0.0

    def close(self) -> None:
        """Release the resources of the device; called once at the end."""


class Actuator(ABC):
    """Base class of actuator devices.

    Attributes:
        name: Name of the actuator in robot.toml.
        size: Number of values of a command.
        two_owners: Whether the device can be opened in two processes at the same time, without an effect of the second
            one until it commands. With `isolated = true`, it is then opened in the main process too, at the start of
            the run and not when the isolated process has ended. A class attribute of the driver.
        publishers: Identifiers of the device's publishers on its network; empty without a network that has them.
    """

    # Without annotations, which would make them keys of every driver in robot.toml.
    two_owners = False
    publishers = frozenset[bytes]()

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
            DeviceError: The device rejects the command. The robot is then stopped, and the run ends with the outcome
                `error`, as after any other exception.
        """

    @abstractmethod
    def neutral(self) -> None:
        """Go to a safe state without motion. It must not raise, and may be called at any time from any thread."""

    def close(self) -> None:
        """Release the resources of the device; called once at the end."""
