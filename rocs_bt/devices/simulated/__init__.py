"""Devices in simulation, one class each: its fields are the keys in robot.toml, and `bind` makes a device of a robot.

A device belongs to a world: that of MuJoCo, or a flat world without physics.
"""

from collections.abc import Mapping

from ...base.registered import load, registered
from ...declare import Value
from .device import SimulatedActuator, SimulatedSensor
from .others import Battery, MailboxSensor, RobotSensor
from .pose import Attitude, Gyro, Height, Odometer, Orientation, PoseSensor, Position, TwistSensor
from .ranges import Lidar, RangeCone
from .scene import Scene
from .wheels import Velocity, WheelSpeed, WheelTravel

__all__ = [
    "ACTUATORS",
    "DEVICES",
    "SENSORS",
    "Attitude",
    "Battery",
    "Gyro",
    "Height",
    "Lidar",
    "MailboxSensor",
    "Odometer",
    "Orientation",
    "PoseSensor",
    "Position",
    "RangeCone",
    "RobotSensor",
    "Scene",
    "SimulatedActuator",
    "SimulatedSensor",
    "TwistSensor",
    "Velocity",
    "WheelSpeed",
    "WheelTravel",
    "declared_keys",
]

SENSORS: Mapping[str, type[SimulatedSensor]] = {
    "position": Position,
    "orientation": Orientation,
    "twist": TwistSensor,
    "attitude": Attitude,
    "height": Height,
    "range_cone": RangeCone,
    "lidar": Lidar,
    "robot_sensor": RobotSensor,
    "wheel_speed": WheelSpeed,
    "wheel_travel": WheelTravel,
    "gyro": Gyro,
    "battery": Battery,
    "mailbox": MailboxSensor,
}
"""Sensors of the simulation, by driver."""

ACTUATORS: Mapping[str, type[SimulatedActuator]] = {"velocity": Velocity}
"""Actuators of the simulation, by driver."""

DEVICES: Mapping[str, Mapping[str, type[Value]]] = {"sensor": SENSORS, "actuator": ACTUATORS}
"""Both, by the name of their table in robot.toml."""


def declared_keys(driver: str, kind: str) -> type[Value] | None:
    """Class that declares the keys of a driver; None if no driver of this kind, shipped or of a package, has this name.

    Args:
        driver: Name of the driver.
        kind: `sensor` or `actuator`; drivers of packages may have both.
    """
    if driver in registered("rocs_bt.devices"):
        found: type[Value] | None = load("rocs_bt.devices", driver).keys.get(kind)
        return found
    return DEVICES[kind].get(driver)
