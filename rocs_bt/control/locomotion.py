"""Locomotion: how a body realises a twist, with its limits, its response and its neutral state.

Wheels and bodies that accept twists, such as legged and flying robots, differ only in small matrices: the values of a
motion command are wheel linear speeds, or the components of the twist itself.

Here and in the follower matrices are multiplied by `dot`: for small ones it is twice as fast as `@`, with bit-identical
results.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Twist2, Twist3, twist2
from .axis import Array as Array
from .axis import AxisLimits as AxisLimits

AXES = ("vx", "vy", "vz", "wz")
"""Axes of a twist: forward, left and up [m/s], and turn, left positive [rad/s]."""


@dataclass(frozen=True)
class Response:
    """Response of a body to its motion commands.

    Attributes:
        delay: Dead time between a command and the beginning of its effect [s].
        lag: Time constant of the first-order response after the dead time [s].
        latency: Time from a reading of the motion until the body begins to brake [s].
        deceleration: Deceleration of the braking body [m/s2], by axis `vx`, `vy` and `vz`; axes without one use their
            acceleration limit.
    """

    delay: float = 0.0
    lag: float = 0.0
    latency: float = 0.1
    deceleration: Mapping[str, float] = field(default_factory=dict)

    @property
    def late(self) -> float:
        """Time by which the motion is behind a command that ramps [s]: dead time plus time constant."""
        return self.delay + self.lag


_NEUTRAL = {"legged": "stand", "flying": "hover", "twist": "rest"}


@dataclass(frozen=True, eq=False)
class Locomotion:
    """Linear map between body twists and motion commands, in n coordinates q of the motion in the plane.

    q is (left, right) wheel linear speeds for a differential drive, and the possible components of the twist for other
    bodies. `twist = twist_from_q @ q` and `values = values_from_q @ q`, so the limits of a command are linear in q. The
    vertical speed of a flying body is one more value, independent of q.

    Attributes:
        kind: Kind of locomotion, such as `differential`.
        values: Names of the m values of a motion command, in order: wheels, or axes such as `vx`.
        twist_from_q: Matrix from q to body twist; rows forward [m/s], left [m/s], turn [rad/s]; shape (3, n).
        values_from_q: Matrix from q to values, shape (m, n): wheel linear speeds [m/s], or components of the twist.
        max_speed: Limit of the values in both directions, shape (m,) [m/s, rad/s]; planning uses it, and the actuator's
            own limit may be higher.
        max_acceleration: Limit of the rates of change of the values, shape (m,) [m/s2, rad/s2]; planning uses it too.
        wheeled: Whether the values are wheel linear speeds.
        response: Delays and deceleration of the body.
        land_after: Time in neutral after which a body that hovers lands [s]; +inf for never.
        sway: Amplitude of the base's periodic motion beside its path while the body walks [m]; arrivals tolerate it.

    Raises:
        InputError: A limit is not positive, or the matrices do not fit each other.
    """

    kind: str
    values: tuple[str, ...]
    twist_from_q: Array
    values_from_q: Array
    max_speed: Array
    max_acceleration: Array
    wheeled: bool = True
    response: Response = field(default_factory=Response)
    land_after: float = math.inf
    sway: float = 0.0

    def __post_init__(self) -> None:
        m = len(self.values)
        for name in ("max_speed", "max_acceleration"):
            limits = np.broadcast_to(np.asarray(getattr(self, name), dtype=float), (m,)).copy()
            if not (np.isfinite(limits).all() and (limits > 0.0).all()):
                raise InputError(f"{name} of a '{self.kind}' locomotion must be positive numbers, found {limits}.")
            self._freeze(name, limits)
        for name in ("twist_from_q", "values_from_q"):
            self._freeze(name, np.array(getattr(self, name), dtype=float))
        n = self.twist_from_q.shape[-1]
        if self.twist_from_q.shape != (3, n) or self.values_from_q.shape != (m, n):
            raise InputError(
                f"a '{self.kind}' locomotion with {m} values and {n} coordinates needs matrices of shapes (3, {n}) and "
                f"({m}, {n}), found {self.twist_from_q.shape} and {self.values_from_q.shape}."
            )
        if np.linalg.matrix_rank(self.values_from_q) < n:
            raise InputError(
                f"'{self.kind}' locomotion: its {n} coordinates are not determined by its values; values_from_q has "
                f"rank {np.linalg.matrix_rank(self.values_from_q)}."
            )

    def _freeze(self, name: str, array: Array) -> None:
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    @cached_property
    def wheels(self) -> tuple[str, ...]:
        """Names of the wheels, in the order of every command; empty for a body that accepts twists."""
        return self.values if self.wheeled else ()

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Axes of the twist that can be commanded independently, of `AXES`."""
        lateral = self.twist_from_q.shape[1] == 3
        able = {"vx": True, "vy": lateral, "vz": not self.wheeled and "vz" in self.values, "wz": True}
        return tuple(axis for axis in AXES if able[axis])

    @property
    def neutral(self) -> str:
        """State of the body without a command: wheels brake, legs do not step, and a flying body hovers."""
        return _NEUTRAL.get(self.kind, "brake")

    @cached_property
    def rest(self) -> tuple[float, ...]:
        """Values of the command not to move: zeros, m of them."""
        return (0.0,) * len(self.values)

    @cached_property
    def q_from_twist(self) -> Array:
        """Matrix from body twist to coordinates, shape (n, 3); it ignores motions that the body cannot make."""
        # A skid drive moves sideways only as a consequence of a turn, so its lateral velocity is not commanded.
        commanded = self.twist_from_q * [[1.0], [0.0], [1.0]]
        if np.linalg.matrix_rank(commanded) < commanded.shape[1]:
            commanded = self.twist_from_q
        return np.asarray(np.linalg.pinv(commanded), dtype=float)

    @cached_property
    def q_from_values(self) -> Array:
        """Least-squares matrix from values to coordinates, shape (n, m)."""
        return np.asarray(np.linalg.pinv(self.values_from_q), dtype=float)

    @cached_property
    def _twist_from_values(self) -> Array:
        """Matrix from values to planar twist, shape (3, m)."""
        return self.twist_from_q @ self.q_from_values

    @cached_property
    def speed_limit(self) -> float:
        """Maximum speed straight ahead [m/s]."""
        return _largest_multiple(self.command(Twist2(1.0)), self.max_speed)

    @cached_property
    def turn_limit(self) -> float:
        """Maximum turn rate on the spot [rad/s]."""
        return _largest_multiple(self.command(Twist2(0.0, turn=1.0)), self.max_speed)

    @cached_property
    def acceleration_limit(self) -> float:
        """Maximum acceleration straight ahead [m/s2]."""
        return self.axis_limits("vx").max_acceleration

    @cached_property
    def turn_acceleration_limit(self) -> float:
        """Maximum angular acceleration on the spot [rad/s2]."""
        if self.wheeled:
            return self.acceleration_limit / self.arm
        return _largest_multiple(self.command(Twist2(0.0, turn=1.0)), self.max_acceleration)

    def axis_limits(self, axis: str) -> AxisLimits:
        """Largest speed and acceleration of a motion along one axis alone."""
        twist = {name: float(name == axis) for name in AXES}
        # Rounded, because the pseudo-inverse is exact to about 1e-16 only.
        values = np.round(self.command(Twist3(*twist.values())), 12)
        return AxisLimits(*(_largest_multiple(values, limits) for limits in (self.max_speed, self.max_acceleration)))

    @cached_property
    def icr_offset(self) -> float:
        """Distance from the base forward to the centre of rotation in turns [m]; 0 unless a skid drive."""
        return 0.0 - float(self.twist_from_q[1] @ self.q_from_twist[:, 2])

    @cached_property
    def without_icr_offset(self) -> Locomotion:
        """Copy with the centre of rotation at the base, which approximates a skid drive in reverse."""
        turning = self.twist_from_q.copy()
        turning[1] += self.icr_offset * turning[2]
        return self if self.icr_offset == 0.0 else replace(self, twist_from_q=turning)

    @cached_property
    def arm(self) -> float:
        """Forward speed limit per turn rate limit [m]: half the wheel separation of a differential drive."""
        return self.speed_limit / self.turn_limit

    def curve_factors(self, curvature: Array) -> tuple[Array, Array]:
        """Factors by which curves (k,) [rad/m] need more speed and more acceleration than a straight, each (k,)."""
        if self.wheeled:
            factor = 1.0 + curvature * self.arm
            return factor, factor
        arms = self.arm, self.acceleration_limit / self.turn_acceleration_limit
        speed, acceleration = (np.maximum(1.0, curvature * arm) for arm in arms)
        return speed, acceleration

    def coordinates(self, values: Array) -> Array:
        """Coordinates q, shape (n,), of the values (m,) of a command."""
        q: Array = self.q_from_values.dot(values)
        return q

    def command(self, twist: Twist2 | Twist3) -> Array:
        """Values (m,) of the command for a body twist; motions that the body cannot make are ignored."""
        q = self.q_from_twist.dot((twist.forward, twist.left, twist.turn))
        values: Array = self.values_from_q.dot(q)
        if self._vertical is not None:
            values[self._vertical] = twist.up
        return values

    def twist(self, values: Array) -> Twist2:
        """Planar body twist of the values (m,) of a command, without slip."""
        if not self.wheeled:  # the product below would spread the NaN of one axis to all
            axes = dict(zip(self.values, map(float, values), strict=True))
            return twist2((axes["vx"], axes["wz"], axes.get("vy", 0.0)))
        forward, left, turn = self._twist_from_values.dot(values).tolist()
        return twist2((forward, turn, left))

    def twist3(self, values: Sequence[float] | Array) -> Twist3:
        """Body twist of the values (m,) of a command, with the vertical speed."""
        plane = self.twist(np.asarray(values, dtype=float))
        up = 0.0 if self._vertical is None else float(values[self._vertical])
        return Twist3(plane.forward, plane.left, up, plane.turn)

    def stop_distance(self, twist: Twist2 | Twist3) -> float:
        """Distance that a body with a twist moves until it is stationary [m], by its latency and deceleration.

        Lateral motion counts only for bodies that can command it: the skid of other drives in a turn does not.
        """
        left = twist.left if "vy" in self.axes else 0.0
        up = twist.up if self._vertical is not None else 0.0
        speeds = (abs(twist.forward), abs(left), abs(up))
        course = math.hypot(*speeds)
        parts = [course * v / (2.0 * a) for v, a in zip(speeds, self._decelerations, strict=True)]
        # Wheels share the work of all axes; the axes of other bodies brake independently.
        return course * self.response.latency + (sum(parts) if self.wheeled else max(parts))

    @cached_property
    def deceleration(self) -> float:
        """Deceleration of the braking body in the plane, in the direction in which it is least [m/s2]."""
        return min(self._decelerations[:2])

    @cached_property
    def climb_deceleration(self) -> float:
        """Deceleration of a vertical motion [m/s2]; +inf for a body on the ground."""
        return self._decelerations[2] if "vz" in self.axes else math.inf

    @cached_property
    def turn_deceleration(self) -> float:
        """Angular deceleration on the spot [rad/s2]: that of braking wheels, else the acceleration limit."""
        return self._decelerations[0] / self.arm if self.wheeled else self.turn_acceleration_limit

    @cached_property
    def _decelerations(self) -> tuple[float, float, float]:
        """Deceleration along forward, left and up [m/s2]: as declared, else by the acceleration limits."""
        brake, axes = self.response.deceleration, self.axes
        vx, vy, vz = (
            brake.get(axis) or (self.axis_limits(axis).max_acceleration if axis in axes else math.inf)
            for axis in ("vx", "vy", "vz")
        )
        return vx, vy, vz

    def saturate(self, values: Array) -> Array:
        """Values (m,), all scaled by one factor so that each is within its `max_speed`."""
        factor = _factor(values, self.max_speed.tolist())
        return values if factor == 1.0 else values * factor

    def approach(self, now: Array, wanted: Array, period: float) -> Array:
        """Values as near to the desired ones as the limits allow within one control period.

        The change of all values is scaled by one factor. As both limits are convex and `now` is within them, the result
        is within both, too.

        Args:
            now: Present values, within the limits, shape (m,).
            wanted: Desired values, shape (m,).
            period: Control period [s].

        Returns:
            Values (m,) with |v| <= max_speed and |v - now| <= max_acceleration * period.
        """
        step = self.saturate(wanted) - now
        factor = _factor(step, [limit * period for limit in self.max_acceleration.tolist()])
        return now + step if factor == 1.0 else now + step * factor

    @cached_property
    def _vertical(self) -> int | None:
        """Index of the vertical speed in a command; None for a body on the ground."""
        return self.values.index("vz") if "vz" in self.axes else None


def _factor(values: Array, limits: Sequence[float]) -> float:
    """Largest factor, at most 1, by which values (m,) are within limits (m,)."""
    # Several times faster than numpy for a few numbers.
    factors = [limit / abs(v) for v, limit in zip(values.tolist(), limits, strict=True) if abs(v) > limit]
    return min(factors, default=1.0)


def _largest_multiple(values: Array, limits: Array) -> float:
    """Largest multiple of values (m,) that is within limits (m,)."""
    return float(min(limit / abs(v) for v, limit in zip(values.tolist(), limits.tolist(), strict=True) if v != 0.0))
