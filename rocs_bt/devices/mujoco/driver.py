"""Base classes of users' drivers in MuJoCo, and the interface of the world for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, Protocol, cast

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2, Twist2
from ..simulated.device import Bound, SimulatedActuator, SimulatedSensor
from ..simulated.scene import Scene
from .body import Controls


class DriverWorld(Scene, Protocol):
    """Interface of the simulated world for drivers, available as `world`.

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
    def step(self) -> float:
        """Physics step [s]."""
        ...

    def twist(self, robot: str) -> Twist2:
        """Velocity of a robot's base, body frame."""
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


class _InMujoco(Bound):
    world: DriverWorld = cast("DriverWorld", None)


class MujocoSensor(_InMujoco, SimulatedSensor):
    """Base class of users' sensors in MuJoCo, which implement `sample`. Their fields are the keys in robot.toml."""

    def prepare(self, model: Any, name: str) -> None:
        """Add the elements that the sensor needs to the robot's MjSpec before compilation; none by default.

        Args:
            model: `MjSpec` of the robot, in which names have no prefix yet.
            name: Name of the sensor in robot.toml.
        """


class MujocoActuator(_InMujoco, SimulatedActuator):
    """Base class of users' actuators in MuJoCo, which implement `command` and `neutral`, and may have an inner loop."""
