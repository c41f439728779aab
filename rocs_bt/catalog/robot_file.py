"""Robot files (robot/3): locomotion, devices and the wiring of Monitor and Analyze blocks (docs/architecture.md)."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..analyze import ANALYZERS
from ..base.errors import InputError, did_you_mean
from ..base.files import is_file
from ..base.geometry import Pose2
from ..base.python_content import classes_in, is_reference
from ..base.registered import load
from ..base.toml_table import Table
from ..base.units import ACCELERATION, ANGLE, FREQUENCY, LENGTH, NONE, SPEED, TIME, Dimension, convert, parse_unit
from ..control.locomotion import AXES, Locomotion
from ..control.locomotion_kinds import LIMITS, LOCOMOTIONS
from ..declare import Open, place_of, read
from ..drivers import ROS2, VelocityParameters
from ..interfaces.safety import Landing, Limits
from ..monitor import MONITORS
from .inherit import FindBase, no_base, overlaid, overlay_table, read_with_base
from .robot_spec import (
    ActuatorSpec,
    AnalyzeSpec,
    LocomotionSpec,
    MonitorSpec,
    RobotSpec,
    SensorSpec,
    robot_locomotion,
)
from .values import driver_parameters, locomotion_parameters, raw_parameters, read_name

FORMAT = "robot/3"


def load_robot(file: Path, find_base: FindBase = no_base, overlay: Open | None = None) -> RobotSpec:
    """Read a robot.toml.

    Args:
        file: The robot.toml.
        find_base: Returns the robot.toml of the robot that a `base` names.
        overlay: Tables that override those of the file.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    root = read_with_base(file, find_base)
    if overlay:
        root = overlaid(overlay_table(overlay), root, place_of(overlay)[1:])
        root.raw("base", None)  # read already
    root.choice("format", (FORMAT,))
    doc = root.text("doc", "")
    model = _model(root)
    body = root.table("body")
    length = body.quantity("length", LENGTH, math.nan, low=0.0)
    width = body.quantity("width", LENGTH, math.nan, low=0.0)
    ground_contact = tuple(body.texts("ground_contact")) if "ground_contact" in body else None
    sensor_tables, monitor_tables, actuator_tables = (root.tables(key) for key in ("sensor", "monitor", "actuator"))
    _unique([*sensor_tables, *actuator_tables])  # their names are nodes of one graph
    sensors, made = _wire_sensors(sensor_tables, [_sensor(t) for t in sensor_tables], monitor_tables)
    monitors = (*made, *_wire_monitors(monitor_tables, sensors))
    analyzers = tuple(_analyze(t, monitors) for t in _unique(root.tables("analyze")))
    locomotion_table = root.table("locomotion", optional=False)
    kind = locomotion_table.choice("kind", LOCOMOTIONS)
    motion = locomotion_table.text("actuator", "wheels")
    parameters = locomotion_parameters(locomotion_table, kind)
    named = motion if motion in [table.raw("name", "") for table in actuator_tables] else "wheels"
    actuators = tuple(_actuator(t, named, "axes" in parameters) for t in actuator_tables)
    locomotion, actuators = _locomotion(
        locomotion_table, LocomotionSpec(kind, motion, parameters), actuators, monitor_tables
    )
    thresholds = {
        rules: {name: (own.raw(name), *own.position(name)) for name in own.keys()}  # noqa: SIM118 - a Table's keys are free
        for rules, own in root.named_tables("rules").items()
    }
    ros2 = read(load("rocs_bt.tables", "ros2"), root.table("ros2")) if "ros2" in root else None
    for table in (*sensor_tables, *actuator_tables):
        if "ros2" not in root and table.raw("driver", "") == ROS2:
            table.fault(
                "driver", "a driver uses ROS 2, but the robot has no [ros2] table.", "Add one; it may be empty."
            )
    root.done()
    name, wiring = file.parent.name, (sensors, monitors, analyzers, actuators)
    positions = {".".join(map(str, key)): at for key, at in root.positions.items() if key[:1] in _LOCATED or not key}
    return RobotSpec(
        name,
        file,
        doc,
        model,
        locomotion,
        length,
        width,
        *wiring,
        bases=root.bases,
        thresholds=thresholds,
        ground_contact=ground_contact,
        ros2=ros2,
        positions=positions,
    )


_LOCATED = (("model",), ("locomotion",), ("body",), ("ros2",))


def _model(root: Table) -> Path | None:
    if "model" not in root:
        return None
    named = root.text("model")
    model = root.beside(named)
    if _beside(root, "model", named) and not is_file(model):
        root.fault("model", f"there is no model file '{model.name}' beside robot.toml.")
    return model


def _beside(table: Table, key: str, named: str) -> bool:
    """Check that a file is in the folder of the robot or a base, because content hashes cover no other files."""
    path = table.beside(named)
    if any(path.resolve().is_relative_to(file.parent.resolve()) for file in (table.file, *table.bases)):
        return True
    table.fault(
        key, f"'{named}' is not in the robot's folder.", "Move it there: all files of a robot are beside robot.toml."
    )
    return False


def _locomotion(
    table: Table, spec: LocomotionSpec, actuators: tuple[ActuatorSpec, ...], monitors: Sequence[Table]
) -> tuple[LocomotionSpec, tuple[ActuatorSpec, ...]]:
    """Complete the limits of wheels by those of their actuator, or those of an actuator of twists by the axes'."""
    actuator, wheeled = next((a for a in actuators if a.name == spec.actuator), None), "axes" not in spec.parameters
    if actuator is None:
        _unknown(table, "actuator", spec.actuator, [a.name for a in actuators], "actuator")
    elif wheeled:
        motors = actuator.parameters
        ramp = motors.max_acceleration if isinstance(motors, VelocityParameters) else math.inf
        own = [table.table(axis) for axis in AXES if axis in table]
        check_braking([table, *own, *monitors], min(*actuator.limits.changes, ramp))
        limits = locomotion_limits(table, spec.parameters, actuator.limits, ramp)
        spec = replace(spec, parameters={**spec.parameters, **limits})
    if spec.kind in LOCOMOTIONS and not table.faults:
        try:
            made = robot_locomotion(spec)
        except InputError as error:
            table.adopt(None, error)
        else:
            if not wheeled:
                actuators = tuple(_moved_by_twists(a, made) if a is actuator else a for a in actuators)
    return spec, actuators


def _sensor(table: Table) -> SensorSpec:
    name = read_name(table)
    dimension = _dimension(table)
    driver = _class(table, "driver")
    parameters = driver_parameters(table, "sensor", driver)
    return SensorSpec(
        name=name,
        driver=driver,
        signal=table.text("signal", name),
        monitor=table.text("monitor"),
        rate=table.quantity("rate", FREQUENCY, low=0.01) if "rate" in table else None,
        noise=table.quantity("noise", dimension, 0.0, low=0.0),
        latency=table.quantity("latency", TIME, 0.0, low=0.0, high=10.0),
        drop_out=table.quantity("drop_out", NONE, 0.0, low=0.0, high=1.0),
        dimension=dimension,
        scale=_scale(table),
        max_age=table.quantity("max_age", TIME, low=0.0, high=math.inf) if "max_age" in table else None,
        mount=_mount(table.table("mount")) if "mount" in table else None,
        parameters=parameters,
        optional=table.flag("optional", False),
        line=table.position()[0],
    )


def _mount(table: Table) -> Pose2:
    return Pose2(table.quantity("x", LENGTH, 0.0), table.quantity("y", LENGTH, 0.0), table.quantity("yaw", ANGLE, 0.0))


def _scale(table: Table) -> float:
    """Factor from the unit of a sensor's table to SI; 1 if the unit is faulty, which `_dimension` reports."""
    try:
        return parse_unit(str(table.raw("unit", "1"))).value
    except InputError:
        return 1.0


def _dimension(table: Table, default: str = "1") -> Dimension:
    try:
        return parse_unit(table.text("unit", default)).dimension
    except InputError as error:
        table.adopt("unit", error)
        return NONE


def _wire_sensors(
    tables: Sequence[Table], sensors: Sequence[SensorSpec], declared: Sequence[Table]
) -> tuple[tuple[SensorSpec, ...], list[MonitorSpec]]:
    """Connect sensors to Monitors: sensors with names of their Monitors, and Monitors for sensors that name a class."""
    names = {str(t.raw("name", "")) for t in declared}
    wired, made = [], []
    for table, sensor in zip(tables, sensors, strict=True):
        if sensor.monitor in names:
            wired.append(sensor)
            continue
        _class(table, "monitor", MONITORS)
        if sensor.name in names:
            table.fault("monitor", f"a [[monitor]] is also named '{sensor.name}'.", "Name it here, or rename it.")
        made.append(MonitorSpec(sensor.name, sensor.monitor, (sensor.name,), line=sensor.line))
        wired.append(replace(sensor, monitor=sensor.name))
    return tuple(wired), made


def _wire_monitors(tables: Sequence[Table], sensors: Sequence[SensorSpec]) -> Iterator[MonitorSpec]:
    """Read each `[[monitor]]` table; its sensors are those that it lists and those that name it."""
    existing = [s.name for s in sensors]
    for table in _unique(tables):
        name, listed = read_name(table), table.texts("sensors", [])
        for sensor in listed:
            if sensor not in existing:
                _unknown(table, "sensors", sensor, existing, "sensor")
        listed += [s.name for s in sensors if s.monitor == name and s.name not in listed]
        if not listed:
            table.fault(None, f"no sensor feeds the monitor '{name}'.", "List some: sensors = [...].")
        parameters, positions = raw_parameters(table, ("name", "class", "sensors"))
        cls, line = _class(table, "class", MONITORS), table.position()[0]
        yield MonitorSpec(name, cls, tuple(listed), parameters, line, positions)


def _analyze(table: Table, monitors: Sequence[MonitorSpec]) -> AnalyzeSpec:
    names = [m.name for m in monitors]
    wanted = table.texts("monitors")
    for name in wanted:
        if name not in names:
            _unknown(table, "monitors", name, names, "monitor")
    parameters, positions = raw_parameters(table, ("name", "class", "monitors"))
    cls, line = _class(table, "class", ANALYZERS), table.position()[0]
    return AnalyzeSpec(read_name(table), cls, tuple(wanted), parameters, line, positions)


def _actuator(table: Table, motion: str, twists: bool) -> ActuatorSpec:
    moves = table.raw("name", None) == motion
    if moves and twists:
        limits = _no_limits(table)
    else:
        dimension = _dimension(table, "m/s" if moves else "1")
        if moves and dimension != SPEED:
            table.fault("unit", f"unit of the wheels must be m/s, found '{table.raw('unit')}'.", 'Write unit = "m/s".')
        limits = actuator_limits(table, dimension, together=moves)
    age = table.quantity("max_command_age", TIME, 0.2, low=1e-3)
    driver = _class(table, "driver")
    parameters = driver_parameters(table, "actuator", driver)
    line, isolated = table.position()[0], table.flag("isolated", False)
    return ActuatorSpec(read_name(table), driver, limits, age, parameters, line, isolated)


def _no_limits(table: Table) -> Limits:
    """Note a fault for each limit of an actuator of twists, which has those of the axes; returns a placeholder."""
    for key in ("range", "max_change", "unit"):
        if key in table:
            table.raw(key)
            message = f"{key} is not for the actuator of twists: the axes in [locomotion] declare its limits."
            table.fault(key, message, "Remove the line.")
    return UNKNOWN


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
    limits = Limits(tuple(-speed for speed in speeds), tuple(speeds), changes, True, apart)
    down = tuple(-min(LANDING_SPEED, speed) if climb else 0.0 for speed, climb in zip(speeds, climbs, strict=True))
    landing = Landing(locomotion.land_after, down) if locomotion.neutral == "hover" else None
    return replace(actuator, limits=limits, landing=landing)


def _class(table: Table, key: str, shipped: Collection[str] | None = None) -> str:
    """Read the name of a shipped class, or `file.py:Class`; the file must be beside this one and have the class."""
    name = table.text(key)
    if is_reference(name):
        file, _, cls = name.partition(":")
        if not _beside(table, key, file):
            return name
        if not is_file(table.beside(file)):
            table.fault(key, f"there is no file '{file}' beside robot.toml.")
            return name
        try:
            classes = classes_in(table.beside(file))
        except InputError as error:
            table.adopt(key, error)
        else:
            if cls not in classes:
                table.fault(key, f"'{file}' has no class '{cls}'.", did_you_mean(cls, classes, f"'{file}'"))
    elif shipped is not None and name and name not in shipped:
        hint = did_you_mean(name, shipped, "rocs_bt")
        what = "monitor" if key == "monitor" else f"{table.key[0]} class"
        table.fault(key, f"no {what} is named '{name}'.", hint.and_also("Or name your own: 'file.py:Class'."))
    return name


def _unknown(table: Table, key: str, name: str, known: Sequence[str], what: str) -> None:
    table.fault(key, f"no {what} of this robot is named '{name}'.", did_you_mean(name, known, "The robot"))


def _unique(tables: Sequence[Table]) -> Sequence[Table]:
    """Note a fault at each table with the name of an earlier one; returns the tables."""
    seen: dict[str, str | int] = {}
    for table in tables:
        name = str(table.raw("name", ""))
        if name and name in seen:
            table.fault("name", f"another [[{seen[name]}]] is named '{name}'.", "Use unique names.")
        seen.setdefault(name, table.key[0])
    return tables


LANDING_SPEED = 0.3
"""Speed at which a flying body descends to land, if its limit allows [m/s]."""

_MARGIN = 1.5  # of the gate's rate of change over the deceleration of a body

UNKNOWN = Limits((-1.0,), (1.0,))
"""Placeholder for limits that are missing or invalid in the file, which is reported as a fault."""


def actuator_limits(table: Table, dimension: Dimension, together: bool) -> Limits:
    """Read `range` and `max_change` of an `[[actuator]]` table; `together`: one factor scales all values.

    `range` is one pair of bounds for all values, or a list of pairs, one for each value.
    """
    before, change = len(table.faults), table.quantity("max_change", dimension / TIME, math.inf, high=math.inf)
    declared = table.raw("range", None)
    if "range" not in table:
        message = f"the actuator '{table.raw('name', '')}' has no limits."
        table.fault(None, message, f'Write the range of commands: range = ["-1 {dimension}", "1 {dimension}"].')
        return UNKNOWN
    nested = isinstance(declared, list) and all(isinstance(pair, list) for pair in declared)
    pairs: Any = declared if nested else [declared]
    if not pairs or any(not isinstance(pair, list) or len(pair) != 2 for pair in pairs):
        hint = f'Write range = ["-1 {dimension}", "1 {dimension}"], or a list of such pairs, one for each value.'
        table.fault("range", f"range must be a pair [minimum, maximum], found {declared!r:.80}.", hint)
        return UNKNOWN
    if len(table.faults) > before:
        return UNKNOWN
    try:
        bounds = [[convert(bound, dimension, what="range") for bound in pair] for pair in pairs]
        return Limits(tuple(low for low, _ in bounds), tuple(high for _, high in bounds), change, together)
    except InputError as error:
        table.adopt("range", error)
        return UNKNOWN


def locomotion_limits(table: Table, given: Mapping[str, Any], limits: Limits, ramp: float) -> dict[str, float]:
    """Maximum planned wheel speed and acceleration: the actuator's limits, or lower values in `[locomotion]`.

    Args:
        table: `[locomotion]` table; faults are noted in it.
        given: Parameters of the table, by name, in SI units.
        limits: Limits of the wheels' actuator [m/s, m/s2].
        ramp: Maximum wheel acceleration of the actuator's electronics [m/s2]; +inf if the driver declares none.
    """
    if limits is UNKNOWN:
        return {name: given.get(name, 1.0) for name in LIMITS}
    allowed = dict(zip(LIMITS, (limits.largest, min(*limits.changes, ramp)), strict=True))
    for (name, limit), unit in zip(allowed.items(), ("m/s", "m/s2"), strict=True):
        if name in given and given[name] > limit * (1.0 + 1e-9):
            message = f"{name} is {given[name]:g} {unit}, but the actuator allows {limit:g} {unit}."
            table.fault(name, message, "Use at most the actuator's limit, or remove the line.")
        elif name not in given and math.isinf(limit):
            message = "neither [locomotion] nor its actuator limits the wheel acceleration."
            table.fault(None, message, 'Write max_wheel_acceleration = "1 m/s2", or the actuator\'s max_change.')
    return {name: given.get(name, 1.0 if math.isinf(limit) else limit) for name, limit in allowed.items()}


def check_braking(tables: Sequence[Table], limit: float) -> None:
    """Note a fault if a table declares a higher deceleration than the wheels' actuator allows.

    Args:
        tables: `[locomotion]` and `[[monitor]]` tables.
        limit: Maximum wheel acceleration of the actuator [m/s2].
    """
    for table in tables:
        try:
            wanted = convert(table.data.get("deceleration", "0 m/s2"), ACCELERATION, what="deceleration")
        except InputError:
            continue  # reported where it is read
        if wanted > limit * (1.0 + 1e-9):
            message = f"deceleration is {wanted:g} m/s2, but the actuator allows {limit:g} m/s2."
            table.fault("deceleration", message, "`stop_distance` would be too short. Measure it: rocs-bt identify.")
