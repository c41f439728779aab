"""Parameters of locomotion, drivers and blocks read from robot.toml, in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from typing import Any

from ..base.errors import did_you_mean
from ..base.parameter import Positions
from ..base.python_content import is_reference
from ..base.registered import registered
from ..base.toml_table import Table
from ..base.units import ACCELERATION, LENGTH, SPEED, TIME, TURN_RATE, parse_quantity
from ..control.locomotion import AXES, AxisLimits, Response
from ..control.locomotion_kinds import HOLONOMIC, LIMITS, LOCOMOTIONS, OPTIONAL
from ..declare import Kind, Open, Value, positions_of, read
from ..drivers import DRIVER_PARAMETERS, declared_parameters
from ..knowledge.declaration import is_name
from .inherit import DEVICE_KEYS

_DIMENSIONS = {
    "wheel_separation": LENGTH,
    "effective_wheel_separation": LENGTH,
    "icr_offset": LENGTH,
    "base_radius": LENGTH,
    "half_length": LENGTH,
    "half_width": LENGTH,
    "max_wheel_speed": SPEED,
    "max_wheel_acceleration": ACCELERATION,
}
_NUMBER = re.compile(r"\s*[+-]?(\d|\.\d|inf\b)")


def read_name(table: Table) -> str:
    """Read the `name` of a table; it must be a printable text."""
    name = table.text("name")
    if name == table.raw("name", None) and not (name.strip() == name and is_name(name)):
        table.fault(
            "name", f"{name!r:.80} is not a valid name.", "Use 1 to 200 printable characters without spaces around."
        )
    return name


def raw_parameters(table: Table, known: Collection[str]) -> tuple[dict[str, Any], Positions]:
    """Read all keys of a table except the known ones, unconverted: the class that they configure declares their units.

    Returns values and their positions by key, also those in sub-tables.
    """
    found = {key: table.raw(key) for key in table.keys() if key not in known}  # noqa: SIM118 - a Table is no mapping
    return found, positions_of(Open.of(table, found))


def locomotion_parameters(table: Table, kind: str) -> dict[str, Any]:
    """Read a `[locomotion]` table, for `make_locomotion`; reports a fault for each parameter that the kind needs.

    Limits of wheels that the table omits are missing in the result: those of the actuator apply.
    """
    needed = [name for name in (LOCOMOTIONS[kind][1] if kind in LOCOMOTIONS else ()) if name not in LIMITS]
    for name in needed:
        if name != "axes" and name not in table:
            table.fault(None, f"a '{kind}' locomotion needs '{name}'.", f"Add a line '{name} = ...'.")
    minimum = {"icr_offset": -math.inf}  # the centre of rotation may be behind the base
    wheeled = kind in LOCOMOTIONS and "axes" not in needed
    own = (*needed, *OPTIONAL.get(kind, ()), *LIMITS) if wheeled else ()
    given = {name: of for name, of in _DIMENSIONS.items() if name in table and (name in own or kind not in LOCOMOTIONS)}
    found: dict[str, Any] = {name: table.quantity(name, of, low=minimum.get(name, 0.0)) for name, of in given.items()}
    able = AXES if "axes" in needed else ("vx", "vy") if kind in HOLONOMIC else ("vx",)
    axes = {axis: table.table(axis) for axis in able if axis in table}
    if "axes" in needed:
        found["axes"] = {axis: _axis_limits(own, axis) for axis, own in axes.items()}
    if kind == "flying" and "land_after" in table:
        found["land_after"] = table.quantity("land_after", TIME, low=0.0, high=math.inf)
    if kind == "legged" and "sway" in table:
        found["sway"] = table.quantity("sway", LENGTH, low=0.0, high=0.2)
    for name in (*own, "delay", "lag", "latency", "deceleration", *able):
        table.raw(name, None)  # marks the key as known, so that it is suggested for a misspelt key
    found["response"] = _response(table, {axis: own for axis, own in axes.items() if axis != "wz"})
    return found


def _axis_limits(table: Table, axis: str) -> AxisLimits:
    """Read the limits of one axis of a body that accepts twists."""
    before, speed = len(table.faults), TURN_RATE if axis == "wz" else SPEED
    found = table.quantity("max_speed", speed, low=1e-6), table.quantity("max_acceleration", speed / TIME, low=1e-6)
    return AxisLimits(*found) if len(table.faults) == before else AxisLimits(1.0, 1.0)


def _response(table: Table, axes: Mapping[str, Table]) -> Response:
    """Read delays and decelerations of a `[locomotion]` table; an axis without a deceleration has that of the table."""
    numbers = {name: table.quantity(name, TIME, low=0.0) for name in ("delay", "lag", "latency") if name in table}
    braking: dict[str, float] = {}
    if "deceleration" in table:
        braking = dict.fromkeys(("vx", "vy", "vz"), table.quantity("deceleration", ACCELERATION, low=1e-6))
    for axis, own in axes.items():
        if "deceleration" in own:
            braking[axis] = own.quantity("deceleration", ACCELERATION, low=1e-6)
    return Response(**numbers, deceleration=braking)


def driver_parameters(table: Table, kind: str, driver: str) -> Value | Open:
    """Read the parameters of a device's driver.

    Parameters of a user's driver are checked when its class is loaded (`drivers.parameters`), since no code runs here.
    """
    known = DEVICE_KEYS[kind]
    declared = None if is_reference(driver) else declared_parameters(driver, kind)
    if declared is not None:
        return read(declared, table, kind=Kind(f"driver '{driver}'", Value))
    if driver and not is_reference(driver):
        hint = did_you_mean(driver, (*DRIVER_PARAMETERS, *registered("rocs_bt.devices")), "rocs_bt")
        table.fault("driver", f"no driver is named '{driver}'.", hint.and_also("Or name your own: 'file.py:Class'."))
    return Open.of(table, {key: table.raw(key) for key in table.data if key not in known})


def to_si(value: Any) -> Any:
    """Convert a quantity in a TOML value to a number in SI units; other values are returned unchanged.

    Raises:
        UnitError: A text begins with a number but has no known unit.
    """
    return parse_quantity(value).value if isinstance(value, str) and _NUMBER.match(value) else value
