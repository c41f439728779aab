"""Track: one thing that is believed to exist, as a Kalman filter of its position and velocity.

It moves with a constant velocity that white accelerations disturb (Bar-Shalom, Li and Kirubarajan, Estimation with
Applications to Tracking and Navigation, 2001, 6.3.2). Whether it exists is a probability: a sighting speaks for it, a
look that should have shown it and did not against it (Mahler, Statistical Multisource-Multitarget Information Fusion,
2007, the Bernoulli filter), and while nobody looks it decays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .sighting import Array, Sighting

_SEES_POSITION = np.eye(2, 4)


@dataclass
class Track:
    """One thing.

    Attributes:
        mean: (4,) x, y [m] and their velocities [m/s], world frame.
        covariance: (4, 4) Of the mean.
        radius: How far it reaches around its position [m].
        existence: The probability that it is there.
        t: The time that all this is about [s].
        seen: When it was seen last [s].
    """

    mean: Array
    covariance: Array
    radius: float
    existence: float
    t: float
    seen: float

    @classmethod
    def begun(cls, t: float, sighting: Sighting, existence: float, speed: float) -> Track:
        """A track of what was just seen for the first time.

        Args:
            t: Now [s].
            sighting: What was seen.
            existence: The probability that it is there.
            speed: Standard deviation of either velocity [m/s].
        """
        covariance = np.diag([0.0, 0.0, speed**2, speed**2])
        covariance[:2, :2] = sighting.covariance
        mean = np.array([*sighting.position, 0.0, 0.0])
        return cls(mean, covariance, sighting.radius, existence, t, t)

    @property
    def speed(self) -> float:
        """How fast it moves [m/s]."""
        return math.hypot(self.mean[2], self.mean[3])

    def predict(self, t: float, acceleration: float, half_life: float) -> None:
        """Move on to a time; an earlier one changes nothing.

        Args:
            t: To when [s].
            acceleration: Density of the accelerations that disturb it [m2/s3].
            half_life: After how long unseen its existence is half as sure [s].
        """
        dt = t - self.t
        if dt <= 0.0:
            return
        step = np.eye(4)
        step[0, 2] = step[1, 3] = dt
        self.mean = step @ self.mean
        self.covariance = step @ self.covariance @ step.T + acceleration * _disturbance(dt)
        self.existence *= 0.5 ** (dt / half_life)
        self.t = t

    def distances(self, positions: Array, covariances: Array) -> Array:
        """(n,) Squared Mahalanobis distances of sightings; of what is truly its own 99 of 100 are below 9.21.

        Args:
            positions: (n, 2) In the world frame [m].
            covariances: (n, 2, 2) Of the positions [m2].
        """
        dx, dy = (positions - self.mean[:2]).T
        spread = covariances + self.covariance[:2, :2]
        a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
        squared: Array = (d * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * d - b * b)
        return squared

    def update(self, sighting: Sighting, detection: float, clutter: float) -> None:
        """Take a sighting as this thing's own.

        Args:
            sighting: What was seen.
            detection: How probable it was that it be seen, if it is there.
            clutter: How probable such a sighting is, if it is not.
        """
        across = self.covariance[:, :2]
        innovation = self.covariance[:2, :2] + sighting.covariance
        gain = np.linalg.solve(innovation, across.T).T
        self.mean = self.mean + gain @ (sighting.position - self.mean[:2])
        rest = np.eye(4) - gain @ _SEES_POSITION
        # Joseph's form: symmetric and positive whatever rounding does.
        self.covariance = rest @ self.covariance @ rest.T + gain @ sighting.covariance @ gain.T
        self.radius += 0.2 * (sighting.radius - self.radius)
        there = self.existence * detection
        self.existence = there / (there + (1.0 - self.existence) * clutter)
        self.seen = self.t

    def miss(self, detection: float) -> None:
        """Note that a look did not show it.

        Args:
            detection: How probable it was that it be seen, if it is there.
        """
        there = self.existence * (1.0 - detection)
        self.existence = there / (there + 1.0 - self.existence)


def _disturbance(dt: float) -> Array:
    """(4, 4) What white accelerations of density 1 m2/s3 add in a time [s]."""
    q = np.zeros((4, 4))
    for i in (0, 1):
        q[i, i], q[i, i + 2], q[i + 2, i], q[i + 2, i + 2] = dt**3 / 3.0, dt**2 / 2.0, dt**2 / 2.0, dt
    return q
