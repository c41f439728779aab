"""Scripted objects: doors, boxes and people that scripts move along the floor.

A scripted object is a mocap body of the world, so contacts do not move it, except for the script `free`. The script
sets the velocity once per control period, and the world moves the object in each physics step. The motion is therefore
continuous, and contacts with robots are detected. An object that touches a robot stops: it neither pushes the robot
away nor passes through it. The scripts of people are in people.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from ..base.geometry import Pose2, wrap_angle
from ..base.units import NOT_NEGATIVE, POSITIVE, Bounds, Kilograms, Metres, PositiveSeconds, Radians, Seconds
from ..declare import Wrong
from .scripted_object import ScriptedObject, Vector


class Slide(ScriptedObject):
    """Door or box that moves along a straight line at a given time, and optionally back.

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

    def begin(self) -> None:
        self._share = 0.0  # covered fraction of the line

    def velocity(self, t: float, at: Vector) -> Vector:
        then, x, y = t + self.control_period, self.start.x, self.start.y
        self._share = self._covered(at)
        back = then > self.return_at
        target, since = ((x, y), self.return_at) if back else ((self.to_x, self.to_y), self.depart_at)
        if then > since and all(math.dist(target, pose[:2]) >= self.wait_distance for pose in self._robots()):
            step = min(self.control_period, then - since) / self.duration
            self._share = max(self._share - step, 0.0) if back else min(self._share + step, 1.0)
        return self.towards(at, (x + self._share * (self.to_x - x), y + self._share * (self.to_y - y)))

    @property
    def states(self) -> dict[str, Pose2]:
        other = "shut" if self.at_target == "open" else "open"
        target = self.start._replace(x=self.to_x, y=self.to_y)
        return {self.at_target: target, other: self.start} if self.at_target else {}

    def _covered(self, at: Vector) -> float:
        """Covered fraction of the line at a position [m]; a robot in the way may have stopped the object."""
        along = self.to_x - self.start.x, self.to_y - self.start.y
        length = along[0] ** 2 + along[1] ** 2
        share = ((at[0] - self.start.x) * along[0] + (at[1] - self.start.y) * along[1]) / max(length, 1e-12)
        return min(max(share, 0.0), 1.0)

    def _robots(self) -> list[Pose2]:
        return [self.world.pose(name) for name in self.world.robots] if self.wait_distance else []


class Swing(ScriptedObject):
    """Boom or gate that swings about the vertical axis through the origin of its body, with a random phase.

    Attributes:
        amplitude: Largest angle from the middle, which is the object's yaw in the scenario, to either side [rad].
        period: Duration of a swing to both sides and back [s].
    """

    amplitude: Annotated[Radians, Bounds(0.0, math.pi, above=True)]
    period: PositiveSeconds

    def begin(self) -> None:
        self._phase = float(self.rng.uniform(0.0, 2.0 * math.pi))
        self.world.place_object(self.name, self.start._replace(yaw=self._yaw(0.0)))

    def velocity(self, t: float, at: Vector) -> Vector:
        return 0.0, 0.0

    def step(self, t: float) -> None:
        turn = wrap_angle(self._yaw(t + self.control_period) - self.world.object_pose(self.name).yaw)
        most = 2.0 * math.pi * self.amplitude / self.period  # after a stop it does not hurry
        self.world.set_object_turn(self.name, self._stopped_turn(min(max(turn / self.control_period, -most), most)))

    def _yaw(self, t: float) -> float:
        swing = self.amplitude * math.sin(self._phase + 2.0 * math.pi * t / self.period)
        return wrap_angle(self.start.yaw + swing)


class Free(ScriptedObject):
    """Object that only physics moves: robots push it.

    Attributes:
        mass: Mass of the object [kg].
    """

    mass: Annotated[Kilograms, POSITIVE]

    def velocity(self, t: float, at: Vector) -> Vector:
        return 0.0, 0.0

    def step(self, t: float) -> None:
        pass
