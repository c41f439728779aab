"""Drive kinematics between wheel speeds and body twist, as small matrices.

Source: Lynch and Park, Modern Robotics (2017), 13.2 (mecanum) and 13.3 (differential). A skid drive is modelled as a
differential drive with an effective wheel separation, which is wider than the geometric one and identified from
turns (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).

Here and in the follower matrices are multiplied by `dot`: for small ones it is twice as fast as `@`, with bit-identical
results.
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
    """Linear drive kinematics, expressed in n drive coordinates q.

    q is (left, right) wheel linear speeds for a differential drive and (forward, left, turn) for a mecanum drive.
    `twist = twist_from_q @ q` and `wheel speeds = wheels_from_q @ q`, so wheel limits are linear in q.

    Attributes:
        name: Kind of drive, such as `differential`.
        wheels: Names of the w wheels, in the order of every wheel command.
        twist_from_q: Matrix from q to body twist; rows forward [m/s], left [m/s], turn [rad/s]; shape (3, n).
        wheels_from_q: Matrix from q to wheel linear speeds [m/s], shape (w, n).
        max_wheel_speed: Limit of the wheel linear speeds in both directions [m/s]; planning uses it, and the actuator's
            own limit may be higher.
        max_wheel_acceleration: Limit of the wheel linear accelerations in both directions [m/s2]; planning uses it, and
            the actuator's own limit may be higher.

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
            raise InputError(
                f"drive '{self.name}': its {n} coordinates are not determined by its wheel speeds; wheels_from_q has "
                f"rank {np.linalg.matrix_rank(self.wheels_from_q)}."
            )

    @cached_property
    def q_from_twist(self) -> Array:
        """Matrix from body twist to drive coordinates, shape (n, 3); it ignores motions that the drive cannot make."""
        # A skid drive moves sideways only as a consequence of a turn, so its lateral velocity is not commanded.
        commanded = self.twist_from_q * [[1.0], [0.0], [1.0]]
        if np.linalg.matrix_rank(commanded) < commanded.shape[1]:
            commanded = self.twist_from_q
        return np.asarray(np.linalg.pinv(commanded), dtype=float)

    @cached_property
    def q_from_wheels(self) -> Array:
        """Least-squares matrix from wheel linear speeds to drive coordinates, shape (n, w)."""
        return np.asarray(np.linalg.pinv(self.wheels_from_q), dtype=float)

    @cached_property
    def _twist_from_wheels(self) -> Array:
        """Matrix from wheel speeds to body twist, shape (3, w)."""
        return self.twist_from_q @ self.q_from_wheels

    @cached_property
    def speed_limit(self) -> float:
        """Maximum speed straight ahead [m/s]."""
        return self._limit(Twist2(1.0))

    @cached_property
    def turn_limit(self) -> float:
        """Maximum turn rate on the spot [rad/s]."""
        return self._limit(Twist2(0.0, turn=1.0))

    @cached_property
    def icr_offset(self) -> float:
        """Distance from the base forward to the centre of rotation in turns [m]; 0 unless a skid drive."""
        return 0.0 - float(self.twist_from_q[1] @ self.q_from_twist[:, 2])

    @cached_property
    def without_icr_offset(self) -> Drive:
        """Copy of this drive with the centre of rotation at the base, which approximates a skid drive in reverse."""
        turning = self.twist_from_q.copy()
        turning[1] += self.icr_offset * turning[2]
        return self if self.icr_offset == 0.0 else replace(self, twist_from_q=turning)

    @property
    def arm(self) -> float:
        """Wheel linear speed per turn rate [m]: half the wheel separation of a differential drive."""
        return self.speed_limit / self.turn_limit

    def coordinates(self, wheel_speeds: Array) -> Array:
        """Drive coordinates q, shape (n,), of wheel linear speeds (w,) [m/s]."""
        q: Array = self.q_from_wheels.dot(wheel_speeds)
        return q

    def wheel_speeds(self, twist: Twist2) -> Array:
        """Wheel linear speeds (w,) [m/s] of a body twist; lateral motion is ignored if the drive cannot make it."""
        q = self.q_from_twist.dot((twist.forward, twist.left, twist.turn))
        speeds: Array = self.wheels_from_q.dot(q)
        return speeds

    def twist(self, wheel_speeds: Array) -> Twist2:
        """Body twist of wheel linear speeds (w,) [m/s] without slip."""
        forward, left, turn = self._twist_from_wheels.dot(wheel_speeds).tolist()
        return twist2((forward, turn, left))

    def saturate(self, wheel_speeds: Array) -> Array:
        """Wheel speeds (w,) [m/s], all scaled by one factor so that the fastest is within `max_wheel_speed`."""
        fastest = _largest(wheel_speeds)
        if fastest <= self.max_wheel_speed:
            return wheel_speeds
        return wheel_speeds * (self.max_wheel_speed / fastest)

    def approach(self, now: Array, wanted: Array, period: float) -> Array:
        """Wheel speeds as near to the desired ones as the limits allow within one control period.

        The change of all wheels is scaled by one factor. As both limits are convex and `now` is within them, the result
        is within both, too.

        Args:
            now: Present wheel speeds, within the limits, shape (w,) [m/s].
            wanted: Desired wheel speeds, shape (w,) [m/s].
            period: Control period [s].

        Returns:
            Wheel speeds (w,) [m/s] with |v| <= max_wheel_speed and |v - now| <= max_wheel_acceleration * period.
        """
        step = self.saturate(wanted) - now
        largest, allowed = _largest(step), self.max_wheel_acceleration * period
        return now + step * (allowed / largest) if largest > allowed else now + step

    def _limit(self, twist: Twist2) -> float:
        return self.max_wheel_speed / _largest(self.wheel_speeds(twist))


def differential_drive(*, wheel_separation: float, max_wheel_speed: float, max_wheel_acceleration: float) -> Drive:
    """Differential drive: two driven wheels, in the order left, right.

    Args:
        wheel_separation: Distance between the contact points of the wheels [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
    """
    _require_positive("differential", wheel_separation=wheel_separation)
    return Drive(
        "differential", ("left", "right"), _sides(wheel_separation), np.eye(2), max_wheel_speed, max_wheel_acceleration
    )


def skid_drive(
    *, effective_wheel_separation: float, max_wheel_speed: float, max_wheel_acceleration: float, icr_offset: float = 0.0
) -> Drive:
    """Skid drive: four driven, fixed wheels, in the order front left, front right, rear left, rear right.

    Args:
        effective_wheel_separation: Wheel separation of the differential drive that turns at the same rate [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
        icr_offset: Position, ahead of the base, of the point that has no lateral velocity, like the axle centre of a
            differential drive [m]. The instantaneous centre of rotation is beside this point; in a curve, the base,
            behind it, skids outward.
    """
    _require_positive("skid", effective_wheel_separation=effective_wheel_separation)
    if not math.isfinite(icr_offset):
        raise InputError(f"icr_offset of a 'skid' drive must be a number, found {icr_offset}.")
    wheels, sides = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), _sides(effective_wheel_separation)
    if icr_offset != 0.0:
        sides[1] = -icr_offset * sides[2]
    return Drive("skid", _FOUR, sides, wheels, max_wheel_speed, max_wheel_acceleration)


def mecanum_drive(
    *, half_length: float, half_width: float, max_wheel_speed: float, max_wheel_acceleration: float
) -> Drive:
    """Mecanum drive: four wheels with rollers at 45 deg, in the order front left, front right, rear left, rear right.

    Args:
        half_length: Half of the distance between the axles [m].
        half_width: Half of the distance between left and right wheels [m].
        max_wheel_speed: Wheel linear speed limit [m/s].
        max_wheel_acceleration: Wheel linear acceleration limit [m/s2].
    """
    _require_positive("mecanum", half_length=half_length, half_width=half_width)
    arm = half_length + half_width
    wheels = np.array([[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]])
    return Drive("mecanum", _FOUR, np.eye(3), wheels, max_wheel_speed, max_wheel_acceleration)


def make_drive(kind: str, **numbers: float) -> Drive:
    """Create a drive of a kind in `DRIVES`.

    Args:
        kind: Kind of drive.
        numbers: Parameters of this kind of drive, by name.

    Raises:
        UnknownName: No such kind; the message lists the kinds.
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
"""Parameters of every kind of drive: the limits of the actuator, or lower ones from the `[drive]` table."""

DRIVES: dict[str, tuple[Callable[..., Drive], tuple[str, ...]]] = {
    "differential": (differential_drive, ("wheel_separation", *LIMITS)),
    "skid": (skid_drive, ("effective_wheel_separation", *LIMITS)),
    "mecanum": (mecanum_drive, ("half_length", "half_width", *LIMITS)),
}

OPTIONAL = {"skid": ("icr_offset",)}
"""Optional parameters by kind of drive."""


def _largest(numbers: Array) -> float:
    # Several times faster than numpy for a few numbers.
    return float(max(map(abs, numbers.tolist())))


def _sides(wheel_separation: float) -> Array:
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / wheel_separation, 1.0 / wheel_separation]])


def _require_positive(kind: str, **numbers: float) -> None:
    for name, value in numbers.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"{name} of a '{kind}' drive must be a positive number, found {value}.")
