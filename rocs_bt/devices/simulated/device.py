"""Base classes of simulated devices: a class is the table of its keys, and `bind` makes a device of a robot of it."""

from __future__ import annotations

import copy
import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np

from ...declare import Value
from ...interfaces.device import Actuator, Reading, Sensor
from .scene import Scene

_EARLY = 1e-9  # [s] by which a sum of times may be too large


class Bound:
    """Attributes of a device after `bind`.

    Attributes:
        name: Name of the device in robot.toml; empty before `bind`.
        world: World of the robot.
        robot: Name of the robot, which is the prefix of its elements in a model.
        rng: Random generator of the device.
    """

    # This class is not a `Declared`, so these are members, and no key of a derived class can have their names.
    __setattr__: Any = object.__setattr__  # a bound device has a state, unlike a `Value`
    name = ""
    robot: str
    world: Scene
    rng: np.random.Generator

    def _placed(self, name: str, world: Scene, robot: str, rng: np.random.Generator | None) -> Self:
        made = copy.copy(self)
        made.name, made.world, made.robot = name, world, robot
        made.rng = np.random.default_rng(0) if rng is None else rng
        return made

    def set_up(self) -> None:
        """Prepare the device, once its world and its keys are known; nothing by default."""

    def faults_rng(self) -> np.random.Generator:
        """New generator for faults of the device, independent of `rng`, so that its noise is equal with and without."""
        return self.rng.spawn(1)[0]


class SimulatedSensor(Bound, Value, Sensor):
    """Base class of simulated sensors. The fields of a derived class are its keys in robot.toml.

    Attributes:
        noise: Standard deviation of each value, SI units.
    """

    noise = 0.0

    def bind(
        self,
        name: str,
        world: Scene,
        robot: str,
        rng: np.random.Generator | None = None,
        *,
        noise: float = 0.0,
        latency: float = 0.0,
        drop_out: float = 0.0,
    ) -> Self:
        """Make a sensor of a robot, with the keys of this one.

        Args:
            name: Name of the sensor in robot.toml.
            world: World of the robot, made with this sensor.
            robot: Name of the robot.
            rng: Random generator of the noise; by default one with a fixed seed.
            noise: Standard deviation of each value, SI units.
            latency: Time until a reading can be read [s].
            drop_out: Probability that a reading is lost.

        Raises:
            InputError: The sensor does not fit the world.
        """
        made = self._placed(name, world, robot, rng)
        made._begin(noise, latency, drop_out)
        made.set_up()
        return made

    def _begin(self, noise: float, latency: float, drop_out: float) -> None:
        self.noise = noise
        self._delivery = LossyDelivery(latency, drop_out, self.faults_rng())

    def mounted_at(self) -> Sequence[str]:
        """Names of the sites of the robot's model that the sensor needs; none by default."""
        return ()

    def beam_angles(self) -> Sequence[tuple[float, float]]:
        """Angles of the rays that the sensor casts by `Scene.beams` at each of these sites; none by default."""
        return ()

    def sample(self) -> list[float]:
        """Compute the values in the present state of the world, SI units, without noise; `world.lock` is held."""
        raise NotImplementedError

    def read(self) -> Reading:
        with self.world.lock:
            return self._delivery.read(self.world.stamp, self.measure)

    def measure(self) -> Reading:
        """Measure in the present state of the world: `sample` with noise and limits; `world.lock` is held."""
        values = self.sample()
        if self.noise > 0.0:
            errors = self.rng.normal(0.0, self.noise, len(values)).tolist()
            values = [v + e for v, e in zip(values, errors, strict=True)]
        return Reading(self.world.stamp, self.limit(values))

    def limit(self, values: list[float]) -> list[float]:
        """Limit values, after noise was added, to the measuring range of the device; by default they are unchanged."""
        return values


class SimulatedActuator(Bound, Value, Actuator):
    """Base class of simulated actuators. The fields of a derived class are its keys in robot.toml.

    A derived class has `size`, the number of values of a command, as a class attribute, or sets it in `set_up`.
    """

    def bind(self, name: str, world: Scene, robot: str, rng: np.random.Generator | None = None) -> Self:
        """Make an actuator of a robot, without a safety gate, with the keys of this one.

        Args:
            name: Name of the actuator in robot.toml.
            world: World of the robot.
            robot: Name of the robot.
            rng: Random generator of the actuator; a fixed one by default.

        Raises:
            InputError: The actuator does not fit the world.
        """
        made = self._placed(name, world, robot, rng)
        made.set_up()
        return made

    def before_step(self, t: float) -> None:
        """Inner loop, called before each physics step at time t [s], also after the robot was stopped.

        A derived class may override it to set the controls of its robot (`world.set_controls`); it must not wait.
        `world.lock` is held, and all members of `world` are those of the present state. `rng` is the actuator's own
        random generator. An exception is a failure of the actuator, as in `command`; `neutral` follows, and the loop
        continues, because a body without wheels needs it to stay upright.
        """

    @property
    def has_loop(self) -> bool:
        """Whether a derived class overrides `before_step`."""
        return type(self).before_step is not SimulatedActuator.before_step


class LossyDelivery:
    """Delivery of readings from a simulated device to the robot: some are lost, the others arrive after a latency.

    The first reading arrives at once, because the robot was there before the start.

    Args:
        latency: Time from the end of a measurement until its reading can be read [s].
        drop_out: Probability that a whole reading is lost.
        rng: Random generator of the losses.
    """

    def __init__(self, latency: float, drop_out: float, rng: np.random.Generator) -> None:
        self._latency, self._drop_out, self._rng = latency, drop_out, rng
        self._measured_at = math.nan
        self._under_way: deque[tuple[float, Reading]] = deque()
        self._arrived: Reading | None = None

    def read(self, t: float, measure: Callable[[], Reading]) -> Reading:
        """The newest reading that has arrived.

        Args:
            t: Present time [s].
            measure: Function that measures; called once for each time, so that a repeated reading is equal.
        """
        if t != self._measured_at:
            self._measured_at, reading = t, measure()
            if self._arrived is None or not (self._latency or self._drop_out):
                self._arrived = reading
                return reading
            if not self._drop_out or self._rng.random() >= self._drop_out:
                self._under_way.append((t + self._latency, reading))
            while self._under_way and self._under_way[0][0] <= t + _EARLY:
                self._arrived = self._under_way.popleft()[1]
        assert self._arrived is not None
        return self._arrived
