"""Parameters of drives, drivers and blocks read from robot.toml, in SI units."""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Collection
from typing import Any

from ..control.drive import DRIVES, LIMITS
from ..document import Table
from ..drivers import DRIVER_PARAMETERS, parameters_of_driver, read_parameters
from ..errors import InputError, did_you_mean
from ..knowledge.declaration import is_name
from ..parameter import Parameter
from ..python_content import is_reference
from ..units import ACCELERATION, LENGTH, SPEED, TIME, parse_quantity

_DRIVE_NUMBERS = {
    "wheel_separation": LENGTH,
    "effective_wheel_separation": LENGTH,
    "icr_offset": LENGTH,
    "half_length": LENGTH,
    "half_width": LENGTH,
    "wheel_radius": LENGTH,
    "wheel_delay": TIME,
    "wheel_lag": TIME,
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


MEASURED = "measured"
"""Value of `latency` for a planner with actions that are delayed by its measured planning time."""


def latency_of(table: Table) -> float | None:
    """Read a planner's `latency` [s], 0 by default; None for `"measured"`."""
    if table.raw("latency", None) == MEASURED:
        return None
    return table.quantity("latency", TIME, 0.0, low=0.0, high=60.0)


def free_parameters(table: Table, known: Collection[str]) -> dict[str, Any]:
    """Read all keys of a table except the known ones, with values in SI units.

    `"15 deg"` becomes 0.2618, `["0.1 m", "1.0 m"]` becomes [0.1, 1.0], tables become dicts; other texts, numbers and
    flags stay. Faults are noted in the table.

    Args:
        table: Table to read.
        known: Keys that the caller reads itself.
    """
    found = {}
    for key in table.keys():  # noqa: SIM118 - a Table is no mapping
        if key in known:
            continue
        try:
            found[key] = to_si(table.raw(key))
        except InputError as error:
            table.adopt(key, error)
    return found


def drive_parameters(table: Table, kind: str) -> dict[str, Any]:
    """Read the numbers of a `[drive]` table; reports a fault for each missing number that the kind of drive needs."""
    needed = [name for name in (DRIVES[kind][1] if kind in DRIVES else ()) if name not in LIMITS]
    for name in needed:
        if name not in table:
            table.fault(None, f"a '{kind}' drive needs '{name}'.", f"Add a line '{name} = ...'.")
    minimum = {"icr_offset": -math.inf}  # the centre of rotation may be behind the base
    given = {name: of for name, of in _DRIVE_NUMBERS.items() if name in table}
    return {name: table.quantity(name, of, low=minimum.get(name, 0.0)) for name, of in given.items()}


def driver_parameters(table: Table, known: Collection[str], driver: str) -> tuple[dict[str, Any], int | None]:
    """Read the parameters of a device's driver and check them against the declaration of a shipped driver.

    Parameters of a user's driver are checked when its class is loaded (`drivers.parameters`), since no code runs here.

    Args:
        table: Table of the device.
        known: Keys that do not belong to the driver.
        driver: Driver's name, or `file.py:Class`.

    Returns:
        Parameters, in SI units for a shipped driver and unconverted for a user's; and the number of values of the
        device, None if unknown.
    """
    if is_reference(driver):
        return {key: table.raw(key) for key in table.keys() if key not in known}, None  # noqa: SIM118 - no mapping
    if driver not in DRIVER_PARAMETERS:
        if driver:
            hint = did_you_mean(driver, DRIVER_PARAMETERS, "rocs_bt")
            table.fault("driver", f"no driver is named '{driver}'.", f"{hint} Or name your own: 'file.py:Class'.")
        return free_parameters(table, known), None
    specs = parameters_of_driver(DRIVER_PARAMETERS[driver])
    before = len(table.faults)
    given = {name: _parameter(table, spec) for name, spec in specs.items() if name in table}
    for name, spec in specs.items():
        table.raw(name, None)  # marks the key as known, so that it is suggested for a misspelt key
        if spec.required and name not in table:
            table.fault(None, f"the driver '{driver}' needs '{name}'.", f"It takes: {', '.join(specs)}.")
    if len(table.faults) == before:
        try:
            return given, read_parameters(DRIVER_PARAMETERS[driver], given, f"the driver '{driver}'").size
        except InputError as error:
            table.adopt(None, error)
    return given, None


def _parameter(table: Table, spec: Parameter) -> Any:
    many = typing.get_origin(spec.type) is tuple
    if (of := spec.dimension) is not None:
        return table.quantities(spec.name, of) if many else table.quantity(spec.name, of, high=math.inf)
    if spec.type is int or int in typing.get_args(spec.type):
        return table.integers(spec.name) if many else table.integer(spec.name)
    return table.texts(spec.name) if many else table.text(spec.name)


def to_si(value: Any) -> Any:
    """Convert every quantity in a TOML value to a number in SI units.

    Raises:
        UnitError: A text begins with a number but has no known unit.
    """
    if isinstance(value, str):
        return parse_quantity(value).value if _NUMBER.match(value) else value
    if isinstance(value, list):
        return [to_si(v) for v in value]
    if isinstance(value, dict):
        return {k: to_si(v) for k, v in value.items()}
    return value
