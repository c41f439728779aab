"""Mount of a device in MuJoCo: its robot and noise, and the interface of the world for drivers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2, Pose3, Twist2, Twist3
from .body import Controls, Motors


class DriverWorld(Protocol):
    """Interface of the simulated world for drivers, available as `mount.world`.

    Poses and twists are ground truth, without noise. Robots have the names of the scenario. In the compiled model, the
    elements of a robot have its name as a prefix, such as `R2/base`. All values are those of the present state, which
    was reached at `stamp`.
    """

    @property
    def model(self) -> Any:
        """Compiled `MjModel` of MuJoCo; drivers must not change it."""
        ...

    @property
    def data(self) -> Any:
        """`MjData` of MuJoCo; drivers must not change it.

        Hold `lock` while reading it, and call `update_poses` before reading poses of sites or geoms.
        """
        ...

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Lock of the state, which each physics step holds; `MujocoSensor.read` holds it around `sample`."""
        ...

    @property
    def stamp(self) -> float:
        """Time of the present state [s]."""
        ...

    @property
    def step(self) -> float:
        """Physics step [s]."""
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

    def position(self, robot: str) -> list[float]:
        """x, y, z of the origin of a robot's base [m], world frame."""
        ...

    def twist(self, robot: str) -> Twist2:
        """Velocity of a robot's base, body frame."""
        ...

    def twist3(self, robot: str) -> Twist3:
        """Velocity of a robot's base in space; forward and left are horizontal, up and turn vertical."""
        ...

    def object_pose(self, name: str) -> Pose2:
        """Pose of a named mocap body or free body, world frame."""
        ...

    def clearance(
        self, robot: str, limit: float = ..., among: Literal["all", "robots", "obstacles"] = ...
    ) -> tuple[float, str]:
        """Distance from a robot's hull to the nearest obstacle, without the floor.

        Args:
            robot: Name of the robot.
            limit: Distance beyond which obstacles are ignored [m].
            among: Obstacles that count: other `robots`, `obstacles` that are no robots, or `all`.

        Returns:
            Distance [m], negative if they overlap, and name of the obstacle; (limit, "") if none is within the limit.
        """
        ...

    def room(self, x: float, y: float, z: float = ...) -> float:
        """Distance from a point (x, y, z), world frame [m], to the nearest static obstacle, without the floor [m]."""
        ...

    def sees(self, robot: str, other: str, height: float) -> bool:
        """Whether the line of sight between the bases of two robots is free, at a height over the floor [m]."""
        ...

    def bounds(self) -> tuple[float, float, float, float]:
        """Minimum x, minimum y, maximum x, maximum y of the static geoms [m]; infinite for an infinite floor."""
        ...

    def update_poses(self) -> None:
        """Compute the poses of all geoms and sites in `data` for the present state."""
        ...

    def sensor_address(self, robot: str, name: str) -> int:
        """Address of the first value of a sensor in a robot's model, for `sensed`; its other values follow.

        Raises:
            UnknownName: The robot's model has no such sensor.
        """
        ...

    def sensed(self, addresses: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
        """Values of sensors of the model at n addresses, in the present state, shape (n,)."""
        ...

    def past(self, stamp: float) -> Any:
        """`MjData` with the positions of the physics step nearest to a time within `remember`; poses are updated.

        It is valid until the next call.
        """
        ...

    def remember(self, duration: float) -> None:
        """Keep the positions of all bodies for a time [s], for `past`; the longest of all calls counts."""
        ...

    def motors(
        self,
        robot: str,
        names: Sequence[str],
        max_change: float = ...,
        delay: float = ...,
        radius: float = ...,
        slip: Sequence[float] = ...,
    ) -> Motors:
        """Get a handle of velocity motors of a robot's model. An actuator calls this once, in its constructor.

        Args:
            robot: Name of the robot.
            names: Names of the motors in the robot's model, without the robot's prefix.
            max_change: Maximum rate of change of a motor's speed [rad/s2].
            delay: Delay of each command [s], a whole number of physics steps.
            radius: Radius of the wheels [m]: a robot with turning wheels drives into what it touches.
            slip: Share of the travel that each wheel loses, or one share for all; none by default.

        Raises:
            UnknownName: The robot's model has no such actuator.
            InputError: The delay is not a whole number of physics steps.
        """
        ...

    def drive(self, motors: Motors, speeds: Sequence[float]) -> None:
        """Command the speeds of motors [rad/s], in the order of the motors."""
        ...

    def motor_speeds(self, motors: Motors) -> list[float]:
        """True speeds of motors [rad/s]."""
        ...

    def motor_angles(self, motors: Motors) -> list[float]:
        """True angles of motors since the start [rad]."""
        ...

    def controls(self, robot: str, names: Sequence[str]) -> Controls:
        """Get a handle of actuators in a robot's model: their ranges and joints.

        Args:
            robot: Name of the robot.
            names: Names of the actuators in the robot's model, without the robot's prefix.

        Raises:
            UnknownName: The robot's model has no such actuator.
        """
        ...

    def set_controls(self, controls: Controls, values: npt.ArrayLike) -> None:
        """Set the control values of actuators, limited to their ranges, from the next physics step on.

        Args:
            controls: Handle of the actuators.
            values: Control values, in MuJoCo's units of the actuators, shape (n,).

        Raises:
            DeviceError: The number of values is wrong, or a value is NaN.
        """
        ...

    def joint_positions(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True positions of the joints of actuators [rad or m], shape (n,); NaN without a joint."""
        ...

    def joint_velocities(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True velocities of the joints of actuators [rad/s or m/s], shape (n,); NaN without a joint."""
        ...


@dataclass(frozen=True)
class Mount:
    """Mount of a device: its world, its robot and its noise.

    Attributes:
        world: World of the robot.
        robot: Name of the robot, which is the prefix of its elements in the model.
        noise: Standard deviation of each value, SI units.
        rng: Random generator of the device.
        latency: Time until a reading of the device can be read [s].
        drop_out: Probability that a reading of the device is lost.
    """

    world: DriverWorld
    robot: str
    noise: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    latency: float = 0.0
    drop_out: float = 0.0

    def faults_rng(self) -> np.random.Generator:
        """New generator for faults of the device, independent of `rng`, so that its noise is equal with and without."""
        return self.rng.spawn(1)[0]
