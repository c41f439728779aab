"""Simulated devices of values that a test gives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rocs_bt.declare import checked
from rocs_bt.devices.mujoco import SensorMount
from rocs_bt.devices.simulated import ACTUATORS, SENSORS


def sensor_mount(name: str, driver: str | type[Any], parameters: Mapping[str, Any]) -> SensorMount:
    """Sensor of a world to compile."""
    return SensorMount(name, keys(driver, name, parameters))


def keys(driver: str | type[Any], name: str, parameters: Mapping[str, Any]) -> Any:
    """Device with its keys, not bound to a world."""
    cls = {**SENSORS, **ACTUATORS}[driver] if isinstance(driver, str) else driver
    return checked(cls, parameters, f"{driver} '{name}'")


def make_device(
    world: Any, robot: str, name: str, driver: str | type[Any], parameters: Mapping[str, Any], **bound: Any
) -> Any:
    """Device of a robot in a world; `bound` are further arguments of `bind`."""
    return keys(driver, name, parameters).bind(name, world, robot, **bound)
