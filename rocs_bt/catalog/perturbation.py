"""Perturbations: differences between a simulated robot and the model that its agent has of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from ..base.errors import Fault, InputError, UnknownName, unknown
from ..base.toml_table import read_toml
from ..base.units import NONE, POSITIVE, Quantity, convert, parse_quantity
from ..declare import Open, TableName, Valid, Value, Wrong, checked, read_root, replaced, values_of
from .device_spec import ActuatorSpec, SensorSpec
from .robot_spec import RobotSpec

CHANGES = {
    "times": lambda value, strength: value * strength,
    "share": lambda value, strength: value * (1.0 + strength),
    "plus": lambda value, strength: value + strength,
    "to": lambda value, strength: strength,
}
"""Kinds of change: new value from the present one and the strength."""

_BODY = ("size", "friction")
# Keys of a device that are not parameters of its driver.
_SHARES = ("drop_out", "missing_echo", "odometry", "slip")
_OWN = ("noise", "latency", "drop_out", "rate", "max_age", "max_command_age")

Device = TypeVar("Device", SensorSpec, ActuatorSpec)


def _can_be_listed(name: str) -> bool:
    return not any(mark in name for mark in "~=@ ")


_NAME = Valid(_can_be_listed, "a valid name of a perturbation", "Use letters, digits, and '_'.")


class Perturbation(Value):
    """Change of a simulated robot of which its agent does not know.

    The change applies to body and devices in the world. Everything that the agent derives from robot.toml (locomotion,
    outline, limits, validity of readings) remains that of the file.

    Attributes:
        name: Name, such as `delay`.
        device: Changed part of the robot; `device` is both sensors and actuators.
        keys: Keys that change: of `[[sensor]]` or `[[actuator]]` tables, or `size` or `friction` of the body. Devices
            without the key keep their values.
        change: Kind of change, one of `CHANGES`.
        strength: Strength of the change; without a unit, a factor.
        drivers: Drivers of the devices that change; all if empty.
        harder: Factor from one strength to the next one of a walk outward; below 1 for a key that is worse if low.
        doc: One-sentence description.
    """

    name: Annotated[str, TableName(), _NAME]
    device: Literal["sensor", "actuator", "device", "body"]
    keys: tuple[str, ...]
    change: Literal["times", "share", "plus", "to"]
    strength: Annotated[Quantity, POSITIVE]
    drivers: tuple[str, ...] = ()
    harder: Annotated[float, POSITIVE] = 2.0
    doc: str = ""

    def _check(self) -> Iterator[Wrong]:
        """Faults of keys that the device has not, and of a step that leads nowhere."""
        if not self.keys:
            yield Wrong("keys", f"the perturbation '{self.name}' changes no key.", 'Write keys = ["noise"].')
        for key in self.keys if self.device == "body" else ():
            if key not in _BODY:
                yield Wrong("keys", f"'{key}' is not a key of the body.", f"A body has {' and '.join(_BODY)}.")
        if self.harder == 1.0:
            yield Wrong("harder", "harder must be a positive factor other than 1, found 1.")

    def __str__(self) -> str:
        return f"{self.name}={self.strength.value:.6g}"

    @property
    def amount(self) -> str:
        """Strength with its unit."""
        return f"{self.strength.value:.6g} {self.unit}".rstrip()

    @property
    def unit(self) -> str:
        """Unit of the strength; empty for a factor."""
        return "" if self.strength.dimension == NONE else str(self.strength.dimension)

    def at(self, strength: float) -> Perturbation:
        """The same perturbation at another strength, SI units."""
        return replaced(self, strength=replace(self.strength, value=strength))

    def next(self) -> Perturbation:
        """The same perturbation at the next strength of a walk outward."""
        return self.at(self.strength.value * self.harder)

    def of(self, robot: RobotSpec) -> RobotSpec:
        """Copy of a robot with the change.

        Raises:
            InputError: The change has no effect on this robot, or makes a value impossible.
        """
        changed = self._body(robot) if self.device == "body" else self._devices(robot)
        if changed == robot:
            keys = " or ".join(f"'{key}'" for key in self.keys)
            why = f"no {self.device} has a value of {keys} that it changes"
            raise InputError(Fault(f"the perturbation '{self.name}' has no effect on '{robot.name}': {why}."))
        return changed

    def _body(self, robot: RobotSpec) -> RobotSpec:
        variant = robot.variant
        for key in self.keys:
            variant = replace(variant, **{key: self._value(getattr(variant, key))})
        if variant.size == robot.variant.size:
            return replaced(robot, variant=variant)
        # Motors and encoders are calibrated for the wheels of the variant; `wheel_radius` is a perturbation of its own.
        wheels = replaced(self, device="device", keys=("wheel_radius",), change="times", drivers=())
        return wheels.at(variant.size / robot.variant.size)._devices(replaced(robot, variant=variant))

    def _devices(self, robot: RobotSpec) -> RobotSpec:
        sensors, actuators = robot.sensors, robot.actuators
        if self.device != "actuator":
            sensors = tuple(self._device(each) for each in sensors)
        if self.device != "sensor":
            actuators = tuple(self._device(each) for each in actuators)
        return replaced(robot, sensors=sensors, actuators=actuators)

    def _device(self, device: Device) -> Device:
        if self.drivers and device.driver not in self.drivers:
            return device
        for key in self.keys:
            if key in _OWN and hasattr(device, key):
                device = replaced(device, **{key: self._possible(key, getattr(device, key))})
            elif isinstance(old := device.parameters, Value):
                if (value := values_of(old).get(key)) is not None:
                    values = {**values_of(old), key: self._possible(key, value)}
                    device = replaced(device, parameters=checked(type(old), values, f"'{device.name}'"))
            elif key in old:
                device = replaced(device, parameters=Open(old | {key: self._possible(key, old[key])}))
        return device

    def _possible(self, key: str, value: Any) -> Any:
        """New value of a key of a device; raises InputError."""
        found = self._value(value)
        for share in found if isinstance(found, (list, tuple)) else [found]:
            if key in _SHARES and isinstance(share, (int, float)) and not 0.0 <= share <= 1.0:
                raise InputError(Fault(f"'{key}' is a share from 0 to 1, and '{self}' makes it {share:g}."))
        return found

    def _value(self, value: Any) -> Any:
        """New value; texts, such as parameters of a user's driver, and missing values that are not set stay."""
        if self.change != "to" and (isinstance(value, bool) or not isinstance(value, (int, float))):
            return value
        return CHANGES[self.change](value, self.strength.value)


def perturbed(robot: RobotSpec, perturbations: tuple[Perturbation, ...]) -> RobotSpec:
    """Copy of a robot with all changes, one after the other.

    Raises:
        InputError: A change has no effect on the robot.
    """
    for each in perturbations:
        robot = each.of(robot)
    return robot


class PerturbationFile(Value):
    """Content of a file of perturbations.

    Attributes:
        format: Format of the file.
        doc: One-sentence description.
        perturbation: The perturbations, by name.
    """

    format: Literal["perturbations/1"]
    doc: str = ""
    perturbation: Mapping[str, Perturbation] = Open()


def read_perturbations(file: Path) -> dict[str, Perturbation]:
    """Read a file of perturbations, by name.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    return dict(read_root(PerturbationFile, read_toml(file)).perturbation)


def parse_perturbation(text: str, known: Mapping[str, Perturbation]) -> Perturbation:
    """Perturbation from a text such as `noise` or `noise=6`; a strength is in SI units or has its unit.

    Args:
        text: Name, with an optional strength.
        known: Perturbations that exist, by name.

    Raises:
        InputError: No such perturbation, or its strength is invalid.
    """
    name, equals, given = (part.strip() for part in text.partition("="))
    if name not in known:
        raise UnknownName(unknown("perturbation", name, known))
    return known[name] if not equals else _at(known[name], given)


def _at(of: Perturbation, given: str) -> Perturbation:
    quantity = parse_quantity(given)
    if str(quantity.dimension) not in ("", "1"):
        convert(given, parse_quantity(f"1 {of.unit or '1'}").dimension, what=f"the strength of '{of.name}'")
    if not POSITIVE.admit(quantity.value):
        raise InputError(f"the strength of '{of.name}' must be positive and finite, found '{given}'.")
    return of.at(quantity.value)
