"""Scene: the world of simulated devices, implemented by MuJoCo and by a flat world without physics."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2, Pose3, Twist3

Array = npt.NDArray[np.float64]

Rays = Callable[[], Array]
"""Function that casts rays in the present state; returns the distances to the first hits [m], +inf without one."""


class Scene(Protocol):
    """World of the shipped devices. All values are ground truth in the present state, which was reached at `stamp`."""

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Lock of the state; `read` of a sensor holds it around `sample`."""
        ...

    @property
    def stamp(self) -> float:
        """Time of the present state [s]."""
        ...

    @property
    def robots(self) -> Collection[str]:
        """Names of all robots in the world."""
        ...

    @property
    def places(self) -> Mapping[str, Pose2]:
        """Positions of the scenario's places by name, world frame."""
        ...

    def pose(self, robot: str) -> Pose2:
        """Pose of a robot's base, world frame."""
        ...

    def pose3(self, robot: str) -> Pose3:
        """Pose of a robot's base in space, world frame."""
        ...

    def twist3(self, robot: str) -> Twist3:
        """Velocity of a robot's base in space; forward and left are horizontal, up and turn vertical."""
        ...

    def sees(self, robot: str, other: str, height: float) -> bool:
        """Whether the line of sight between the bases of two robots is free, at a height over the floor [m]."""
        ...

    def direction(self, robot: str, site: str, axis: Literal["x", "z"]) -> tuple[float, float, float, float]:
        """x, y [m], yaw and elevation [rad] of an axis of a site, body frame."""
        ...

    def beams(self, robot: str, sensor: str, sites: Sequence[str], angles: Sequence[tuple[float, float]]) -> Rays:
        """Rays of a sensor with conical beams, distances of shape (sites, angles).

        Args:
            robot: Name of the robot.
            sensor: Name of the sensor.
            sites: Origins of the beams; the axis of a beam is the +z axis of its site.
            angles: Angles between each ray of a beam and its axis, left and up positive [rad].
        """
        ...

    def scan(self, robot: str, site: str, bearings: Sequence[float], reach: float, sweep: float) -> Rays:
        """Rays of a laser scanner, distances of shape (bearings,).

        Args:
            robot: Name of the robot; its own parts give no hit.
            site: Origin of the rays.
            bearings: Directions of the rays from the +x axis of the site, left positive [rad].
            reach: Distance beyond which hits may be ignored [m].
            sweep: Time from the first ray to the last, which is cast at present [s].
        """
        ...

    def motors(
        self,
        robot: str,
        names: Sequence[str],
        max_change: float = ...,
        delay: float = ...,
        radius: float = ...,
        slip: Sequence[float] = ...,
    ) -> Any:
        """Handle of velocity motors of a robot. A device gets it once, in `set_up`.

        Args:
            robot: Name of the robot.
            names: Names of the motors in the robot's model, without the robot's prefix.
            max_change: Maximum rate of change of a motor's speed [rad/s2].
            delay: Delay of each command [s], a whole number of physics steps.
            radius: Radius of the wheels [m]: a robot with turning wheels drives into what it touches.
            slip: Share of the travel that each wheel loses, or one share for all; none by default.

        Raises:
            UnknownName: The robot has no such motor.
            InputError: The delay is not a whole number of physics steps.
        """
        ...

    def drive(self, motors: Any, speeds: Sequence[float]) -> None:
        """Command the speeds of motors [rad/s], in the order of the motors."""
        ...

    def motor_speeds(self, motors: Any) -> list[float]:
        """True speeds of motors [rad/s]."""
        ...

    def motor_angles(self, motors: Any) -> list[float]:
        """True angles of motors since the start [rad]."""
        ...
