"""Readings of robot sensors and gyros from poses, the same in every backend."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from ..geometry import Pose2, wrap_angle
from .parameters import GyroParameters, RobotSensorParameters

_NOBODY = (0.0, math.inf, 0.0)


class RobotSensorModel:
    """Turns poses into readings: who is in view and not hidden, with noise, the nearest first.

    Args:
        parameters: The sensor's.
        rng: Where its noise comes from.
    """

    def __init__(self, parameters: RobotSensorParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        self._drawn_at = math.nan
        self._errors: list[list[float]] = []

    def read(self, stamp: float, pose: Pose2, peers: Mapping[int, Pose2], seen: Callable[[int], bool]) -> list[float]:
        """One reading.

        Args:
            stamp: When [s]; the noise is drawn once for each instant, and for everybody, so that a second look says
                the same, and one robot's coming into view changes nothing in what is said of another.
            pose: Of the robot that looks, world frame.
            peers: Where the others are, world frame, by tag.
            seen: Whether nothing hides the robot with a tag; asked only of those in view.

        Returns:
            (3 * slots,) Tag, range [m], bearing [rad] of each slot.
        """
        given = self._parameters
        if stamp != self._drawn_at:
            self._drawn_at, self._errors = stamp, self._rng.standard_normal((len(peers), 2)).tolist()
        found = []
        for (tag, peer), (far, aside) in zip(peers.items(), self._errors, strict=True):
            distance, bearing = pose.distance(peer), pose.bearing(peer)
            if distance <= given.reach and abs(bearing) <= given.half_angle and seen(tag):
                bearing = wrap_angle(bearing + given.bearing_noise * aside)
                found.append((float(tag), max(0.0, distance + given.range_noise * far), bearing))
        found.sort(key=lambda sighting: sighting[1])
        slots = (found + [_NOBODY] * given.slots)[: given.slots]
        return [value for slot in slots for value in slot]


class GyroModel:
    """Turns headings into readings of a gyro: the mean turn rate since the reading before, with its bias.

    The mean, not the rate at an instant: such a device samples itself a thousand times a second and adds up, so what
    a robot shakes between two readings is in it.

    Args:
        parameters: The gyro's.
        rng: Where its bias comes from.
    """

    def __init__(self, parameters: GyroParameters, rng: np.random.Generator) -> None:
        self._bias = parameters.bias * float(rng.normal())
        self._stamp = math.nan
        self._yaw = math.nan
        self._told = 0.0

    def read(self, stamp: float, yaw: float) -> float:
        """One reading [rad/s]; a second look at the same instant says the same.

        Args:
            stamp: When [s].
            yaw: Where the robot heads [rad]; less than half a turn from the reading before.
        """
        if stamp != self._stamp:
            passed = stamp - self._stamp
            rate = wrap_angle(yaw - self._yaw) / passed if passed > 0.0 else 0.0  # nothing came before the first
            self._stamp, self._yaw = stamp, yaw
            self._told = rate + self._bias
        return self._told
