"""Motion of a body in any direction: its signals, and the range in the direction of motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.geometry import Twist2, Twist3
from ..base.signal import OPTIONAL_SIGNALS, Signal
from ..base.units import LENGTH, SPEED, TURN_RATE
from ..control.locomotion import Locomotion

STATIONARY = 0.02
"""Speed below which the direction of motion counts as unknown [m/s]."""

# Weight of a beam by its angle from the direction of motion, as the weights of `front` on the shipped robots.
_ANGLES = np.radians([10.0, 30.0, 50.0])
_WEIGHTS = (1.0, 0.85, 0.6)
_WIDEST = math.radians(60.0) + 1e-9


def declared(names: Sequence[str], max_age: float) -> list[Signal]:
    """Declarations of standard optional signals, with their maximum age [s]."""
    return [replace(OPTIONAL_SIGNALS[name], max_age=max_age) for name in names]


def course_signals(locomotion: Locomotion) -> list[str]:
    """Names of the signals about motion that is not straight ahead, which a body with these axes has."""
    axes = {"vy": "lateral_speed", "vz": "climb"}
    found = [signal for axis, signal in axes.items() if axis in locomotion.axes]
    return ["course_speed", *found] if found else []


def motion_signals(course: Sequence[str], max_age: float) -> list[Signal]:
    """Declarations of the signals of a body's motion, with those that `course_signals` lists."""
    return [
        Signal("speed", 1, (SPEED,), (-1e3, 1e3), max_age, "Forward speed of the body."),
        Signal("turn_rate", 1, (TURN_RATE,), (-1e3, 1e3), max_age, "Yaw rate of the body, left positive."),
        Signal("stop_distance", 1, (LENGTH,), (0.0, math.inf), max_age, "Distance to stop from the present motion."),
        *declared(course, max_age),
    ]


def motion_values(locomotion: Locomotion, twist: Twist2 | Twist3, course: Sequence[str]) -> dict[str, list[float]]:
    """Values of the signals that `motion_signals` declares."""
    speed = math.hypot(twist.forward, twist.left, twist.up) if course else 0.0
    values = {"course_speed": speed, "lateral_speed": twist.left, "climb": twist.up}
    return {
        "speed": [twist.forward],
        "turn_rate": [twist.turn],
        "stop_distance": [locomotion.stop_distance(twist)],
        **{name: [values[name]] for name in course},
    }


def course_range(bearings: NDArray[np.float64], ranges: NDArray[np.float64], twist: Twist2) -> float:
    """Range in the direction of motion, as an equivalent distance straight ahead [m].

    Args:
        bearings: Bearings of the beams, body frame, left positive, shape (n,) [rad].
        ranges: Ranges of the beams from the hull, shape (n,) [m].
        twist: Motion of the body.

    Returns:
        Minimum of the ranges within 60 deg of the direction of motion, each divided by its weight; +inf while the body
        is stationary, NaN if the motion or one of these ranges is unknown.
    """
    if math.isnan(twist.forward + twist.left):
        return math.nan
    if math.hypot(twist.forward, twist.left) < STATIONARY:
        return math.inf
    away = np.abs(np.remainder(bearings - math.atan2(twist.left, twist.forward) + math.pi, math.tau) - math.pi)
    near = away <= _WIDEST
    return float(np.min(ranges[near] / np.interp(away[near], _ANGLES, _WEIGHTS), initial=math.inf))
