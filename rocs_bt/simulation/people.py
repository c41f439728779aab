"""Scripts of people and of things that walk like them, back and forth between two points."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt

from ..base.units import NOT_NEGATIVE, Bounds, Metres, PositiveMetres, PositiveMetresPerSecond
from .scripted_object import ScriptedObject, Vector

Array = npt.NDArray[np.float64]

LEG_OFFSET = 0.1
"""Lateral distance of a leg from the middle of a person [m]."""


class Polynomial(ScriptedObject):
    """Moves back and forth on a curve with a random polynomial as its lateral deviation from a straight line.

    The motion resembles that of DynaBARN's obstacles (Nair et al., DynaBARN: Benchmarking Metric Ground Navigation in
    Dynamic Environments, SSRR 2022): they see nothing. The curve passes exactly through both ends, and the speed is
    constant but for the turn at an end. If a robot stops it, the object turns round after a while.

    Attributes:
        to_x, to_y: Second end of the path [m], world frame.
        speed: Speed along the path [m/s].
        deviation: Maximum lateral deviation of the path from the straight line [m].
        order: Order of the random polynomial.
    """

    to_x: Metres
    to_y: Metres
    speed: PositiveMetresPerSecond = 1.0
    deviation: Annotated[Metres, NOT_NEGATIVE] = 0.0
    order: Annotated[int, Bounds(1, 9)] = 3

    _KNOTS = 200
    _TURN = 0.8  # [s] from full speed to full speed in the other direction
    _PATIENCE = 1.0  # [s] for which it waits at a robot
    _HINDERED = 1e-3  # [m] to the intended position

    def begin(self) -> None:
        along = np.linspace(0.0, 1.0, self._KNOTS + 1)
        stray = np.polynomial.Polynomial(self.rng.uniform(-1.0, 1.0, self.order + 1))(2.0 * along - 1.0)
        stray *= along * (1.0 - along)
        aside = self.deviation * self.rng.uniform(0.5, 1.0) * stray / max(float(np.abs(stray).max()), 1e-12)
        dx, dy = self.to_x - self.start.x, self.to_y - self.start.y
        length = max(math.hypot(dx, dy), 1e-9)
        self._points = np.stack(
            [self.start.x + along * dx - aside * dy / length, self.start.y + along * dy + aside * dx / length], axis=1
        )
        steps = np.hypot(*np.diff(self._points, axis=0).T)
        self._lengths = np.concatenate([[0.0], np.cumsum(steps)])
        self._covered, self._rate, self._way = 0.0, self.speed, 1.0  # [m] and [m/s] along the curve, and direction
        self._stood = 0.0  # [s] at a robot

    def velocity(self, t: float, at: Vector) -> Vector:
        if math.dist(at, self._position()) > self._HINDERED:
            self._stand()
        else:
            self._stood = 0.0
        left = self._covered if self._way < 0.0 else float(self._lengths[-1]) - self._covered
        if self._way * self._rate > 0.0 and left <= self.speed * (0.25 * self._TURN + self.control_period):  # to brake
            self._way = -self._way
        change = 2.0 * self.speed * self.control_period / self._TURN
        self._rate += min(max(self._way * self.speed - self._rate, -change), change)
        self._covered = min(max(self._covered + self._rate * self.control_period, 0.0), float(self._lengths[-1]))
        x, y = self.towards(at, self._position())
        slower = min(1.5 * self.speed / max(math.hypot(x, y), 1e-9), 1.0)  # after a stop it does not jump
        return slower * x, slower * y

    def _stand(self) -> None:
        """A robot has stopped it."""
        self._covered -= self._rate * self.control_period
        self._rate = 0.0
        self._stood += self.control_period
        if self._stood >= self._PATIENCE:
            self._way, self._stood = -self._way, 0.0

    def _position(self) -> Vector:
        x, y = (float(np.interp(self._covered, self._lengths, self._points[:, axis])) for axis in (0, 1))
        return x, y


class SocialForce(ScriptedObject):
    """Pedestrian that walks back and forth and avoids people, robots and walls.

    It turns aside from others, and slows down, by the direction and speed at which it approaches their outlines. The
    law and its values were measured with pairs of pedestrians (Moussaid, Helbing, Garnier, Johansson, Combe and
    Theraulaz, Experimental study of the behavioural mechanisms underlying self-organization in human crowds, Proc. R.
    Soc. B, 2009). The force of walls is that of Helbing and Molnar, Social force model for pedestrian dynamics, 1995
    (U = 10 m2/s2, R = 0.2 m).

    Attributes:
        to_x, to_y: Second end of the walk [m], world frame; the first end is the start position.
        speed: Mean preferred walking speed [m/s].
        radius: Radius of the body [m].
        avoids_robots: Whether the pedestrian sees robots, and avoids them like people: 0 or 1.
    """

    to_x: Metres
    to_y: Metres
    speed: PositiveMetresPerSecond = 1.3
    radius: PositiveMetres = 0.25
    avoids_robots: Annotated[int, Bounds(0, 1)] = 1

    _RELAX = 0.5  # [s] relaxation time of the speed; Helbing and Molnar
    _FORCE, _SPEEDS, _SIZE, _AHEAD, _ASIDE = 4.5, 2.0, 0.35, 3.0, 2.0  # A [m/s2], lambda, gamma, n', n; Moussaid et al.
    _SIGHT = 5.0  # [m]
    _CLOSE, _STEP_BACK = 0.15, 60.0  # [m] gap below which it steps back, [m/s2] per metre
    _WALL, _WALL_FADE = 50.0, 0.2  # [m/s2], [m]
    _SIDESTEP = 0.6  # lateral fraction of a force of a wall from straight ahead; resolves the deadlock at a pillar
    _ARRIVED = 0.4  # [m] distance to an end at which the pedestrian turns back

    def begin(self) -> None:
        self._ends = ((self.start.x, self.start.y), (self.to_x, self.to_y))
        self._heading = 1
        self._speed = self.speed * float(self.rng.uniform(0.8, 1.2))
        self._v = np.zeros(2)
        self._here = np.array(self._ends[0])

    def velocity(self, t: float, at: Vector) -> Vector:
        here, target = np.array(at), np.array(self._ends[self._heading])
        self._v, self._here = (here - self._here) / self.control_period, here  # a robot may have stopped it
        if math.dist(at, self._ends[self._heading]) < self._ARRIVED:
            self._heading = 1 - self._heading
        wish = target - here
        wish *= self._speed / max(float(np.linalg.norm(wish)), 1e-9)
        push = (wish - self._v) / self._RELAX + self._others() + self._walls(here, wish / self._speed)
        v = self._v + push * self.control_period
        v *= min(1.3 * self._speed / max(float(np.linalg.norm(v)), 1e-9), 1.0)
        return float(v[0]), float(v[1])

    def _others(self) -> Array:
        push = np.zeros(2)
        for near in self.world.around(self.name, self._SIGHT, robots=bool(self.avoids_robots)):
            approach = self._SPEEDS * (self._v - self.world.velocity(near.name, near.point)) + near.direction
            push += self._avoidance(approach, near.direction, max(near.gap, 0.0) + 2.0 * self.radius)
            push -= self._STEP_BACK * max(self._CLOSE - near.gap, 0.0) * near.direction
        return push

    def _avoidance(self, approach: Array, direction: Array, distance: float) -> Array:
        """Force [m/s2] by one other: it brakes, and turns aside, to the right if the other is straight ahead."""
        size = float(np.linalg.norm(approach))
        if size < 1e-9:
            return np.zeros(2)
        along, reach = approach / size, self._SIZE * size
        left = np.array([-along[1], along[0]])
        angle = math.atan2(float(left @ direction), float(along @ direction))
        brake = math.exp(-distance / reach - (self._AHEAD * reach * angle) ** 2)
        turn = math.exp(-distance / reach - (self._ASIDE * reach * angle) ** 2)
        force: Array = -self._FORCE * (brake * along + math.copysign(turn, angle) * left)
        return force

    def _around(self, push: Array, ahead: Array) -> Array:
        """Add a force to the right, proportional to the part of the force `push` that acts against walking `ahead`."""
        against = max(-float(push @ ahead), 0.0)
        return push + self._SIDESTEP * against * np.array([ahead[1], -ahead[0]])

    def _walls(self, here: Array, ahead: Array) -> Array:
        """Force of static obstacles, along the gradient of the distance to them."""
        room, step = self.world.room(*here), 0.05
        gap = room - self.radius
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


class Leg(ScriptedObject):
    """Leg of a person that another script moves: it rests on the floor, or steps ahead at twice the person's speed.

    Attributes:
        person: Name of the object that the leg belongs to; its actor is before that of the leg in the scenario.
        side: `left` or `right`.
        stride: Way of the person in which both legs make one step [m].
    """

    person: str
    side: Literal["left", "right"]
    stride: PositiveMetres = 1.0

    _WALKS = 0.05  # [m/s] above which the person has a direction

    def begin(self) -> None:
        self._side = 1.0 if self.side == "left" else -1.0
        self._walked = 0.25 * self.stride * (1.0 - self._side)  # [m] the right leg is half a stride ahead
        self._ahead: Array | None = None
        self.world.mocap_body(self.person)
        self.world.add_part(self.name, self.person)

    def velocity(self, t: float, at: Vector) -> Vector:
        pose, v = self.world.object_pose(self.person), self.world.velocity(self.person)
        speed = float(np.hypot(*v))
        self._walked += speed * self.control_period
        if speed > self._WALKS:
            self._ahead = v / speed
        if self._ahead is None:
            return 0.0, 0.0
        phase = self._walked / self.stride % 1.0
        step = self.stride * (abs(phase - 0.5) - 0.25)  # from a quarter ahead to a quarter behind, and back
        left = np.array([-self._ahead[1], self._ahead[0]])
        target = np.array(pose[:2]) + v * self.control_period + step * self._ahead + self._side * LEG_OFFSET * left
        x, y = self.towards(at, (float(target[0]), float(target[1])))
        slower = min(max(2.5 * speed, 1.0) / max(math.hypot(x, y), 1e-9), 1.0)  # a turn or a stop does not make it jump
        return slower * x, slower * y
