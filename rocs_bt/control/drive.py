"""Drive kinematics: what the wheels do to the body, and back, as three small matrices.

Source: Lynch and Park, Modern Robotics (2017), 13.2 (mecanum) and 13.3 (differential). A skid drive is a
differential one whose effective track, wider than the built one, is identified from turns (Mandow et al.,
Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).

Matrices are multiplied by `dot`, here and in the follower: for ones as small as these it takes half the time of `@`,
to the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..errors import Fault, InputError, UnknownName, unknown
from ..geometry import Twist2, twist2

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive whose body twist and wheel speeds are linear in a few coordinates q.

    With q = (left, right) rim speeds for a differential drive and q = (forward, left, turn) for a mecanum one,
    `twist = twist_from_q @ q` and `wheel speeds = wheels_from_q @ q`, so limits on wheels are linear in q.

    Attributes:
        name: The kind, such as `differential`.
        wheels: (w,) Names in the order of every wheel command.
        twist_from_q: (3, n) Rows forward [m/s], left [m/s], turn [rad/s].
        wheels_from_q: (w, n) Rim speeds [m/s].
        max_wheel_speed: Largest wheel linear speed that is planned, either way [m/s]; at most the actuator's limit.
        max_wheel_acceleration: Largest wheel linear acceleration that is planned, either way [m/s2]; at most the
            actuator's limit.

    Raises:
        InputError: A limit is not positive, or the matrices do not fit each other.
    """

    name: str
    wheels: tuple[str, ...]
    twist_from_q: Array
    wheels_from_q: Array
    max_wheel_speed: float
    max_wheel_acceleration: float

    def __post_init__(self) -> None:
        _require_positive(
            self.name, max_wheel_speed=self.max_wheel_speed, max_wheel_acceleration=self.max_wheel_acceleration
        )
        for field in ("twist_from_q", "wheels_from_q"):
            matrix = np.array(getattr(self, field), dtype=float)
            matrix.flags.writeable = False
            object.__setattr__(self, field, matrix)
        n = self.twist_from_q.shape[-1]
        if self.twist_from_q.shape != (3, n) or self.wheels_from_q.shape != (len(self.wheels), n):
            raise InputError(
                f"drive '{self.name}' with {len(self.wheels)} wheels and {n} coordinates needs matrices of shapes "
                f"(3, {n}) and ({len(self.wheels)}, {n}), found {self.twist_from_q.shape} and "
                f"{self.wheels_from_q.shape}."
            )
        if np.linalg.matrix_rank(self.wheels_from_q) < n:
            raise InputError(f"drive '{self.name}': its {n} coordinates do not follow from its wheel speeds.")

    @cached_property
    def q_from_twist(self) -> Array:
        """(n, 3) The coordinates of a body twist; motions that the drive cannot make are dropped."""
        # Who cannot choose to go sideways does so where a turn skids: that is no part of what is asked for.
        asked = self.twist_from_q * [[1.0], [0.0], [1.0]]
        if np.linalg.matrix_rank(asked) < asked.shape[1]:
            asked = self.twist_from_q
        return np.asarray(np.linalg.pinv(asked), dtype=float)

    @cached_property
    def q_from_wheels(self) -> Array:
        """(n, w) The coordinates that fit wheel speeds best, in the least-squares sense."""
        return np.asarray(np.linalg.pinv(self.wheels_from_q), dtype=float)

    @cached_property
    def _twist_from_wheels(self) -> Array:
        """(3, w) The body twist of wheel speeds."""
        return self.twist_from_q @ self.q_from_wheels

    @cached_property
    def speed_limit(self) -> float:
        """The fastest straight drive forward [m/s]."""
        return self._limit(Twist2(1.0))

    @cached_property
    def turn_limit(self) -> float:
        """The fastest turn on the spot [rad/s]."""
        return self._limit(Twist2(0.0, turn=1.0))

    @cached_property
    def pivot(self) -> float:
        """How far ahead of the base the place lies that moves only along the heading, however the robot turns [m]."""
        return 0.0 - float(self.twist_from_q[1] @ self.q_from_twist[:, 2])

    @cached_property
    def without_pivot(self) -> Drive:
        """This drive as one that turns about its base, which is nearly where a skid drive does that drives backward."""
        turning = self.twist_from_q.copy()
        turning[1] += self.pivot * turning[2]
        return self if self.pivot == 0.0 else replace(self, twist_from_q=turning)

    @property
    def arm(self) -> float:
        """Rim speed that a turn of 1 rad/s costs [m]: half the track of a differential drive."""
        return self.speed_limit / self.turn_limit

    def coordinates(self, wheel_speeds: Array) -> Array:
        """(n,) The drive coordinates q of wheel rim speeds (w,) [m/s]."""
        q: Array = self.q_from_wheels.dot(wheel_speeds)
        return q

    def wheel_speeds(self, twist: Twist2) -> Array:
        """(w,) Rim speeds [m/s] that make a body twist; sideways motion is dropped where there is none."""
        q = self.q_from_twist.dot((twist.forward, twist.left, twist.turn))
        speeds: Array = self.wheels_from_q.dot(q)
        return speeds

    def twist(self, wheel_speeds: Array) -> Twist2:
        """The body twist that wheel rim speeds (w,) [m/s] make without slip."""
        forward, left, turn = self._twist_from_wheels.dot(wheel_speeds).tolist()
        return twist2((forward, turn, left))

    def saturate(self, wheel_speeds: Array) -> Array:
        """(w,) The wheel speeds [m/s] scaled by one factor into what is planned; commands are limited by the gate."""
        fastest = _largest(wheel_speeds)
        if fastest <= self.max_wheel_speed:
            return wheel_speeds
        return wheel_speeds * (self.max_wheel_speed / fastest)

    def approach(self, now: Array, wanted: Array, period: float) -> Array:
        """The wheel speeds nearest to `wanted`, on the straight way there, that one period allows.

        Both limits are convex and `now` keeps them, so shortening the step in proportion always ends within both.

        Args:
            now: (w,) Present wheel speeds, within the limits [m/s].
            wanted: (w,) Where they should go [m/s].
            period: The time there is [s].

        Returns:
            (w,) Wheel speeds [m/s] with |v| <= max_wheel_speed and |v - now| <= max_wheel_acceleration * period.
        """
        step = self.saturate(wanted) - now
        largest, allowed = _largest(step), self.max_wheel_acceleration * period
        return now + step * (allowed / largest) if largest > allowed else now + step

    def _limit(self, twist: Twist2) -> float:
        return self.max_wheel_speed / _largest(self.wheel_speeds(twist))


def differential_drive(*, track: float, max_wheel_speed: float, max_wheel_acceleration: float) -> Drive:
    """Two driven wheels, in the order left, right.

    Args:
        track: Between the wheels' contact points [m].
        max_wheel_speed: Rim [m/s].
        max_wheel_acceleration: Rim [m/s2].
    """
    _require_positive("differential", track=track)
    return Drive("differential", ("left", "right"), _sides(track), np.eye(2), max_wheel_speed, max_wheel_acceleration)


def skid_drive(
    *, effective_track: float, max_wheel_speed: float, max_wheel_acceleration: float, pivot: float = 0.0
) -> Drive:
    """Four driven wheels that cannot steer, in the order front left, front right, rear left, rear right.

    Args:
        effective_track: The track of the differential drive that turns as this one does [m].
        max_wheel_speed: Rim [m/s].
        max_wheel_acceleration: Rim [m/s2].
        pivot: How far ahead of the base the place lies that moves only where the robot looks, as the middle of a
            differential drive's axle does: about it the robot turns, and what is behind it skids outward [m].
    """
    _require_positive("skid", effective_track=effective_track)
    if not math.isfinite(pivot):
        raise InputError(f"pivot of a 'skid' drive must be a number, found {pivot}.")
    wheels, sides = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), _sides(effective_track)
    if pivot != 0.0:
        sides[1] = -pivot * sides[2]
    return Drive("skid", _FOUR, sides, wheels, max_wheel_speed, max_wheel_acceleration)


def mecanum_drive(
    *, half_length: float, half_width: float, max_wheel_speed: float, max_wheel_acceleration: float
) -> Drive:
    """Four wheels with rollers at 45 degrees, in the order front left, front right, rear left, rear right.

    Args:
        half_length: Half of the distance between the axles [m].
        half_width: Half of the distance between left and right wheels [m].
        max_wheel_speed: Rim [m/s].
        max_wheel_acceleration: Rim [m/s2].
    """
    _require_positive("mecanum", half_length=half_length, half_width=half_width)
    arm = half_length + half_width
    wheels = np.array([[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]])
    return Drive("mecanum", _FOUR, np.eye(3), wheels, max_wheel_speed, max_wheel_acceleration)


def make_drive(kind: str, **numbers: float) -> Drive:
    """The drive of a kind that `DRIVES` knows, from the numbers its constructor takes.

    Raises:
        UnknownName: No such kind; the message lists what exists.
        InputError: A number is missing, superfluous or out of range.
    """
    if kind not in DRIVES:
        raise UnknownName(unknown("drive", kind, DRIVES))
    make, wanted = DRIVES[kind]
    if not set(wanted) <= set(numbers) <= {*wanted, *OPTIONAL.get(kind, ())}:
        raise InputError(
            Fault(f"a '{kind}' drive takes {', '.join(wanted)}; found {', '.join(sorted(numbers)) or 'nothing'}.")
        )
    return make(**numbers)


_FOUR = ("front_left", "front_right", "rear_left", "rear_right")
LIMITS = ("max_wheel_speed", "max_wheel_acceleration")
"""Numbers of every kind: what a robot's actuator allows, or less where its `[drive]` prefers that."""

DRIVES: dict[str, tuple[Callable[..., Drive], tuple[str, ...]]] = {
    "differential": (differential_drive, ("track", *LIMITS)),
    "skid": (skid_drive, ("effective_track", *LIMITS)),
    "mecanum": (mecanum_drive, ("half_length", "half_width", *LIMITS)),
}

OPTIONAL = {"skid": ("pivot",)}
"""Numbers that a kind takes and does not need."""


def _largest(numbers: Array) -> float:
    # For a handful of numbers several times faster than numpy.
    return float(max(map(abs, numbers.tolist())))


def _sides(track: float) -> Array:
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / track, 1.0 / track]])


def _require_positive(kind: str, **numbers: float) -> None:
    for name, value in numbers.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"{name} of a '{kind}' drive must be a positive number, found {value}.")
