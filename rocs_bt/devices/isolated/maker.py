"""DeviceMaker: constructor call of a driver, to be executed in the process of an isolated actuator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from ...base.errors import DeviceError
from ...base.python_content import load_class, running_class
from ...declare import constructed
from ...interfaces.device import Actuator
from ..host import Host


class ActuatorMaker(Protocol):
    """Constructor call of an actuator that can be sent to another process (pickled)."""

    @property
    def name(self) -> str:
        """Name of the actuator."""
        ...

    @property
    def two_owners(self) -> bool:
        """Whether the device can be opened in a second process at the same time."""
        ...

    def __call__(self, host: Host) -> Actuator:
        """Construct the actuator.

        Raises:
            InputError: The driver is invalid.
            DeviceError: The device cannot be reached.
        """
        ...


@dataclass(frozen=True)
class DeviceMaker:
    """Class of a user's actuator driver, with its name and the values of its keys.

    Attributes:
        file: Python file of the class.
        cls: Name of the class.
        name: Name of the actuator.
        parameters: Values of its keys, SI units.
        two_owners: Whether the device can be opened in a second process at the same time.
    """

    file: Path
    cls: str
    name: str
    parameters: Mapping[str, Any]
    two_owners: bool = False

    def __call__(self, host: Host) -> Actuator:
        """Construct the driver.

        Raises:
            InputError: The class cannot be loaded, or its constructor raised an exception; with the line.
            DeviceError: The constructor cannot reach the device.
        """
        cls = load_class(self.file, self.cls)
        with running_class(cls, DeviceError):
            device: Actuator = constructed(cls, self.parameters, self.name, host)
        return device
