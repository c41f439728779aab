"""Sensor models that all simulated backends share: errors of poses, delivery of readings, robot sensors, gyros ..."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping

import numpy as np

from ..base.geometry import Pose2, Twist3, wrap_angle
from ..interfaces.device import Reading
from .parameters import (
    BatteryParameters,
    GyroParameters,
    OrientationParameters,
    PositionParameters,
    RobotSensorParameters,
    TwistParameters,
)

_EMPTY_SLOT = (0.0, math.inf, 0.0)
_EARLY = 1e-9  # [s] by which a sum of times may be too large
_MOVING = 0.02  # [m/s], [rad/s]


class RobotSensorModel:
    """Sensor model of a robot sensor: computes noisy readings of the visible robots from true poses, nearest first."""

    def __init__(self, parameters: RobotSensorParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        self._sampled_at = math.nan
        self._errors: list[list[float]] = []

    def read(self, stamp: float, pose: Pose2, peers: Mapping[int, Pose2], seen: Callable[[int], bool]) -> list[float]:
        """Compute the values of a reading.

        Args:
            stamp: Time of the reading [s]. Noise is sampled once per time and for all peers, so that a repeated reading
                is equal, and the noise of one robot does not depend on the visibility of another.
            pose: Pose of the robot with the sensor, world frame.
            peers: Poses of the other robots, world frame, by tag.
            seen: Function from a robot's tag to whether the line of sight to it is free; called only for robots in the
                field of view.

        Returns:
            Tag, range [m] and bearing [rad] of each slot, shape (3 * max_peers,).
        """
        given = self._parameters
        if stamp != self._sampled_at:
            self._sampled_at, self._errors = stamp, self._rng.standard_normal((len(peers), 2)).tolist()
        found = []
        for (tag, peer), (range_error, bearing_error) in zip(peers.items(), self._errors, strict=True):
            distance, bearing = pose.distance(peer), pose.bearing(peer)
            if distance <= given.max_range and abs(bearing) <= given.half_angle and seen(tag):
                bearing = wrap_angle(bearing + given.bearing_noise * bearing_error)
                found.append((float(tag), max(0.0, distance + given.range_noise * range_error), bearing))
        found.sort(key=lambda sighting: sighting[1])
        slots = (found + [_EMPTY_SLOT] * given.max_peers)[: given.max_peers]
        return [value for slot in slots for value in slot]


class PoseError:
    """Error of a pose sensor beside its noise: a random walk, and an error that is sampled again at random times."""

    def __init__(self, parameters: PositionParameters | OrientationParameters, size: int, rng: np.random.Generator):
        self._parameters, self._rng = parameters, rng
        self._walk, self._jump = np.zeros(size), np.zeros(size)
        self._stamp = math.nan

    def at(self, stamp: float) -> list[float]:
        """Errors at a time [s], shape (size,), in the unit of the parameters; the first one is 0."""
        given, passed = self._parameters, stamp - self._stamp
        if passed > 0.0:
            if given.drift:
                self._walk += given.drift * math.sqrt(passed) * self._rng.standard_normal(self._walk.size)
            if given.jump and self._rng.random() < -math.expm1(-passed / given.jump_every):
                self._jump = given.jump * self._rng.standard_normal(self._jump.size)
        self._stamp = stamp
        errors: list[float] = (self._walk + self._jump).tolist()
        return errors


class Delivery:
    """Delivery of readings from a simulated device to the robot: some are lost, the others arrive after a latency.

    The first reading arrives at once, because the robot was there before the start.

    Args:
        latency: Time from the end of a measurement until its reading can be read [s].
        drop_out: Probability that a whole reading is lost.
        rng: Random generator of the losses.
    """

    def __init__(self, latency: float, drop_out: float, rng: np.random.Generator) -> None:
        self._latency, self._drop_out, self._rng = latency, drop_out, rng
        self._measured_at = -math.inf
        self._under_way: deque[tuple[float, Reading]] = deque()
        self._arrived: Reading | None = None

    def deliver(self, reading: Reading, t: float) -> Reading:
        """Take a reading, and return the newest one that has arrived.

        Args:
            reading: Reading that was measured at present.
            t: Present time [s]; a second reading of the same time is ignored.
        """
        if self._arrived is None or not (self._latency or self._drop_out):
            self._arrived, self._measured_at = reading, t
            return reading
        if t > self._measured_at:
            self._measured_at = t
            if not self._drop_out or self._rng.random() >= self._drop_out:
                self._under_way.append((t + self._latency, reading))
        while self._under_way and self._under_way[0][0] <= t + _EARLY:
            self._arrived = self._under_way.popleft()[1]
        return self._arrived


class BatteryModel:
    """Model of a battery: its charge, from the power between two readings.

    Args:
        parameters: Parameters of the sensor.
        stamp: Time of the start [s].
        places: Positions of the scenario's places by name, world frame.
    """

    def __init__(self, parameters: BatteryParameters, stamp: float, places: Mapping[str, Pose2]) -> None:
        self._parameters, self._stamp, self._charge = parameters, stamp, parameters.charge
        self._chargers = [places[name] for name in parameters.chargers if name in places]

    def read(self, stamp: float, pose: Pose2, twist: Twist3) -> list[float]:
        """Charge, 0 to 1. The power since the last reading is that of the present pose and motion."""
        given = self._parameters
        seconds, self._stamp = stamp - self._stamp, stamp
        power = -given.idle_power
        if max(math.hypot(twist.forward, twist.left), abs(twist.up), abs(twist.turn)) > _MOVING:
            power -= given.motion_power
        if any(pose.distance(charger) <= given.charge_distance for charger in self._chargers):
            power += given.charge_power
        self._charge = min(1.0, max(0.0, self._charge + power * seconds / given.capacity))
        return [self._charge]


class TwistModel:
    """Sensor model of a twist sensor: the true twist, with noise that is sampled once per time."""

    def __init__(self, parameters: TwistParameters, rng: np.random.Generator) -> None:
        self._scale = [*[parameters.speed_noise] * 3, parameters.turn_noise]
        self._rng = rng
        self._sampled_at = math.nan
        self._errors = [0.0] * 4

    def read(self, stamp: float, twist: Twist3) -> list[float]:
        """Compute the values of a reading: forward, left, up [m/s], turn [rad/s].

        Args:
            stamp: Time of the reading [s].
            twist: True velocity of the base.
        """
        if stamp != self._sampled_at and any(self._scale):
            self._sampled_at, self._errors = stamp, self._rng.normal(0.0, self._scale).tolist()
        return [value + error for value, error in zip(twist, self._errors, strict=True)]


class GyroModel:
    """Sensor model of a gyro: mean turn rate since the previous reading, from true headings, plus a constant bias.

    The reading is a mean and not an instantaneous rate, because a real device samples at about 1 kHz and integrates, so
    that vibrations between two readings are averaged.
    """

    def __init__(self, parameters: GyroParameters, rng: np.random.Generator) -> None:
        self._bias = parameters.bias_noise * float(rng.normal())
        self._stamp = math.nan
        self._yaw = math.nan
        self._rate = 0.0

    def read(self, stamp: float, yaw: float) -> float:
        """Compute the turn rate [rad/s]; a second call at the same time returns the same value.

        Args:
            stamp: Time of the reading [s].
            yaw: True heading of the robot [rad]; it must differ by less than pi from that of the previous reading.
        """
        if stamp != self._stamp:
            passed = stamp - self._stamp
            rate = wrap_angle(yaw - self._yaw) / passed if passed > 0.0 else 0.0  # 0 at the first reading
            self._stamp, self._yaw = stamp, yaw
            self._rate = rate + self._bias
        return self._rate
