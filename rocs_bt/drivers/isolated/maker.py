"""DeviceMaker: what the process of an isolated actuator needs to make the device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...device import Actuator
from ...errors import DeviceError
from ...python_content import load_class, running_class
from ..host import Host


@dataclass(frozen=True)
class DeviceMaker:
    """A user's own Actuator class, and its arguments.

    Attributes:
        file: The Python file of the class.
        cls: The name of the class in it.
        name: The name of the actuator.
        parameters: The constructor's keyword arguments, in SI units.
    """

    file: Path
    cls: str
    name: str
    parameters: Mapping[str, Any]

    def __call__(self, host: Host) -> Actuator:
        """The device.

        Raises:
            InputError: The class does not load, or its constructor raised; with the line.
            DeviceError: The constructor cannot reach the device.
        """
        cls = load_class(self.file, self.cls)
        with running_class(cls, DeviceError):
            device: Actuator = cls(self.name, host, **self.parameters)
        return device
