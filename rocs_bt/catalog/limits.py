"""Limits of a robot: declared once in `[[actuator]]`; what else depends on them is derived or held against them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..control.drive import LIMITS
from ..document import Table
from ..errors import InputError
from ..safety import Limits
from ..units import ACCELERATION, TIME, Dimension, convert

UNKNOWN = Limits((-1.0,), (1.0,))
"""Stands for limits that are missing or wrong, whose fault is noted."""


def actuator_limits(table: Table, dimension: Dimension, together: bool) -> Limits:
    """The `range` and `max_change` of an `[[actuator]]` table.

    `range` is one pair of bounds for all values, or a list of pairs, one for each value.

    Args:
        table: The actuator's table; faults are noted in it.
        dimension: Dimension of a command's values.
        together: Whether the values are wheel speeds, which one factor scales.
    """
    before, change = len(table.faults), table.quantity("max_change", dimension / TIME, math.inf, high=math.inf)
    declared = table.raw("range", None)
    if "range" not in table:
        message = f"the actuator '{table.raw('name', '')}' has no limits."
        table.fault(None, message, f'Write what it may be commanded: range = ["-1 {dimension}", "1 {dimension}"].')
        return UNKNOWN
    nested = isinstance(declared, list) and all(isinstance(pair, list) for pair in declared)
    pairs: Any = declared if nested else [declared]
    if not pairs or any(not isinstance(pair, list) or len(pair) != 2 for pair in pairs):
        hint = f'Write range = ["-1 {dimension}", "1 {dimension}"], or a list of such pairs, one for each value.'
        table.fault("range", f"range must be the smallest and the largest command, found {declared!r:.80}.", hint)
        return UNKNOWN
    if len(table.faults) > before:
        return UNKNOWN
    try:
        bounds = [[convert(bound, dimension, what="range") for bound in pair] for pair in pairs]
        return Limits(tuple(low for low, _ in bounds), tuple(high for _, high in bounds), change, together)
    except InputError as error:
        table.adopt("range", error)
        return UNKNOWN


def drive_limits(drive: Table, given: Mapping[str, float], limits: Limits, ramp: float) -> dict[str, float]:
    """Largest wheel speed and acceleration that are planned: the actuator's limits, or less where `[drive]` says so.

    Args:
        drive: The `[drive]` table; faults are noted in it.
        given: Its numbers [SI].
        limits: Limits of the wheels' actuator [m/s, m/s2].
        ramp: How fast the actuator's electronics change a wheel speed [m/s2]; +inf where the driver declares none.
    """
    if limits is UNKNOWN:
        return {name: given.get(name, 1.0) for name in LIMITS}
    allowed = dict(zip(LIMITS, (limits.largest, min(limits.max_change, ramp)), strict=True))
    for (name, limit), unit in zip(allowed.items(), ("m/s", "m/s2"), strict=True):
        if name in given and given[name] > limit * (1.0 + 1e-9):
            message = f"{name} is {given[name]:g} {unit}, but the actuator allows {limit:g} {unit}."
            drive.fault(name, message, "Prefer less than the actuator's limit, or leave the line out.")
        elif name not in given and math.isinf(limit):
            message = "neither [drive] nor its actuator says how fast wheel speeds may change."
            drive.fault(None, message, 'Write max_wheel_acceleration = "1 m/s2", or the actuator\'s max_change.')
    return {name: given.get(name, 1.0 if math.isinf(limit) else limit) for name, limit in allowed.items()}


def check_braking(monitors: Sequence[Table], limit: float) -> None:
    """Note a fault where a monitor counts on braking harder than the wheels' actuator can.

    Args:
        monitors: The `[[monitor]]` tables.
        limit: How fast the actuator changes a wheel speed [m/s2].
    """
    for table in monitors:
        try:
            wanted = convert(table.data.get("deceleration", "0 m/s2"), ACCELERATION, what="deceleration")
        except InputError:
            continue  # the monitor says so itself
        if wanted > limit * (1.0 + 1e-9):
            message = f"a deceleration of {wanted:g} m/s2 is more than the actuator allows, {limit:g} m/s2."
            table.fault("deceleration", message, "`stop_distance` would be too short. Measure it: rocs-bt identify.")
