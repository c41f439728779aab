"""`driver = "thermometer"`: a sensor that reads a temperature [°C] from a file, as a serial device writes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from rocs_bt import DeviceError, Sensor
from rocs_bt.catalog.registered_devices import RegisteredDevices
from rocs_bt.declare import Value
from rocs_bt.interfaces.device import Reading


class Keys(Value):
    """Keys of the sensor in robot.toml."""

    size: ClassVar[int] = 1
    port: str


def celsius(port: Path) -> float:
    """The temperature at a port [°C]."""
    try:
        return float(port.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise DeviceError(f"no temperature at '{port}': {error}.") from error


class Thermometer(Sensor):
    """Sensor of one temperature."""

    def __init__(self, name: str, port: Path, clock: Any) -> None:
        super().__init__(name)
        self.port, self.clock = port, clock

    def read(self) -> Reading:
        """The present temperature."""
        return Reading(self.clock.now(), [celsius(self.port)])


DRIVER = RegisteredDevices(
    title="a thermometer",
    keys={"sensor": Keys},
    sensor=lambda robot, spec, host, rate: Thermometer(spec.name, Path(spec.parameters.port), host.clock),
)
