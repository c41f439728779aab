"""Constants of a body that rules may use: its delay, its braking, and the reach of its corners in a turn."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..base.units import ACCELERATION, ANGULAR_ACCELERATION, LENGTH, SPEED, TIME, Dimension, Quantity
from .locomotion import Locomotion


class BodyValue(NamedTuple):
    """Declaration of a constant of a body."""

    dimension: Dimension
    doc: str


BODY_VALUES = {
    "latency": BodyValue(TIME, "time from a reading of the motion until the body begins to brake"),
    "deceleration": BodyValue(
        ACCELERATION, "deceleration of the braking body, the least of its directions in the plane"
    ),
    "turn_deceleration": BodyValue(ANGULAR_ACCELERATION, "the same for a turn on the spot"),
    "climb_deceleration": BodyValue(ACCELERATION, "the same for a vertical motion"),
    "speed_limit": BodyValue(SPEED, "maximum speed straight ahead"),
    "length": BodyValue(LENGTH, "length of the hull"),
    "front_sweep": BodyValue(LENGTH, "distance by which the corners reach beyond the front in a turn on the spot"),
    "side_sweep": BodyValue(LENGTH, "the same beyond the sides"),
}
"""Constants of a body, by name."""


def body_values(locomotion: Locomotion, length: float, width: float) -> dict[str, Quantity]:
    """Constants of a body, by the names of `BODY_VALUES`; without those that depend on an unknown size.

    Args:
        locomotion: Locomotion of the body.
        length: Length of the hull [m]; NaN if unknown.
        width: Width of the hull [m]; NaN if unknown.
    """
    found = {
        "latency": locomotion.response.latency,
        "deceleration": locomotion.deceleration,
        "turn_deceleration": locomotion.turn_deceleration,
        "climb_deceleration": locomotion.climb_deceleration,
        "speed_limit": locomotion.speed_limit,
        "length": length,
        "front_sweep": corner_sweep(width, length),
        "side_sweep": corner_sweep(length, width),
    }
    return {name: Quantity(v, BODY_VALUES[name].dimension) for name, v in found.items() if math.isfinite(v)}


def corner_sweep(along: float, across: float) -> float:
    """Distance by which the corners of a box reach beyond one of its sides in a turn about its centre [m].

    Args:
        along: Length of this side [m]; NaN if unknown, and then the result is NaN, too.
        across: Size of the box across this side [m].
    """
    return 0.5 * (math.hypot(along, across) - across)
