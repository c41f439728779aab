"""Speed profile along a path.

Source: the two-pass scheme of Lynch and Park, Modern Robotics (2017), 9.4, with limits on the motion command and the
lateral acceleration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Twist2
from .locomotion import Array, Locomotion
from .path import Path

TINY = 1e-9  # below this, a divisor is replaced
BRAKES = 0.3  # minimum share of the acceleration limits for braking along the path in a curve

CRAWL = 1e-6
"""Minimum speed in the computation of passing times [m/s]; lower speeds of a profile are rounding errors."""


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speed profile: the speed limit at each sample of a path, and the passing times at these speeds.

    Attributes:
        stations: Arc lengths of the samples, shape (n,) [m].
        speeds: Speed limits at the samples, shape (n,) [m/s].
        times: Passing times at the speed limits, shape (n,) [s].
        acceleration: Acceleration limit of the profile on a straight [m/s2].
    """

    stations: Array
    speeds: Array
    times: Array
    acceleration: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "_squared", self.speeds**2)

    _squared: Array = field(init=False, repr=False)

    def speed(self, s: float | Array) -> Array:
        """Speed limits at arc lengths s [m], shape () or (k,) [m/s]; the squared speed is interpolated linearly."""
        return np.sqrt(np.interp(s, self.stations, self._squared))

    def time(self, s: float) -> float:
        """Passing time of the arc length s [m] at the speed limits [s]."""
        return float(np.interp(s, self.stations, self.times))

    def station(self, time: float | Array) -> Array:
        """Arc lengths passed at times [s], constant beyond both ends, shape () or (k,) [m]."""
        return np.asarray(np.interp(time, self.times, self.stations))

    def ahead(self, s: float, speed: float, limit: float, times: Array) -> Array:
        """Predict the arc lengths of a robot on the path that accelerates as fast as the profile allows.

        Args:
            s: Present arc length [m].
            speed: Present speed v [m/s].
            limit: Speed limit at s [m/s].
            times: Times from now on, ascending, shape (k,) [s].

        Returns:
            Arc lengths, shape (k,) [m]; the speed never exceeds the limits or v + a t.
        """
        if speed >= limit:
            return self.station(self.time(s) + times)
        gained = speed + self.acceleration * times
        found: Array = s + 0.5 * (speed + gained) * times
        over = gained > self.speed(found)
        first = int(over.argmax())
        if over[first]:  # from where the profile limits the speed, its own passing times apply
            start, since = (float(found[first - 1]), float(times[first - 1])) if first else (s, 0.0)
            found[first:] = self.station(self.time(start) - since + times[first:])
        return found


def speed_profile(
    path: Path,
    locomotion: Locomotion,
    *,
    cruise: float,
    lateral_acceleration: float = 1.0,
    end_speed: float = 0.0,
    limit: Array | None = None,
    yaws: Array | None = None,
    turn_rate: float = math.inf,
) -> SpeedProfile:
    """Fastest profile within the limits of the locomotion, of lateral acceleration and of cruise speed.

    Each sample allows min(cruise, v_max / f, sqrt(a_lat / |k|)) at curvature k. On wheels f is 1 + |k| arm, with half
    the wheel separation as arm: it keeps the outer wheel, which is faster than the body, within its limit. A forward
    and a backward pass then limit the acceleration. In a curve, the limit of the acceleration is also divided by f.

    With `yaws`, the command per speed on the path is that of the twist (cos d, sin d, dyaw/ds), for the angle d from
    the yaw to the path. Each value of the command limits the speed, and its change along the path the acceleration.

    Args:
        path: Path to drive.
        locomotion: Locomotion with its limits.
        cruise: Speed on straight parts [m/s].
        lateral_acceleration: Maximum lateral acceleration in curves [m/s2].
        end_speed: Speed limit at the end [m/s].
        limit: Additional speed limits at each sample, for example from clearance, shape (n,) [m/s].
        yaws: Yaw at each sample, without jumps of 2 pi, shape (n,) [rad]; None for the tangent.
        turn_rate: Maximum turn rate along the path with `yaws` [rad/s].

    Raises:
        InputError: A speed or the lateral acceleration is out of range.
    """
    along = locomotion.acceleration_limit
    for name, value in (("cruise", cruise), ("lateral_acceleration", lateral_acceleration)):
        if not (0.0 < value < np.inf):
            raise InputError(f"{name} of a speed profile must be a positive number, found {value}.")
    if not (0.0 <= end_speed < np.inf):
        raise InputError(f"end_speed of a speed profile must be 0 or more, found {end_speed}.")
    stations = np.arange(len(path.samples), dtype=float) * path.spacing
    bend = np.abs(path.samples[:, 3])
    if yaws is None:
        factor, more = locomotion.curve_factors(bend)
        squared = np.minimum(min(cruise, locomotion.speed_limit), locomotion.speed_limit / factor) ** 2
        accelerations = along / more
    else:
        squared, accelerations = _with_yaws(path, locomotion, yaws, cruise, turn_rate, along)
    squared = np.minimum(squared, lateral_acceleration / np.maximum(bend, 1e-9))
    if limit is not None:
        squared = np.minimum(squared, limit**2)
    squared[-1] = min(squared[-1], end_speed**2)
    speeds = np.sqrt(_two_passes(squared, accelerations, path.spacing))
    return SpeedProfile(stations, speeds, _times(speeds, path.spacing), along)


def _with_yaws(
    path: Path, locomotion: Locomotion, yaws: Array, cruise: float, turn_rate: float, along: float
) -> tuple[Array, Array]:
    """Limits of squared speeds [m2/s2] and of accelerations [m/s2] at the samples of a path with yaws, shape (n,)."""
    spacing = path.spacing or 1.0
    off, turns = path.samples[:, 2] - yaws, np.gradient(yaws, spacing)
    forward, left, turn = (locomotion.command(Twist2(f, turn=t, left=side)) for f, side, t in np.eye(3).tolist())
    # Values of the motion command per speed on the path, and their changes per metre, shape (n, m).
    shares = np.outer(np.cos(off), forward) + np.outer(np.sin(off), left) + np.outer(turns, turn)
    changes = np.maximum(np.abs(np.gradient(shares, spacing, axis=0)), TINY)
    shares = np.maximum(np.abs(shares), TINY)
    speeds = np.minimum((locomotion.max_speed / shares).min(axis=1), turn_rate / np.maximum(np.abs(turns), TINY))
    accelerations = locomotion.max_acceleration
    squared = np.minimum(np.minimum(cruise, speeds) ** 2, (accelerations / changes).min(axis=1))
    left_over = np.maximum(accelerations - squared[:, None] * changes, BRAKES * accelerations)
    return squared, np.minimum(along, (left_over / shares).min(axis=1))


def _two_passes(squared: Array, acceleration: Array, spacing: float) -> Array:
    """Limit squared speeds [m2/s2] by the acceleration [m/s2], in a forward and a backward pass along the path."""
    # v_i^2 <= v_j^2 + 2 a |s_i - s_j| for all j is a running minimum after subtracting the ramp.
    gained = np.minimum(acceleration[1:], acceleration[:-1]) * (2.0 * spacing)
    ramp = np.concatenate([[0.0], np.cumsum(gained)])
    forward = ramp + np.minimum.accumulate(squared - ramp)
    backward = np.minimum.accumulate((forward + ramp)[::-1])[::-1] - ramp
    return np.asarray(np.maximum(backward, 0.0))


def _times(speeds: Array, spacing: float) -> Array:
    """Passing times, shape (n,) [s]; exact for constant acceleration between samples, finite at zero speed."""
    if spacing == 0.0:
        return np.zeros_like(speeds)
    means = np.maximum(0.5 * (speeds[1:] + speeds[:-1]), CRAWL)
    return np.concatenate([[0.0], np.cumsum(spacing / means)])
