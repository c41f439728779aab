"""Kinds of locomotion: the table `[locomotion]` of drives on wheels or tracks, and of bodies that accept twists.

Sources: Lynch and Park, Modern Robotics (2017), 13.2 (mecanum and omnidirectional wheels) and 13.3 (differential). A
skid drive is modelled as a differential drive with an effective wheel separation, which is wider than the geometric one
and identified from turns (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from ..base.errors import UnknownName, unknown
from ..base.units import (
    ACCELERATION,
    ANGULAR_ACCELERATION,
    LENGTH,
    NOT_NEGATIVE,
    POSITIVE,
    TIME,
    Bounds,
    Metres,
    PositiveMetres,
    PositiveMetresPerSecond,
    PositiveRadiansPerSecond,
)
from ..declare import Open, Rest, Value, checked
from .locomotion import AXES, Array, Locomotion, Response

_Delay = Annotated[float, TIME, NOT_NEGATIVE]
_Acceleration = Annotated[float, ACCELERATION, POSITIVE]

LAND_AFTER = 5.0
"""Time in neutral after which a flying body lands by default [s]."""


class Braking(Value):
    """Table of an axis of a drive.

    Attributes:
        deceleration: Deceleration of the body along the axis [m/s2]; None for that of the locomotion.
    """

    deceleration: _Acceleration | None = None


class Axis(Braking):
    """Table of an axis of a body that accepts twists.

    Attributes:
        max_speed: Limit of the speed in both directions [m/s].
        max_acceleration: Limit of the acceleration [m/s2].
    """

    max_speed: PositiveMetresPerSecond
    max_acceleration: _Acceleration


class TurnAxis(Value):
    """Table `wz` of a body that accepts twists.

    Attributes:
        max_speed: Limit of the turn rate in both directions [rad/s].
        max_acceleration: Limit of the angular acceleration [rad/s2].
    """

    max_speed: PositiveRadiansPerSecond
    max_acceleration: Annotated[float, ANGULAR_ACCELERATION, POSITIVE]


class LocomotionSpec(Value):
    """`[locomotion]` table: how the robot moves.

    Attributes:
        kind: Kind of locomotion, one of `LOCOMOTIONS`.
        actuator: Name of the actuator that takes the motion commands.
        delay, lag, latency: Those of the `Response` [s].
        deceleration: Deceleration of the braking body [m/s2]; None for the acceleration limits.
    """

    kind: Literal["differential", "skid", "tracked", "mecanum", "omni3", "twist", "legged", "flying"]
    actuator: str = "wheels"
    delay: _Delay = 0.0
    lag: _Delay = 0.0
    latency: _Delay = 0.1
    deceleration: _Acceleration | None = None

    wheeled: ClassVar[bool] = True

    def build(self) -> Locomotion:
        """Locomotion of the table."""
        raise NotImplementedError

    @property
    def response(self) -> Response:
        """Delays and decelerations that the table declares; an axis without a deceleration has that of the table."""
        own = {axis: getattr(getattr(self, axis, None), "deceleration", None) for axis in ("vx", "vy", "vz")}
        braking = {axis: found for axis, each in own.items() if (found := each or self.deceleration) is not None}
        return Response(self.delay, self.lag, self.latency, braking)


class UnknownLocomotion(LocomotionSpec):
    """Locomotion of an unknown kind.

    Attributes:
        others: Further keys.
    """

    others: Annotated[Open, Rest()] = Open()


class Wheels(LocomotionSpec):
    """Drive on wheels.

    Attributes:
        max_wheel_speed: Wheel linear speed limit for planning [m/s]; None for that of the actuator.
        max_wheel_acceleration: Wheel linear acceleration limit for planning [m/s2]; None for that of the actuator.
        vx: Braking ahead.
    """

    max_wheel_speed: PositiveMetresPerSecond | None = None
    max_wheel_acceleration: _Acceleration | None = None
    vx: Braking = Braking()

    def _drive(self, names: tuple[str, ...], twist_from_q: Array, values_from_q: Array) -> Locomotion:
        limits: tuple[Any, Any] = self.max_wheel_speed, self.max_wheel_acceleration
        return Locomotion(self.kind, names, twist_from_q, values_from_q, *limits, response=self.response)


class Differential(Wheels):
    """Differential drive: two driven wheels, in the order left, right.

    Attributes:
        wheel_separation: Distance between the contact points of the wheels [m].
    """

    wheel_separation: PositiveMetres

    def build(self) -> Locomotion:
        """Locomotion of the drive."""
        return self._drive(("left", "right"), _sides(self.wheel_separation), np.eye(2))


class Tracked(Wheels):
    """Tracked drive: left and right track, which slip in turns.

    Attributes:
        effective_wheel_separation: Wheel separation of the differential drive that turns at the same rate [m].
        icr_offset: Position, ahead of the base, of the point that has no lateral velocity, like the axle centre of a
            differential drive [m]. The instantaneous centre of rotation is beside this point; in a curve, the base,
            behind it, skids outward.
    """

    effective_wheel_separation: PositiveMetres
    icr_offset: Metres = 0.0

    names: ClassVar[tuple[str, ...]] = ("left", "right")

    def build(self) -> Locomotion:
        """Locomotion of a drive of alternating left and right wheels that slip in turns."""
        sides = _sides(self.effective_wheel_separation)
        if self.icr_offset != 0.0:
            sides[1] = -self.icr_offset * sides[2]
        return self._drive(self.names, sides, np.tile(np.eye(2), (len(self.names) // 2, 1)))


_FOUR = ("front_left", "front_right", "rear_left", "rear_right")


class Skid(Tracked):
    """Skid drive: four driven, fixed wheels, in the order front left, front right, rear left, rear right."""

    names = _FOUR


class Holonomic(Wheels):
    """Drive on wheels that can move sideways by command.

    Attributes:
        vy: Braking of a lateral motion.
    """

    vy: Braking = Braking()


class Mecanum(Holonomic):
    """Mecanum drive: four wheels with rollers at 45 deg, in the order front left, front right, rear left, rear right.

    Attributes:
        half_length: Half of the distance between the axles [m].
        half_width: Half of the distance between left and right wheels [m].
    """

    half_length: PositiveMetres
    half_width: PositiveMetres

    def build(self) -> Locomotion:
        """Locomotion of the drive."""
        arm = self.half_length + self.half_width
        wheels = np.array([[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]])
        return self._drive(_FOUR, np.eye(3), wheels)


class Omni3(Holonomic):
    """Three omnidirectional wheels at 60, 180 and 300 deg, in the order front left, rear, front right.

    The axes of the rollers are tangents of the wheels. A positive wheel speed drives the body anticlockwise around its
    centre.

    Attributes:
        base_radius: Distance from the centre of the body to the wheels' contacts [m].
    """

    base_radius: PositiveMetres

    def build(self) -> Locomotion:
        """Locomotion of the drive."""
        side, radius = (
            0.5 * math.sqrt(3.0),
            self.base_radius,
        )  # exact zeros: the rear wheel has no part in forward motion
        wheels = np.array([[-side, 0.5, radius], [0.0, -1.0, radius], [side, 0.5, radius]])
        return self._drive(("front_left", "rear", "front_right"), np.eye(3), wheels)


class Twists(LocomotionSpec):
    """Body that accepts twists, for example with legs, with rotors, or with its own wheel controller.

    Attributes:
        vx: Forward axis.
        wz: Turn axis.
    """

    vx: Axis
    wz: TurnAxis

    wheeled = False

    def build(self) -> Locomotion:
        """Locomotion of a body with the axes that have a table."""
        axes = {axis: of for axis in AXES if (of := getattr(self, axis, None)) is not None}
        plane = [axis for axis in axes if axis != "vz"]
        rows = {"vx": 0, "vy": 1, "wz": 2}
        twist_from_q, values_from_q = np.zeros((3, len(plane))), np.zeros((len(axes), len(plane)))
        for column, axis in enumerate(plane):
            twist_from_q[rows[axis], column] = values_from_q[list(axes).index(axis), column] = 1.0
        speed, acceleration = np.array([(of.max_speed, of.max_acceleration) for of in axes.values()]).T
        return Locomotion(
            self.kind,
            tuple(axes),
            twist_from_q,
            values_from_q,
            speed,
            acceleration,
            wheeled=False,
            response=self.response,
            land_after=getattr(self, "land_after", math.inf),
            sway=getattr(self, "sway", 0.0),
        )


class Twist(Twists):
    """Body that accepts twists in the plane.

    Attributes:
        vy: Lateral axis; None if the body cannot move sideways.
    """

    vy: Axis | None = None


class Legged(Twist):
    """Body with legs.

    Attributes:
        sway: Amplitude of the periodic motion of the base beside its path [m].
    """

    sway: Annotated[float, LENGTH, Bounds(0.0, 0.2)] = 0.0


class Flying(Twists):
    """Body that flies.

    Attributes:
        vy: Lateral axis.
        vz: Vertical axis.
        land_after: Time in neutral after which the body lands [s]; +inf for never.
    """

    vy: Axis
    vz: Axis
    land_after: Annotated[float, TIME, Bounds(0.0, infinite=True)] = LAND_AFTER


LOCOMOTIONS: Mapping[str, type[LocomotionSpec]] = {
    "differential": Differential,
    "skid": Skid,
    "tracked": Tracked,
    "mecanum": Mecanum,
    "omni3": Omni3,
    "twist": Twist,
    "legged": Legged,
    "flying": Flying,
}


def make_locomotion(kind: str, **parameters: Any) -> Locomotion:
    """Create a locomotion of a kind in `LOCOMOTIONS`, with the keys of its table in SI units.

    Raises:
        UnknownName: No such kind; the message lists the kinds.
        InputError: A parameter is missing, superfluous or out of range.
    """
    if kind not in LOCOMOTIONS:
        raise UnknownName(unknown("locomotion", kind, LOCOMOTIONS))
    return checked(LOCOMOTIONS[kind], {"kind": kind, **parameters}, f"the locomotion '{kind}'").build()


def _sides(wheel_separation: float) -> Array:
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / wheel_separation, 1.0 / wheel_separation]])
