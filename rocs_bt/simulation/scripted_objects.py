"""Scripted objects: doors, boxes and people that scripts move along the floor.

A scripted object is a mocap body of the world, so contacts do not move it, except for the script `free`. The script
sets the velocity once per control period, and the world moves the object in each physics step. The motion is therefore
continuous, and contacts with robots are detected.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from ..catalog import ActorSpec
from ..drivers.mujoco import MujocoWorld
from ..errors import Fault, InputError, UnknownName, unknown
from ..geometry import Pose2, wrap_angle
from ..units import Kilograms, Metres, MetresPerSecond, Radians, Seconds
from .script_parameters import script_parameters

Vector = tuple[float, float]


class ScriptedObject(ABC):
    """Script that moves one object.

    Args:
        name: Name of the object in the world.
        world: The world; a script may read ground truth.
        start: Start pose.
        rng: Random stream of the script.
        period: Control period [s].
    """

    Parameters: ClassVar[type]

    def __init__(self, name: str, world: MujocoWorld, start: Pose2, rng: np.random.Generator, period: float) -> None:
        self.name = name
        self.world = world
        self.start = start
        self.rng = rng
        self.period = period
        world.place_object(name, start)

    @property
    def states(self) -> dict[str, Pose2]:
        """Poses of the object that have a name, such as `open`; none by default."""
        return {}

    @abstractmethod
    def velocity(self, t: float, at: Vector) -> Vector:
        """Velocity of the object for the next control period [m/s], world frame.

        Args:
            t: Time [s].
            at: Position of the object [m], world frame.
        """

    def step(self, t: float) -> None:
        """Set the velocity for one control period."""
        pose = self.world.object_pose(self.name)
        self.world.set_object_velocity(self.name, self.velocity(t, (pose.x, pose.y)))

    def towards(self, at: Vector, target: Vector) -> Vector:
        """Velocity [m/s] that moves the object from `at` to `target` [m] within one control period."""
        return (target[0] - at[0]) / self.period, (target[1] - at[1]) / self.period


@dataclass(frozen=True, kw_only=True)
class SlideParameters:
    """Parameters of the script `slide`.

    Attributes:
        to_x, to_y: Target position [m], world frame.
        depart_at: Start time [s].
        duration: Duration of the motion [s].
        return_at: Start time of the return [s]; never by default.
        wait_distance: Distance from a robot to the target position below which the object waits [m], like a door with
            a sensor.
        at_target: Whether a door is `open` or `shut` at the target position; at its start it is the other.
    """

    to_x: Metres
    to_y: Metres
    depart_at: Seconds
    duration: Seconds = 1.0
    return_at: Seconds = math.inf
    wait_distance: Metres = 0.0
    at_target: Literal["", "open", "shut"] = ""

    def __post_init__(self) -> None:
        if not (
            self.depart_at >= 0.0
            and 0.0 < self.duration < math.inf
            and self.return_at >= self.depart_at + self.duration
        ):
            raise InputError(
                Fault(
                    "a slide needs depart_at >= 0 s, duration > 0 s and return_at >= depart_at + duration; found "
                    f"{self.depart_at:g} s, {self.duration:g} s and {self.return_at:g} s."
                )
            )


class Slide(ScriptedObject):
    """Door or box that moves along a straight line at a given time, and optionally back."""

    Parameters = SlideParameters

    def __init__(self, *args: Any, parameters: SlideParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._share = 0.0  # covered fraction of the line

    def velocity(self, t: float, at: Vector) -> Vector:
        p, then, x, y = self._p, t + self.period, self.start.x, self.start.y
        back = then > p.return_at
        target, since = ((x, y), p.return_at) if back else ((p.to_x, p.to_y), p.depart_at)
        if then > since and all(math.dist(target, pose[:2]) >= p.wait_distance for pose in self._robots()):
            step = min(self.period, then - since) / p.duration
            self._share = max(self._share - step, 0.0) if back else min(self._share + step, 1.0)
        return self.towards(at, (x + self._share * (p.to_x - x), y + self._share * (p.to_y - y)))

    @property
    def states(self) -> dict[str, Pose2]:
        p = self._p
        other = "shut" if p.at_target == "open" else "open"
        target = self.start._replace(x=p.to_x, y=p.to_y)
        return {p.at_target: target, other: self.start} if p.at_target else {}

    def _robots(self) -> list[Pose2]:
        return [self.world.pose(name) for name in self.world.robots] if self._p.wait_distance else []


@dataclass(frozen=True, kw_only=True)
class SwingParameters:
    """Parameters of the script `swing`.

    Attributes:
        amplitude: Largest angle from the middle, which is the object's yaw in the scenario, to either side [rad].
        period: Duration of a swing to both sides and back [s].
    """

    amplitude: Radians
    period: Seconds

    def __post_init__(self) -> None:
        if not (0.0 < self.amplitude <= math.pi and 0.0 < self.period < math.inf):
            raise InputError(
                Fault(
                    "a swing needs 0 deg < amplitude <= 180 deg and period > 0 s; found "
                    f"{math.degrees(self.amplitude):g} deg and {self.period:g} s."
                )
            )


class Swing(ScriptedObject):
    """Boom or gate that swings about the vertical axis through the origin of its body, with a random phase."""

    Parameters = SwingParameters

    def __init__(self, *args: Any, parameters: SwingParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._phase = float(self.rng.uniform(0.0, 2.0 * math.pi))
        self.world.place_object(self.name, self.start._replace(yaw=self._yaw(0.0)))

    def velocity(self, t: float, at: Vector) -> Vector:
        return 0.0, 0.0

    def step(self, t: float) -> None:
        turn = wrap_angle(self._yaw(t + self.period) - self.world.object_pose(self.name).yaw)
        self.world.set_object_turn(self.name, turn / self.period)

    def _yaw(self, t: float) -> float:
        swing = self._p.amplitude * math.sin(self._phase + 2.0 * math.pi * t / self._p.period)
        return wrap_angle(self.start.yaw + swing)


@dataclass(frozen=True, kw_only=True)
class FreeParameters:
    """Parameters of the script `free`.

    Attributes:
        mass: Mass of the object [kg].
    """

    mass: Kilograms

    def __post_init__(self) -> None:
        if not 0.0 < self.mass < math.inf:
            raise InputError(Fault(f"a free object needs a positive mass, found {self.mass:g} kg."))


class Free(ScriptedObject):
    """Object that only physics moves: robots push it."""

    Parameters = FreeParameters

    def __init__(self, *args: Any, parameters: FreeParameters) -> None:
        super().__init__(*args)

    def velocity(self, t: float, at: Vector) -> Vector:
        return 0.0, 0.0

    def step(self, t: float) -> None:
        pass


FREE = "free"
"""Name of the script of objects that only physics moves."""


@dataclass(frozen=True, kw_only=True)
class PolynomialParameters:
    """Parameters of the script `polynomial`.

    Attributes:
        to_x, to_y: Second end of the path [m], world frame.
        speed: Speed along the path [m/s].
        deviation: Maximum lateral deviation of the path from the straight line [m].
        order: Order of the random polynomial.
    """

    to_x: Metres
    to_y: Metres
    speed: MetresPerSecond = 1.0
    deviation: Metres = 0.0
    order: int = 3

    def __post_init__(self) -> None:
        if not (0.0 < self.speed < math.inf and 0.0 <= self.deviation < math.inf and 1 <= self.order <= 9):
            raise InputError(
                Fault(
                    "speed must be positive, deviation 0 or more, and order 1 to 9, found "
                    f"{self.speed:g} m/s, {self.deviation:g} m and {self.order}."
                )
            )


class Polynomial(ScriptedObject):
    """Moves back and forth on a curve with a random polynomial as its lateral deviation from a straight line.

    The motion resembles that of DynaBARN's obstacles (Nair et al., DynaBARN: Benchmarking Metric Ground Navigation in
    Dynamic Environments, SSRR 2022). The curve passes exactly through both ends, and the speed is constant.
    """

    Parameters = PolynomialParameters
    _KNOTS = 200

    def __init__(self, *args: Any, parameters: PolynomialParameters) -> None:
        super().__init__(*args)
        p = self._p = parameters
        along = np.linspace(0.0, 1.0, self._KNOTS + 1)
        stray = np.polynomial.Polynomial(self.rng.uniform(-1.0, 1.0, p.order + 1))(2.0 * along - 1.0)
        stray *= along * (1.0 - along)
        aside = p.deviation * self.rng.uniform(0.5, 1.0) * stray / max(float(np.abs(stray).max()), 1e-12)
        dx, dy = p.to_x - self.start.x, p.to_y - self.start.y
        length = max(math.hypot(dx, dy), 1e-9)
        self._points = np.stack(
            [self.start.x + along * dx - aside * dy / length, self.start.y + along * dy + aside * dx / length], axis=1
        )
        steps = np.hypot(*np.diff(self._points, axis=0).T)
        self._lengths = np.concatenate([[0.0], np.cumsum(steps)])
        self._begin = float(self.rng.uniform(0.0, 2.0 * self._lengths[-1]))  # random phase
        self.world.place_object(self.name, Pose2(*self._position(0.0), self.start.yaw))

    def velocity(self, t: float, at: Vector) -> Vector:
        return self.towards(at, self._position(t + self.period))

    def _position(self, t: float) -> Vector:
        length = float(self._lengths[-1])
        covered = math.fmod(self._begin + self._p.speed * t, 2.0 * length)
        covered = min(covered, 2.0 * length - covered)
        x, y = (float(np.interp(covered, self._lengths, self._points[:, axis])) for axis in (0, 1))
        return x, y


@dataclass(frozen=True, kw_only=True)
class SocialForceParameters:
    """Parameters of the script `social_force`.

    Attributes:
        to_x, to_y: Second end of the walk [m], world frame; the first end is the start position.
        speed: Mean preferred walking speed [m/s].
        radius: Radius of the body [m].
        avoids_robots: Whether the pedestrian avoids robots like people: 0 or 1.
    """

    to_x: Metres
    to_y: Metres
    speed: MetresPerSecond = 1.3
    radius: Metres = 0.25
    avoids_robots: int = 1

    def __post_init__(self) -> None:
        if not (0.0 < self.speed < math.inf and 0.0 < self.radius < math.inf and self.avoids_robots in (0, 1)):
            raise InputError(
                Fault(
                    "speed and radius must be positive and avoids_robots 0 or 1, found "
                    f"{self.speed:g} m/s, {self.radius:g} m and {self.avoids_robots}."
                )
            )


class SocialForce(ScriptedObject):
    """Pedestrian that walks back and forth and avoids people, robots and walls (social force model).

    People and robots exert the circular social force, weaker from behind than from ahead. Its parameters A = 0.42 m/s2,
    B = 1.65 m and lambda = 0.12 were fitted to videos of pedestrians (Johansson, Helbing and Shukla, Specification of
    the Social Force Pedestrian Model by Evolutionary Adjustment to Video Tracking Data, 2007). The force of walls is
    that of Helbing and Molnar, Social force model for pedestrian dynamics, 1995 (U = 10 m2/s2, R = 0.2 m).
    """

    Parameters = SocialForceParameters
    _RELAX = 0.5  # [s] relaxation time of the speed; Helbing and Molnar
    _PUSH, _FADE, _BEHIND = 0.42, 1.65, 0.12  # [m/s2], [m], -
    _WALL, _WALL_FADE = 50.0, 0.2  # [m/s2], [m]
    _SIDESTEP = (
        0.6  # lateral fraction of a force from straight ahead; resolves deadlocks of a head-on meeting or a pillar
    )
    _ARRIVED = 0.4  # [m] distance to an end at which the pedestrian turns back

    def __init__(self, *args: Any, parameters: SocialForceParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._ends = ((self.start.x, self.start.y), (parameters.to_x, parameters.to_y))
        self._heading = 1
        self._speed = parameters.speed * float(self.rng.uniform(0.8, 1.2))
        self._v = np.zeros(2)

    def velocity(self, t: float, at: Vector) -> Vector:
        here, target = np.array(at), np.array(self._ends[self._heading])
        if math.dist(at, self._ends[self._heading]) < self._ARRIVED:
            self._heading = 1 - self._heading
        wish = target - here
        wish *= self._speed / max(float(np.linalg.norm(wish)), 1e-9)
        ahead = wish / self._speed
        push = (wish - self._v) / self._RELAX + self._others(here, ahead) + self._walls(here, ahead)
        self._v = self._v + push * self.period
        fastest = 1.3 * self._speed / max(float(np.linalg.norm(self._v)), 1e-9)
        self._v *= min(fastest, 1.0)
        return float(self._v[0]), float(self._v[1])

    def _others(self, here: Any, ahead: Any) -> Any:
        world = self.world
        poses = [world.object_pose(name) for name in world.objects if name != self.name]
        poses += [world.pose(name) for name in world.robots] if self._p.avoids_robots else []
        push = np.zeros(2)
        for pose in poses:
            away = here - (pose.x, pose.y)
            distance = max(float(np.linalg.norm(away)), 1e-3)
            if distance < 5.0:
                away /= distance
                seen = self._BEHIND + (1.0 - self._BEHIND) * (1.0 - float(ahead @ away)) / 2.0
                force = self._PUSH * math.exp((2.0 * self._p.radius - distance) / self._FADE) * seen
                push += self._around(force * away, ahead)
                # Bodies do not pass through each other.
                push += 10.0 * max(2.2 * self._p.radius - distance, 0.0) * away / self._p.radius
        return push

    def _around(self, push: Any, ahead: Any) -> Any:
        """Add a force to the right, proportional to the part of the force `push` that acts against walking `ahead`."""
        against = max(-float(push @ ahead), 0.0)
        return push + self._SIDESTEP * against * np.array([ahead[1], -ahead[0]])

    def _walls(self, here: Any, ahead: Any) -> Any:
        """Force of static obstacles, along the gradient of the distance to them."""
        room, step = self.world.room(*here), 0.05
        gap = room - self._p.radius
        if gap > 1.0:
            return np.zeros(2)
        x, y = here
        slope = np.array(
            [
                self.world.room(x + step, y) - self.world.room(x - step, y),
                self.world.room(x, y + step) - self.world.room(x, y - step),
            ]
        )
        size = float(np.linalg.norm(slope))
        push = self._WALL * math.exp(-max(gap, -0.2) / self._WALL_FADE)
        return self._around(min(push, 20.0) * slope / size, ahead) if size > 0.0 else np.zeros(2)


SCRIPTED_OBJECTS: Mapping[str, Any] = {
    "slide": Slide,
    FREE: Free,
    "swing": Swing,
    "polynomial": Polynomial,
    "social_force": SocialForce,
}


def make_scripted_object(
    actor: ActorSpec,
    file: Path,
    *,
    world: MujocoWorld,
    start: Pose2,
    rng: np.random.Generator,
    period: float,
) -> ScriptedObject:
    """Construct a scripted object by the name of its script.

    Args:
        actor: Table of the object in the scenario: name of its mocap body, and its script, a key of `SCRIPTED_OBJECTS`.
        file: File of the scenario.
        world: World of the object.
        start: Start pose, world frame.
        rng: Random stream of the script.
        period: Control period [s].

    Raises:
        InputError: Unknown script, wrong parameters, or no such mocap body; lists every fault.
    """
    if actor.script not in SCRIPTED_OBJECTS:
        raise UnknownName(unknown("object script", actor.script, SCRIPTED_OBJECTS))
    cls = SCRIPTED_OBJECTS[actor.script]
    parameters = script_parameters(cls.Parameters, actor, file)
    made: ScriptedObject = cls(actor.name, world, start, rng, period, parameters=parameters)
    return made
