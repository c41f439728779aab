"""Scripted objects: doors, boxes and people that scripts move along the floor.

A scripted object is a mocap body of the world, so contacts do not move it, except for the script `free`. The script
sets the velocity once per control period, and the world moves the object in each physics step. The motion is therefore
continuous, and contacts with robots are detected. An object that touches a robot stops: it neither pushes the robot
away nor passes through it. The scripts of people are in people.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np

from ..base.errors import UnknownName, unknown
from ..base.geometry import Pose2, wrap_angle
from ..base.units import NOT_NEGATIVE, POSITIVE, Bounds, Kilograms, Metres, PositiveSeconds, Radians, Seconds
from ..catalog import ActorSpec
from ..declare import Value, Wrong
from ..devices.mujoco import MujocoWorld
from .people import Leg, Polynomial, SocialForce
from .scripted_object import ScriptedObject, Vector


class SlideParameters(Value):
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
    depart_at: Annotated[Seconds, NOT_NEGATIVE]
    duration: PositiveSeconds = 1.0
    return_at: Annotated[Seconds, Bounds(0.0, infinite=True)] = math.inf
    wait_distance: Metres = 0.0
    at_target: Literal["", "open", "shut"] = ""

    def _check(self) -> Iterator[Wrong]:
        """Fault of a return before the arrival."""
        if self.return_at < self.depart_at + self.duration:
            arrival = f"{self.depart_at + self.duration:g} s"
            yield Wrong("return_at", f"the return at {self.return_at:g} s is before the arrival at {arrival}.")


class Slide(ScriptedObject):
    """Door or box that moves along a straight line at a given time, and optionally back."""

    Parameters = SlideParameters

    def __init__(self, *args: Any, parameters: SlideParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._share = 0.0  # covered fraction of the line

    def velocity(self, t: float, at: Vector) -> Vector:
        p, then, x, y = self._p, t + self.period, self.start.x, self.start.y
        self._share = self._covered(at)
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

    def _covered(self, at: Vector) -> float:
        """Covered fraction of the line at a position [m]; a robot in the way may have stopped the object."""
        along = self._p.to_x - self.start.x, self._p.to_y - self.start.y
        length = along[0] ** 2 + along[1] ** 2
        share = ((at[0] - self.start.x) * along[0] + (at[1] - self.start.y) * along[1]) / max(length, 1e-12)
        return min(max(share, 0.0), 1.0)

    def _robots(self) -> list[Pose2]:
        return [self.world.pose(name) for name in self.world.robots] if self._p.wait_distance else []


class SwingParameters(Value):
    """Parameters of the script `swing`.

    Attributes:
        amplitude: Largest angle from the middle, which is the object's yaw in the scenario, to either side [rad].
        period: Duration of a swing to both sides and back [s].
    """

    amplitude: Annotated[Radians, Bounds(0.0, math.pi, above=True)]
    period: PositiveSeconds


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
        most = 2.0 * math.pi * self._p.amplitude / self._p.period  # after a stop it does not hurry
        self.world.set_object_turn(self.name, self._stopped_turn(min(max(turn / self.period, -most), most)))

    def _yaw(self, t: float) -> float:
        swing = self._p.amplitude * math.sin(self._phase + 2.0 * math.pi * t / self._p.period)
        return wrap_angle(self.start.yaw + swing)


class FreeParameters(Value):
    """Parameters of the script `free`.

    Attributes:
        mass: Mass of the object [kg].
    """

    mass: Annotated[Kilograms, POSITIVE]


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


SCRIPTED_OBJECTS: Mapping[str, Any] = {
    "slide": Slide,
    FREE: Free,
    "swing": Swing,
    "polynomial": Polynomial,
    "social_force": SocialForce,
    "leg": Leg,
}


def make_scripted_object(
    actor: ActorSpec,
    *,
    world: MujocoWorld,
    start: Pose2,
    rng: np.random.Generator,
    period: float,
) -> ScriptedObject:
    """Construct a scripted object by the name of its script.

    Args:
        actor: Table of the object in the scenario: name of its mocap body, and its script, a key of `SCRIPTED_OBJECTS`.
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
    parameters = actor.script_parameters(cls.Parameters)
    made: ScriptedObject = cls(actor.name, world, start, rng, period, parameters=parameters)
    return made
