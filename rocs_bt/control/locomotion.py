"""Locomotion: how a body realises a twist, with its limits, its response and its neutral state.

Wheels and bodies that accept twists, such as legged and flying robots, differ only in small matrices: the values of a
motion command are wheel linear speeds, or the components of the twist itself.

Sources: Lynch and Park, Modern Robotics (2017), 13.2 (mecanum and omnidirectional wheels) and 13.3 (differential). A
skid drive is modelled as a differential drive with an effective wheel separation, which is wider than the geometric one
and identified from turns (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).

Here and in the follower matrices are multiplied by `dot`: for small ones it is twice as fast as `@`, with bit-identical
results.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..errors import Fault, InputError, UnknownName, unknown
from ..geometry import Twist2, Twist3, twist2

Array: TypeAlias = npt.NDArray[np.float64]

AXES = ("vx", "vy", "vz", "wz")
"""Axes of a twist: forward, left and up [m/s], and turn, left positive [rad/s]."""


@dataclass(frozen=True)
class Response:
    """Response of a body to its motion commands.

    Attributes:
        delay: Dead time between a command and the beginning of its effect [s].
        lag: Time constant of the first-order response after the dead time [s].
        latency: Time from a reading of the motion until the body begins to brake [s].
        deceleration: Deceleration of the braking body [m/s2], by axis `vx`, `vy` and `vz`; axes without one use the
            acceleration limit of forward motion.
    """

    delay: float = 0.0
    lag: float = 0.0
    latency: float = 0.1
    deceleration: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("delay", "lag", "latency"):
            if not 0.0 <= (value := getattr(self, name)) < math.inf:
                raise InputError(f"{name} of a locomotion must be 0 s or more, found {value} s.")
        for axis, value in self.deceleration.items():
            if not 0.0 < value < math.inf:
                raise InputError(f"deceleration of the axis '{axis}' must be a positive number, found {value} m/s2.")

    @property
    def late(self) -> float:
        """Steady-state lag of the motion behind a ramp command [s]: dead time plus time constant."""
        return self.delay + self.lag


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
        # Rounded, because the pseudo-inverse is exact to about 1e-16 only.
        return _largest_multiple(np.round(self.command(Twist2(1.0)), 12), self.max_acceleration)

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
    def _decelerations(self) -> tuple[float, float, float]:
        """Deceleration along forward, left and up [m/s2]: as declared, else by the acceleration limits."""
        brake = self.response.deceleration
        units = {"vx": Twist3(1.0), "vy": Twist3(0.0, left=1.0), "vz": Twist3(0.0, up=1.0)}
        able = {axis: np.round(self.command(unit), 12) for axis, unit in units.items() if axis in self.axes}
        limits = {axis: _largest_multiple(values, self.max_acceleration) for axis, values in able.items()}
        vx, vy, vz = (brake.get(axis, limits.get(axis, math.inf)) for axis in units)
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
    wheels = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
    sides = _skid_sides("skid", effective_wheel_separation, icr_offset)
    limits = _wheel_limits("skid", max_wheel_speed, max_wheel_acceleration)
    return Locomotion("skid", _FOUR, sides, wheels, *limits, **body)


def tracked_drive(
    *,
    effective_wheel_separation: float,
    max_wheel_speed: float,
    max_wheel_acceleration: float,
    icr_offset: float = 0.0,
    **body: Any,
) -> Locomotion:
    """Tracked drive: two tracks, in the order left, right, that slip in turns like a skid drive.

    Args:
        effective_wheel_separation: Wheel separation of the differential drive that turns at the same rate [m].
        max_wheel_speed: Speed limit of the tracks [m/s].
        max_wheel_acceleration: Acceleration limit of the tracks [m/s2].
        icr_offset: Position of the point without lateral velocity ahead of the base, see `skid_drive` [m].
        body: Further attributes of the locomotion, such as `response`.
    """
    sides = _skid_sides("tracked", effective_wheel_separation, icr_offset)
    limits = _wheel_limits("tracked", max_wheel_speed, max_wheel_acceleration)
    return Locomotion("tracked", ("left", "right"), sides, np.eye(2), *limits, **body)


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


@dataclass(frozen=True)
class AxisLimits:
    """Limits of one axis of a twist.

    Attributes:
        max_speed: Speed limit in both directions [m/s, rad/s].
        max_acceleration: Acceleration limit [m/s2, rad/s2].
    """

    max_speed: float
    max_acceleration: float


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

    Args:
        kind: Kind of locomotion.
        parameters: Parameters of this kind, and further attributes of `Locomotion`, by name.

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

ATTRIBUTES = frozenset({"response", "land_after"})
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

_NEUTRAL = {"legged": "stand", "flying": "hover"}

LAND_AFTER = 5.0
"""Time in neutral after which a flying body lands by default [s]."""

LANDING_SPEED = 0.3
"""Speed at which a flying body descends to land, if its limit allows [m/s]."""


def _factor(values: Array, limits: Sequence[float]) -> float:
    """Largest factor, at most 1, by which values (m,) are within limits (m,)."""
    # Several times faster than numpy for a few numbers.
    factors = [limit / abs(v) for v, limit in zip(values.tolist(), limits, strict=True) if abs(v) > limit]
    return min(factors, default=1.0)


def _largest_multiple(values: Array, limits: Array) -> float:
    """Largest multiple of values (m,) that is within limits (m,)."""
    return float(min(limit / abs(v) for v, limit in zip(values.tolist(), limits.tolist(), strict=True) if v != 0.0))


def _sides(wheel_separation: float) -> Array:
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / wheel_separation, 1.0 / wheel_separation]])


def _skid_sides(kind: str, effective_wheel_separation: float, icr_offset: float) -> Array:
    _require_positive(kind, effective_wheel_separation=effective_wheel_separation)
    if not math.isfinite(icr_offset):
        raise InputError(f"icr_offset of a '{kind}' drive must be a number, found {icr_offset}.")
    sides = _sides(effective_wheel_separation)
    if icr_offset != 0.0:
        sides[1] = -icr_offset * sides[2]
    return sides


def _wheel_limits(kind: str, max_wheel_speed: float, max_wheel_acceleration: float) -> tuple[Any, Any]:
    _require_positive(kind, max_wheel_speed=max_wheel_speed, max_wheel_acceleration=max_wheel_acceleration)
    return max_wheel_speed, max_wheel_acceleration


def _require_positive(kind: str, **numbers: float) -> None:
    for name, value in numbers.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"{name} of a '{kind}' drive must be a positive number, found {value}.")
