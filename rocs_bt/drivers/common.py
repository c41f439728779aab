"""Models of robot sensors and gyros, common to all backends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from ..geometry import Pose2, wrap_angle
from .parameters import GyroParameters, RobotSensorParameters

_EMPTY_SLOT = (0.0, math.inf, 0.0)


class RobotSensorModel:
    """Model of a robot sensor: readings of the visible robots from true poses, with noise, nearest first.

    Args:
        parameters: Parameters of the sensor.
        rng: Random stream of the noise.
    """

    def __init__(self, parameters: RobotSensorParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        self._sampled_at = math.nan
        self._errors: list[list[float]] = []

    def read(self, stamp: float, pose: Pose2, peers: Mapping[int, Pose2], seen: Callable[[int], bool]) -> list[float]:
        """Values of a reading.

        Args:
            stamp: Time [s]. Noise is sampled once per time and for all peers: a repeated reading is equal, and the
                noise of one robot does not depend on the visibility of another.
            pose: Pose of the robot with the sensor, world frame.
            peers: Poses of the other robots, world frame, by tag.
            seen: Whether the line of sight to the robot with a tag is free; called only for robots in the field of
                view.

        Returns:
            Tag, range [m] and bearing [rad] of each slot, shape (3 * slots,).
        """
        given = self._parameters
        if stamp != self._sampled_at:
            self._sampled_at, self._errors = stamp, self._rng.standard_normal((len(peers), 2)).tolist()
        found = []
        for (tag, peer), (range_error, bearing_error) in zip(peers.items(), self._errors, strict=True):
            distance, bearing = pose.distance(peer), pose.bearing(peer)
            if distance <= given.reach and abs(bearing) <= given.half_angle and seen(tag):
                bearing = wrap_angle(bearing + given.bearing_noise * bearing_error)
                found.append((float(tag), max(0.0, distance + given.range_noise * range_error), bearing))
        found.sort(key=lambda sighting: sighting[1])
        slots = (found + [_EMPTY_SLOT] * given.slots)[: given.slots]
        return [value for slot in slots for value in slot]


class GyroModel:
    """Simulated gyro: mean turn rate since the previous reading, computed from true headings, plus a bias.

    The reading is a mean, not an instantaneous rate: a real device samples at about 1 kHz and integrates, so vibrations
    between two readings are included.

    Args:
        parameters: Parameters of the gyro.
        rng: Random stream of the bias.
    """

    def __init__(self, parameters: GyroParameters, rng: np.random.Generator) -> None:
        self._bias = parameters.bias * float(rng.normal())
        self._stamp = math.nan
        self._yaw = math.nan
        self._rate = 0.0

    def read(self, stamp: float, yaw: float) -> float:
        """Turn rate [rad/s]; a second call at the same time returns the same value.

        Args:
            stamp: Time [s].
            yaw: True heading of the robot [rad]; must differ by less than pi from the previous reading.
        """
        if stamp != self._stamp:
            passed = stamp - self._stamp
            rate = wrap_angle(yaw - self._yaw) / passed if passed > 0.0 else 0.0  # 0 at the first reading
            self._stamp, self._yaw = stamp, yaw
            self._rate = rate + self._bias
        return self._rate
