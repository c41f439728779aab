"""Kinds of locomotion: drives on wheels or tracks, and bodies that accept twists.

Sources: Lynch and Park, Modern Robotics (2017), 13.2 (mecanum and omnidirectional wheels) and 13.3 (differential). A
skid drive is modelled as a differential drive with an effective wheel separation, which is wider than the geometric one
and identified from turns (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ..base.errors import Fault, InputError, UnknownName, unknown
from .axis import AxisLimits
from .locomotion import AXES, Array, Locomotion


def differential_drive(
    *, wheel_separation: float, max_wheel_speed: float, max_wheel_acceleration: float, **body: Any
) -> Locomotion:
    """Differential drive: two driven wheels, in the order left, right.

    Args:
        wheel_separation: Distance between the contact points of the wheels [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
        body: Further attributes of the locomotion, such as `response`.
    """
    _require_positive("differential", wheel_separation=wheel_separation)
    limits = _wheel_limits("differential", max_wheel_speed, max_wheel_acceleration)
    return Locomotion("differential", ("left", "right"), _sides(wheel_separation), np.eye(2), *limits, **body)


def skid_drive(
    *,
    effective_wheel_separation: float,
    max_wheel_speed: float,
    max_wheel_acceleration: float,
    icr_offset: float = 0.0,
    **body: Any,
) -> Locomotion:
    """Skid drive: four driven, fixed wheels, in the order front left, front right, rear left, rear right.

    Args:
        effective_wheel_separation: Wheel separation of the differential drive that turns at the same rate [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
        icr_offset: Position, ahead of the base, of the point that has no lateral velocity, like the axle centre of a
            differential drive [m]. The instantaneous centre of rotation is beside this point; in a curve, the base,
            behind it, skids outward.
        body: Further attributes of the locomotion, such as `response`.
    """
    return _slipping_drive(
        "skid",
        _FOUR,
        effective_wheel_separation=effective_wheel_separation,
        max_wheel_speed=max_wheel_speed,
        max_wheel_acceleration=max_wheel_acceleration,
        icr_offset=icr_offset,
        **body,
    )


def tracked_drive(**parameters: Any) -> Locomotion:
    """Tracked drive: left and right track, which slip in turns; parameters and limits as of `skid_drive`."""
    return _slipping_drive("tracked", ("left", "right"), **parameters)


def mecanum_drive(
    *, half_length: float, half_width: float, max_wheel_speed: float, max_wheel_acceleration: float, **body: Any
) -> Locomotion:
    """Mecanum drive: four wheels with rollers at 45 deg, in the order front left, front right, rear left, rear right.

    Args:
        half_length: Half of the distance between the axles [m].
        half_width: Half of the distance between left and right wheels [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
        body: Further attributes of the locomotion, such as `response`.
    """
    _require_positive("mecanum", half_length=half_length, half_width=half_width)
    arm = half_length + half_width
    wheels = np.array([[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]])
    limits = _wheel_limits("mecanum", max_wheel_speed, max_wheel_acceleration)
    return Locomotion("mecanum", _FOUR, np.eye(3), wheels, *limits, **body)


def omni3_drive(
    *, base_radius: float, max_wheel_speed: float, max_wheel_acceleration: float, **body: Any
) -> Locomotion:
    """Three omnidirectional wheels at 60, 180 and 300 deg, in the order front left, rear, front right.

    The axes of the rollers are tangents of the wheels. A positive wheel speed drives the body anticlockwise around its
    centre.

    Args:
        base_radius: Distance from the centre of the body to the wheels' contacts [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
        body: Further attributes of the locomotion, such as `response`.
    """
    _require_positive("omni3", base_radius=base_radius)
    side = 0.5 * math.sqrt(3.0)  # exact zeros below: the rear wheel has no part in forward motion
    wheels = np.array([[-side, 0.5, base_radius], [0.0, -1.0, base_radius], [side, 0.5, base_radius]])
    limits = _wheel_limits("omni3", max_wheel_speed, max_wheel_acceleration)
    return Locomotion("omni3", ("front_left", "rear", "front_right"), np.eye(3), wheels, *limits, **body)


def twist_body(kind: str = "twist", *, axes: Mapping[str, AxisLimits], **body: Any) -> Locomotion:
    """Body that accepts twists, for example with legs, with rotors, or with its own wheel controller.

    Args:
        kind: `twist`, `legged` or `flying`.
        axes: Limits by axis; `vx` and `wz` are needed.
        body: Further attributes of the locomotion, such as `response`.
    """
    for axis in ("vx", "wz", *(("vy", "vz") if kind == "flying" else ())):
        if axis not in axes:
            raise InputError(f"a '{kind}' locomotion needs the axis '{axis}'; it has {', '.join(axes) or 'none'}.")
    for axis in axes:
        if axis not in AXES or (axis == "vz" and kind != "flying"):
            known = ", ".join(AXES if kind == "flying" else ("vx", "vy", "wz"))
            raise InputError(f"a '{kind}' locomotion has no axis '{axis}'. There are: {known}.")
    values = tuple(axis for axis in AXES if axis in axes)
    plane = [axis for axis in values if axis != "vz"]
    rows = {"vx": 0, "vy": 1, "wz": 2}
    twist_from_q = np.zeros((3, len(plane)))
    values_from_q = np.zeros((len(values), len(plane)))
    for column, axis in enumerate(plane):
        twist_from_q[rows[axis], column] = values_from_q[values.index(axis), column] = 1.0
    limits = np.array([(axes[axis].max_speed, axes[axis].max_acceleration) for axis in values]).T
    if kind == "flying":
        body = {"land_after": LAND_AFTER, **body}
    return Locomotion(kind, values, twist_from_q, values_from_q, limits[0], limits[1], wheeled=False, **body)


def make_locomotion(kind: str, **parameters: Any) -> Locomotion:
    """Create a locomotion of a kind in `LOCOMOTIONS`.

    Raises:
        UnknownName: No such kind; the message lists the kinds.
        InputError: A parameter is missing, superfluous or out of range.
    """
    if kind not in LOCOMOTIONS:
        raise UnknownName(unknown("locomotion", kind, LOCOMOTIONS))
    make, wanted = LOCOMOTIONS[kind]
    given = parameters.keys() - ATTRIBUTES
    if not set(wanted) <= given <= {*wanted, *OPTIONAL.get(kind, ())}:
        raise InputError(
            Fault(f"a '{kind}' locomotion takes {', '.join(wanted)}; found {', '.join(sorted(given)) or 'nothing'}.")
        )
    return make(**parameters)


_FOUR = ("front_left", "front_right", "rear_left", "rear_right")
LIMITS = ("max_wheel_speed", "max_wheel_acceleration")
"""Parameters of every kind of wheels: the limits of the actuator, or lower ones from the `[locomotion]` table."""

ATTRIBUTES = frozenset({"response", "land_after", "sway"})
"""Attributes of `Locomotion` that every kind takes."""

LOCOMOTIONS: dict[str, tuple[Callable[..., Locomotion], tuple[str, ...]]] = {
    "differential": (differential_drive, ("wheel_separation", *LIMITS)),
    "skid": (skid_drive, ("effective_wheel_separation", *LIMITS)),
    "tracked": (tracked_drive, ("effective_wheel_separation", *LIMITS)),
    "mecanum": (mecanum_drive, ("half_length", "half_width", *LIMITS)),
    "omni3": (omni3_drive, ("base_radius", *LIMITS)),
    "twist": (twist_body, ("axes",)),
    "legged": (partial(twist_body, "legged"), ("axes",)),
    "flying": (partial(twist_body, "flying"), ("axes",)),
}

HOLONOMIC = ("mecanum", "omni3")
"""Kinds of wheels that can move sideways by command."""

OPTIONAL = {"skid": ("icr_offset",), "tracked": ("icr_offset",)}
"""Optional parameters by kind of locomotion."""

LAND_AFTER = 5.0
"""Time in neutral after which a flying body lands by default [s]."""


def _sides(wheel_separation: float) -> Array:
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / wheel_separation, 1.0 / wheel_separation]])


def _slipping_drive(
    kind: str,
    wheels: tuple[str, ...],
    *,
    effective_wheel_separation: float,
    max_wheel_speed: float,
    max_wheel_acceleration: float,
    icr_offset: float = 0.0,
    **body: Any,
) -> Locomotion:
    """Drive of alternating left and right wheels that slip in turns; parameters as for `skid_drive`."""
    _require_positive(kind, effective_wheel_separation=effective_wheel_separation)
    if not math.isfinite(icr_offset):
        raise InputError(f"icr_offset of a '{kind}' drive must be a number, found {icr_offset}.")
    sides = _sides(effective_wheel_separation)
    if icr_offset != 0.0:
        sides[1] = -icr_offset * sides[2]
    values_from_q = np.tile(np.eye(2), (len(wheels) // 2, 1))
    limits = _wheel_limits(kind, max_wheel_speed, max_wheel_acceleration)
    return Locomotion(kind, wheels, sides, values_from_q, *limits, **body)


def _wheel_limits(kind: str, max_wheel_speed: float, max_wheel_acceleration: float) -> tuple[Any, Any]:
    _require_positive(kind, max_wheel_speed=max_wheel_speed, max_wheel_acceleration=max_wheel_acceleration)
    return max_wheel_speed, max_wheel_acceleration


def _require_positive(kind: str, **numbers: float) -> None:
    for name, value in numbers.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"{name} of a '{kind}' drive must be a positive number, found {value}.")
