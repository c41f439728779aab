"""How fast to drive where on a path.

Source: the two-pass scheme of Lynch and Park, Modern Robotics (2017), 9.4, with limits on wheels and side force.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError
from .drive import Array, Drive
from .path import Path

CRAWL = 1e-6
"""Speed below which rounding decides how fast a profile is, and with which times are reckoned there [m/s]."""


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speeds on a path's samples, and the time it takes to drive them.

    Attributes:
        stations: (n,) Arc lengths of the samples [m].
        speeds: (n,) Speed limits there [m/s].
        times: (n,) When each is passed by a robot that drives the limits [s].
        acceleration: What the profile was made with, on a straight [m/s2].
    """

    stations: Array
    speeds: Array
    times: Array
    acceleration: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "_squared", self.speeds**2)

    _squared: Array = field(init=False, repr=False)

    def speed(self, s: float | Array) -> Array:
        """() or (k,) The limits at arc lengths s [m/s]; squares are interpolated, as constant acceleration does."""
        return np.sqrt(np.interp(s, self.stations, self._squared))

    def time(self, s: float) -> float:
        """When arc length s [m] is passed [s]."""
        return float(np.interp(s, self.stations, self.times))

    def station(self, time: float | Array) -> Array:
        """() or (k,) The arc lengths passed at times [s], held at both ends [m]."""
        return np.asarray(np.interp(time, self.times, self.stations))

    def ahead(self, s: float, speed: float, limit: float, times: Array) -> Array:
        """(k,) The arc lengths [m] at times (k,) from s on [s], never faster than the limits or than v + a t.

        Args:
            s: Arc length now [m].
            speed: v [m/s].
            limit: The limit at s [m/s].
            times: Ascending [s].
        """
        if speed >= limit:
            return self.station(self.time(s) + times)
        gained = speed + self.acceleration * times
        found: Array = s + 0.5 * (speed + gained) * times
        over = gained > self.speed(found)
        first = int(over.argmax())
        if over[first]:  # from the last moment of free acceleration on the profile's own timetable holds
            start, since = (float(found[first - 1]), float(times[first - 1])) if first else (s, 0.0)
            found[first:] = self.station(self.time(start) - since + times[first:])
        return found


def speed_profile(
    path: Path,
    drive: Drive,
    *,
    cruise: float,
    lateral_acceleration: float = 1.0,
    acceleration: float | None = None,
    start_speed: float | None = None,
    end_speed: float = 0.0,
    limit: Array | None = None,
) -> SpeedProfile:
    """The fastest speeds that keep the wheels, the side force and the cruise speed within their limits.

    Each sample allows min(cruise, v_max / (1 + |k| arm), sqrt(a_lat / |k|)), the second because the outer wheel
    runs faster than the body; then a pass each way keeps the acceleration, which a curve divides by the same term.

    Args:
        path: Where to drive.
        drive: Whose wheel limits count.
        cruise: The speed wanted on a straight [m/s].
        lateral_acceleration: Side force a unit of mass in curves [m/s2].
        acceleration: Along the path [m/s2]; None takes the wheels' own.
        start_speed: At the beginning [m/s]; None sets no limit, which suits a robot that may enter anywhere.
        end_speed: At the end [m/s].
        limit: (n,) What else limits the speed at each sample, such as how near things are [m/s].

    Raises:
        InputError: A speed or an acceleration is out of range.
    """
    along = drive.max_wheel_acceleration if acceleration is None else acceleration
    for name, value in (("cruise", cruise), ("lateral_acceleration", lateral_acceleration), ("acceleration", along)):
        if not (0.0 < value < np.inf):
            raise InputError(f"{name} of a speed profile must be a positive number, found {value}.")
    for name, end in (("start_speed", start_speed), ("end_speed", end_speed)):
        if end is not None and not (0.0 <= end < np.inf):
            raise InputError(f"{name} of a speed profile must be 0 or more, found {end}.")
    stations = np.arange(len(path.samples), dtype=float) * path.spacing
    bend = np.abs(path.samples[:, 3])
    wheels = 1.0 + bend * drive.arm
    squared = np.minimum(min(cruise, drive.speed_limit), drive.speed_limit / wheels) ** 2
    squared = np.minimum(squared, lateral_acceleration / np.maximum(bend, 1e-9))
    if limit is not None:
        squared = np.minimum(squared, limit**2)
    if start_speed is not None:
        squared[0] = min(squared[0], start_speed**2)
    squared[-1] = min(squared[-1], end_speed**2)
    speeds = np.sqrt(_two_passes(squared, along / wheels, path.spacing))
    return SpeedProfile(stations, speeds, _times(speeds, path.spacing), along)


def _two_passes(squared: Array, acceleration: Array, spacing: float) -> Array:
    """Squared speeds [m2/s2] cut to what the acceleration [m2/s] allows forward and backward."""
    # v_i^2 <= v_j^2 + 2 a |s_i - s_j| for all j is a running minimum once the ramp G is taken off.
    gained = np.minimum(acceleration[1:], acceleration[:-1]) * (2.0 * spacing)
    ramp = np.concatenate([[0.0], np.cumsum(gained)])
    forward = ramp + np.minimum.accumulate(squared - ramp)
    backward = np.minimum.accumulate((forward + ramp)[::-1])[::-1] - ramp
    return np.asarray(np.maximum(backward, 0.0))


def _times(speeds: Array, spacing: float) -> Array:
    """(n,) Passing times [s]; exact for constant acceleration between samples, finite where speeds are zero."""
    if spacing == 0.0:
        return np.zeros_like(speeds)
    means = np.maximum(0.5 * (speeds[1:] + speeds[:-1]), CRAWL)
    return np.concatenate([[0.0], np.cumsum(spacing / means)])
