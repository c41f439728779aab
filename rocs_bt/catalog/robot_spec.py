"""RobotSpec: content of a robot.toml (robot/3), that is locomotion, devices and the wiring of blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from ..base.errors import Fault, InputError, unknown
from ..base.files import is_file
from ..base.python_content import is_reference
from ..base.toml_table import Table
from ..base.units import ACCELERATION, LENGTH, NOT_NEGATIVE, SPEED, Quantity, convert
from ..base.words import counted
from ..control.body_values import body_values
from ..control.locomotion import Locomotion
from ..control.locomotion_kinds import LOCOMOTIONS, Braking, LocomotionSpec, UnknownLocomotion, Wheels
from ..declare import (
    Content,
    Declared,
    InFile,
    Key,
    Kinds,
    Location,
    Names,
    Open,
    Registered,
    Rest,
    Scope,
    SetByPrograms,
    Value,
    Wrong,
    has_key,
    location_of,
    names_of,
    note_twice,
    replaced,
    rows_in,
    values_of,
)
from ..devices.body_variant import AS_MODELLED, BodyVariant
from ..devices.simulated import Velocity
from ..interfaces.actuator_limits import ActuatorLimits
from ..interfaces.device import Actuator
from ..interfaces.safety_gate import Landing
from .device_spec import ActuatorSpec, BlockSpec, SensorSpec

LANDING_SPEED = 0.3
"""Speed at which a flying body descends to land, if its limit allows [m/s]."""

_MARGIN = 1.5  # of the gate's rate of change over the deceleration of a body


class MonitorSpec(BlockSpec):
    """One `[[monitor]]` table, or the Monitor made for a sensor that names only its class.

    Attributes:
        cls: Name of a shipped Monitor class, or `file.py:Class` beside robot.toml.
        sensors: Names of the sensors that the Monitor reads.
        parameters: Arguments of the class, unconverted.
    """

    cls: Annotated[str, Key("class"), Content("monitor class")]
    sensors: Annotated[tuple[str, ...], Names("sensor", "no sensor of this robot", "The robot")] = ()
    parameters: Annotated[Open, Rest()] = Open()

    @classmethod
    def of(cls, sensor: SensorSpec) -> MonitorSpec:
        """Monitor of a sensor that names its class, at the place of the sensor."""
        made = cls(name=sensor.name, cls=sensor.monitor, sensors=(sensor.name,))
        made.__dict__["_table"] = sensor._table
        return made


class AnalyzeSpec(BlockSpec):
    """One `[[analyze]]` table.

    Attributes:
        cls: Name of a shipped Analyze class, or `file.py:Class` beside robot.toml.
        monitors: Names of the Monitors that supply the signals of the Analyze block.
        parameters: Arguments of the class, unconverted.
    """

    cls: Annotated[str, Key("class"), Content("analyze class")]
    monitors: Annotated[tuple[str, ...], Names("monitor", "no monitor of this robot", "The robot")]
    parameters: Annotated[Open, Rest()] = Open()


class BodySpec(Value):
    """`[body]` table: outline and contacts.

    Attributes:
        length: Length of the outline along x [m]; NaN if unknown.
        width: Width of the outline along y [m]; NaN if unknown.
        ground_contact: Geoms of the model that may touch the ground; None for those that carry the robot in its pose.
    """

    length: Annotated[float, LENGTH, NOT_NEGATIVE] = math.nan
    width: Annotated[float, LENGTH, NOT_NEGATIVE] = math.nan
    ground_contact: tuple[str, ...] | None = None


def _kinds() -> Mapping[str, type[LocomotionSpec]]:
    return {"": UnknownLocomotion, **LOCOMOTIONS}


class RobotSpec(Value):
    """Content of a robot's folder.

    Attributes:
        name: Folder's name.
        file: The robot.toml.
        bases: The robot.toml files that this one is based on, nearest first.
        format: Format of the file.
        base: Robot on which this one is based; its tables are read already.
        doc: One-sentence description.
        model: MJCF file; None for a robot without a body in simulation.
        motion: Table of the locomotion.
        body: Outline and contacts.
        sensors, monitors, analyzers, actuators: Devices and blocks; the agent consists of exactly these.
        thresholds: Robot-specific values of named thresholds as written, by rule file.
        tables: Tables of packages (`rocs_bt.tables`), such as `[ros2]`, by name.
        variant: Differences of the simulated body from its model; set by perturbations and never by a file.
    """

    name: Annotated[str, SetByPrograms()] = ""
    file: Annotated[Path, SetByPrograms()] = Path()
    bases: Annotated[tuple[Path, ...], SetByPrograms()] = ()
    format: Annotated[Literal["robot/3"], InFile()] = "robot/3"
    base: str = ""
    doc: str = ""
    model: Annotated[Path, Content("model file")] | None = None
    motion: Annotated[LocomotionSpec, Key("locomotion"), Kinds("kind", _kinds, "locomotion")]
    body: BodySpec = BodySpec()
    sensors: Annotated[tuple[SensorSpec, ...], Key("sensor")] = ()
    monitors: Annotated[tuple[MonitorSpec, ...], Key("monitor")] = ()
    analyzers: Annotated[tuple[AnalyzeSpec, ...], Key("analyze")] = ()
    actuators: Annotated[tuple[ActuatorSpec, ...], Key("actuator")] = ()
    thresholds: Annotated[Mapping[str, Open], Key("rules")] = Open()
    tables: Annotated[Mapping[str, Any], Registered("robot")] = Open()
    variant: Annotated[BodyVariant, SetByPrograms()] = AS_MODELLED

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Add the names of sensors and Monitors, and the unit of wheels; note names that two tables have."""
        sensors, monitors = rows_in(table, "sensor"), rows_in(table, "monitor")
        declared = names_of(monitors)
        own = [sensor for sensor in sensors if sensor.get("monitor") not in declared]
        scope.names |= {"sensor": names_of(sensors), "monitor": sorted([*names_of(own), *declared])}
        note_twice(table, ("sensor", "actuator"), "device", "Use unique names: devices are nodes of one graph.")
        for key in ("monitor", "analyze"):
            note_twice(table, (key,), key, "Use unique names.")
        rows = {str(row.get("name")): row for row in rows_in(table, "actuator")}
        motion = table.data.get("locomotion")
        motion = motion if isinstance(motion, dict) else {}
        moving = rows.get(str(motion.get("actuator"))) or rows.get("wheels", {})
        if LOCOMOTIONS.get(str(motion.get("kind")), Wheels).wheeled:
            moving.setdefault("unit", "m/s")  # the limits of wheels are read in this unit

    def _check(self) -> Iterator[Wrong]:
        """Faults of tables that do not fit each other."""
        yield from self._wiring_faults()
        if self.motion.actuator not in (known := [actuator.name for actuator in self.actuators]):
            fault = unknown("actuator of this robot", self.motion.actuator, known, "The robot")
            yield Wrong("actuator", fault.message, fault.hint, self.motion)
        for actuator in self.actuators:
            yield from self._limit_faults(actuator)

    def _wiring_faults(self) -> Iterator[Wrong]:
        """Faults of devices and Monitors that do not fit each other."""
        names = [monitor.name for monitor in self.monitors]
        for sensor in self.sensors:
            if sensor.name in names and sensor.monitor not in names:
                message = f"a [[monitor]] is also named '{sensor.name}'."
                yield Wrong("monitor", message, "Name it here, or rename it.", sensor)
        for monitor in self.monitors:
            if not self._read_by(monitor) and not (monitor._table and monitor._table.data.get("sensors")):
                message, hint = f"no sensor feeds the monitor '{monitor.name}'.", "List some: sensors = [...]."
                yield Wrong(None, message, hint, monitor)
        for device in (*self.sensors, *self.actuators):
            if (driver := device.driver) in Registered("robot").names and driver not in self.tables:
                message = f"the driver '{driver}' needs a table [{driver}], and the robot has none."
                yield Wrong("driver", message, "Add one; it may be empty.", device)

    def _limit_faults(self, actuator: ActuatorSpec) -> Iterator[Wrong]:
        """Faults of the limits of an actuator, and of those of wheels that contradict them."""
        moves = actuator.name == self.motion.actuator
        if moves and not self.motion.wheeled:
            for key in (key for key in ("range", "max_change", "unit") if has_key(actuator, key)):
                message = f"{key} is not for the actuator of twists: the axes in [locomotion] declare its limits."
                yield Wrong(key, message, "Remove the line.", actuator)
            return
        if next(actuator._check(), None):
            return  # a fault of the unit
        if moves and actuator.dimension != SPEED:
            message = f"unit of the wheels must be m/s, found '{actuator.unit}'."
            yield Wrong("unit", message, 'Write unit = "m/s".', actuator)
            return
        if has_key(actuator, "range") and not actuator.range:
            return  # a fault of the range
        try:
            limits = actuator.limited(moves)
        except InputError as error:
            at = "range" if has_key(actuator, "range") else None
            yield from (Wrong(at, fault.message, fault.hint, actuator) for fault in error.faults)
        else:
            if moves and isinstance(self.motion, Wheels):
                yield from self._wheel_faults(self.motion, *_allowed(actuator, limits))

    def _wheel_faults(self, wheels: Wheels, speed: float, acceleration: float) -> Iterator[Wrong]:
        """Faults of limits for planning, and of decelerations, that are higher than the actuator's."""
        if wheels.max_wheel_acceleration is None and math.isinf(acceleration):
            message = "neither [locomotion] nor its actuator limits the wheel acceleration."
            hint = 'Write max_wheel_acceleration = "1 m/s2", or the actuator\'s max_change.'
            yield Wrong(None, message, hint, wheels)
        for name, limit, unit in (("max_wheel_speed", speed, "m/s"), ("max_wheel_acceleration", acceleration, "m/s2")):
            planned = getattr(wheels, name)
            if planned is not None and planned > limit * (1.0 + 1e-9):
                message = f"{name} is {planned:g} {unit}, but the actuator allows {limit:g} {unit}."
                yield Wrong(name, message, "Use at most the actuator's limit, or remove the line.", wheels)
        axes = [axis for axis in values_of(wheels).values() if isinstance(axis, Braking)]
        braking: list[tuple[Declared, Any]] = [(wheels, wheels.deceleration)]
        braking += [(axis, axis.deceleration) for axis in axes]
        braking += [(monitor, monitor.parameters.get("deceleration")) for monitor in self.monitors]
        for table, wanted in braking:
            if isinstance(wanted, str):
                try:
                    wanted = convert(wanted, ACCELERATION)
                except InputError:
                    continue  # reported where it is read
            if isinstance(wanted, float) and wanted > acceleration * (1.0 + 1e-9):
                message = f"deceleration is {wanted:g} m/s2, but the actuator allows {acceleration:g} m/s2."
                hint = "`stop_distance` would be too short. Measure it: rocs-bt identify."
                yield Wrong("deceleration", message, hint, table)

    def _made(self) -> RobotSpec:
        """The robot with the limits of its actuators and wheels, and with the Monitors of all sensors."""
        if self._table is None or self._table.faults:
            return self
        names = [monitor.name for monitor in self.monitors]
        own = [sensor.name for sensor in self.sensors if sensor.monitor not in names]
        monitors = [MonitorSpec.of(sensor) for sensor in self.sensors if sensor.name in own]
        monitors += [replaced(monitor, sensors=self._read_by(monitor)) for monitor in self.monitors]
        sensors = tuple(replaced(each, monitor=each.name) if each.name in own else each for each in self.sensors)
        return replaced(self._limited(), sensors=sensors, monitors=tuple(monitors))

    def _limited(self) -> RobotSpec:
        """The robot with the limits of its actuators, and those of the wheels."""
        motion, found = self.motion, []
        for actuator in self.actuators:
            moves = actuator.name == motion.actuator
            if moves and not motion.wheeled:
                found.append(_moved_by_twists(actuator, self.locomotion))
                continue
            found.append(replaced(actuator, limits=actuator.limited(moves)))
            if moves and isinstance(motion, Wheels):
                speed, acceleration = _allowed(actuator, found[-1].limits)
                motion = replaced(
                    motion,
                    max_wheel_speed=motion.max_wheel_speed or speed,
                    max_wheel_acceleration=motion.max_wheel_acceleration or acceleration,
                )
        return replaced(self, motion=motion, actuators=tuple(found))

    def _read_by(self, monitor: MonitorSpec) -> tuple[str, ...]:
        """Names of the sensors that a Monitor reads: those that it lists, and those that name it."""
        named = [sensor.name for sensor in self.sensors if sensor.monitor == monitor.name]
        return tuple(dict.fromkeys([*monitor.sensors, *named]))

    @cached_property
    def locomotion(self) -> Locomotion:
        """Locomotion of the robot."""
        return self.motion.build()

    @property
    def mover(self) -> ActuatorSpec:
        """Actuator that takes the motion commands."""
        return next(each for each in self.actuators if each.name == self.motion.actuator)

    def position(self, *keys: str) -> Location:
        """Place of the first of some keys of `[locomotion]` that the file has; else of the table, or of `base`.

        Args:
            keys: Keys, such as `lag` or `vx.max_speed`.
        """
        paths = [key.split(".") for key in keys]
        given = [path for path in paths if self._table and ("locomotion", *path) in self._table.positions]
        return location_of(self, "locomotion", *next(iter(given), ()))

    @cached_property
    def faults(self) -> tuple[str, ...]:
        """Faults that the simulation gives the devices, such as `lidar: latency 0.1 s, drop_out 0.05`."""
        devices = [(device.name, device.faults) for device in (*self.sensors, *self.actuators)]
        return tuple(f"{name}: {', '.join(faults)}" for name, faults in devices if faults)

    @cached_property
    def constants(self) -> Mapping[str, Quantity]:
        """Constants of the body that rule files may use, by the names of `control.body_values.BODY_VALUES`."""
        return body_values(self.locomotion, self.body.length, self.body.width)

    def beside(self, name: str) -> Path:
        """Path of a file that robot.toml names: in the robot's folder, else in that of the nearest base that has it."""
        found = [file.parent / name for file in (self.file, *self.bases)]
        return next((path for path in found if is_file(path)), found[0])

    def check_twists(self, device: Actuator) -> None:
        """Check that the actuator of a body without wheels takes one value for each axis of the twist.

        Args:
            device: Any actuator of the robot; those that do not move the body are ignored.

        Raises:
            InputError: The number of values differs from the number of axes.
        """
        names = self.locomotion.values
        if device.name == self.motion.actuator and not self.motion.wheeled and device.size != len(names):
            axes = ", ".join(names)
            message = f"{type(device).__name__} takes {counted(device.size, 'value')}, but the locomotion has {axes}."
            hint = "The values are in the order of the axes; an axis without a table in [locomotion] has no value."
            # Usually the first axis is not the wrong one, and it may be that of a base.
            raise InputError(Fault(message, *self.position("vy", "vz", "wz", "vx"), hint))

    @property
    def code(self) -> tuple[Path, ...]:
        """Python files named in robot.toml, each once."""
        classes = (*(monitor.cls for monitor in self.monitors), *(analyze.cls for analyze in self.analyzers))
        names = (*classes, *(device.driver for device in (*self.sensors, *self.actuators)))
        return tuple(dict.fromkeys(self.beside(n.partition(":")[0]) for n in names if is_reference(n)))


def _allowed(actuator: ActuatorSpec, limits: ActuatorLimits) -> tuple[float, float]:
    """Largest wheel speed and acceleration that an actuator and its electronics allow [m/s, m/s2]."""
    motors = actuator.parameters
    ramp = motors.max_acceleration if isinstance(motors, Velocity) else math.inf
    return limits.largest, min(*limits.changes, ramp)


def _moved_by_twists(actuator: ActuatorSpec, locomotion: Locomotion) -> ActuatorSpec:
    """Complete the actuator of a body that accepts twists: limits of the axes, and the landing of one that hovers."""
    speeds, braking = locomotion.max_speed.tolist(), locomotion.response.deceleration
    # A body may brake faster than it plans to accelerate; the steps of the gate must not slow the braking.
    changes = tuple(
        max(limit, _MARGIN * braking.get(axis, 0.0))
        for axis, limit in zip(locomotion.values, locomotion.max_acceleration.tolist(), strict=True)
    )
    climbs = [axis == "vz" for axis in locomotion.values]
    apart = tuple(i for i, climb in enumerate(climbs) if climb)
    limits = ActuatorLimits(tuple(-speed for speed in speeds), tuple(speeds), changes, True, apart)
    down = tuple(-min(LANDING_SPEED, speed) if climb else 0.0 for speed, climb in zip(speeds, climbs, strict=True))
    landing = Landing(locomotion.land_after, down) if locomotion.neutral == "hover" else None
    return replaced(actuator, limits=limits, landing=landing)


def command_size(robot: RobotSpec, actuator: ActuatorSpec) -> int:
    """Number of values of an actuator's command, from its driver, the locomotion or its range, without a device."""
    if actuator.size is not None:
        return actuator.size
    if actuator.name == robot.motion.actuator:
        return len(robot.locomotion.values)
    return len(actuator.limits.low)
