"""Segments of a scan: runs of neighbouring echoes that may be objects, and circles through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..locomotion import Array
from .beams import Scan

MAX_GAP, GAP_PER_METRE = 0.12, 0.02
"""Maximum gap between neighbouring echoes of one object [m], and its growth with the range, besides the spacing."""

SMALLEST = 0.2
"""Width of the smallest object that is tracked at any range [m]; three beams on it make a segment, fewer if wide."""

HIDDEN = 0.1
"""Distance by which a neighbouring echo must be nearer for the end of a segment to count as hidden [m]."""

MIN_RADIUS, MAX_RADIUS = 0.05, 0.45
"""Limits of the radius of an object [m]."""

USUAL_RADIUS = 0.25
"""Radius of an object of which a part is hidden, until it has been seen whole; that of a person [m]."""

NEAR_SIDE = 0.785
"""Mean distance of the echoes of a round object from its centre along the line of sight, in radii: pi / 4."""

BLUR = 2.0
"""Factor of the noise of a range: objects are not exactly round."""

FLOOR = 0.012
"""Standard deviation of a fitted centre that no number of echoes can reduce [m]."""

HIDDEN_SPREAD = 0.15
"""Standard deviation across the line of sight of the centre of an object, guessed from its visible part [m]."""

ROUND = 0.5 / MAX_RADIUS
"""Curvature term of the largest round object [1/m]; of a part with a hidden end, less is taken for a piece of wall."""

STEPS = 4
"""Number of Gauss-Newton steps of a circle fit."""


@dataclass(frozen=True, eq=False)
class Segments:
    """The s segments of a scan that may be objects.

    Attributes:
        scan: The scan.
        beams: Indices of the echoes, segment by segment, shape (e,).
        starts: First position of each segment in `beams`, shape (s,).
        counts: Number of echoes of each segment, shape (s,).
        radius: Apparent radius; at least the usual one if an end is hidden, shape (s,) [m].
        hidden: Number of ends that are hidden or at the edge of the field of view, shape (s,).
        round: Whether the echoes are certainly curved like the near side of an object, shape (s,).
        look: Unit vector of the line of sight, shape (s, 2).
        centre: First guess of the centre, shape (s, 2) [m].
    """

    scan: Scan
    beams: npt.NDArray[np.intp]
    starts: npt.NDArray[np.intp]
    counts: npt.NDArray[np.intp]
    radius: Array
    hidden: npt.NDArray[np.intp]
    round: npt.NDArray[np.bool_]
    look: Array
    centre: Array

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def owner(self) -> npt.NDArray[np.intp]:
        """Segment of each entry of `beams`, shape (e,)."""
        return np.repeat(np.arange(len(self)), self.counts)

    def taken(self, chosen: npt.NDArray[np.bool_]) -> Segments:
        """The segments that a mask chooses."""
        counts = self.counts[chosen]
        return Segments(
            scan=self.scan,
            beams=self.beams[np.repeat(chosen, self.counts)],
            starts=np.cumsum(counts) - counts,
            counts=counts,
            radius=self.radius[chosen],
            hidden=self.hidden[chosen],
            round=self.round[chosen],
            look=self.look[chosen],
            centre=self.centre[chosen],
        )

    def mean(self, values: Array) -> Array:
        """Mean over each segment of values of the echoes, shape (e,) -> (s,)."""
        means: Array = np.add.reduceat(values, self.starts) / self.counts
        return means

    def fitted(self, radius: Array) -> tuple[Array, Array, Array]:
        """Fit a circle of known radius to the echoes of each segment, which are on its near side.

        The fit is the maximum a posteriori estimate, by Gauss-Newton steps: echoes lie on the circle, and the centre
        lies behind the middle of the segment, less surely if an end is hidden.

        Args:
            radius: Radius for each segment, shape (s,) [m].

        Returns:
            Centres, shape (s, 2) [m], their covariances, shape (s, 2, 2) [m2], and the root mean square distances of
            the echoes from the circle, shape (s,) [m].
        """
        scan, beams, owner = self.scan, self.beams, self.owner
        x, y = scan.points[beams].T
        guess = np.stack([self.mean(x), self.mean(y)]) + self.look.T * (NEAR_SIDE * radius)
        centre, (ux, uy) = guess.copy(), (-self.look[:, 1], self.look[:, 0])  # across the line of sight
        noise = BLUR * scan.beams.noise
        prior = (noise / self._spread()) ** 2
        for _ in range(STEPS):
            dx, dy = x - centre[0][owner], y - centre[1][owner]
            rho = np.maximum(np.hypot(dx, dy), 1e-6)
            dx, dy, error = dx / rho, dy / rho, rho - radius[owner]
            sums = np.add.reduceat(np.stack([dx * dx, dx * dy, dy * dy, dx * error, dy * error]), self.starts, axis=1)
            off = prior * (ux * (guess[0] - centre[0]) + uy * (guess[1] - centre[1]))
            a, b, c = sums[0] + prior * ux * ux + 1e-3, sums[1] + prior * ux * uy, sums[2] + prior * uy * uy + 1e-3
            gx, gy, det = sums[3] + off * ux, sums[4] + off * uy, a * c - b * b
            centre += np.stack([c * gx - b * gy, a * gy - b * gx]) / det
        covariance = np.stack([c, -b, -b, a]).T.reshape(-1, 2, 2) * (noise**2 / det)[:, None, None]
        return centre.T, covariance + FLOOR**2 * np.eye(2), np.sqrt(self.mean(error * error))

    def _spread(self) -> Array:
        """Standard deviation of the guessed centres across the line of sight, shape (s,) [m]."""
        beams = self.scan.beams
        aside = self.mean(self.scan.ranges[self.beams]) * max(beams.half_angle, 0.5 * beams.spacing)
        spread: Array = np.where(self.hidden > 0, HIDDEN_SPREAD, 0.0) + aside / np.sqrt(3.0 * self.counts) + FLOOR
        return spread


def segments_of(scan: Scan, max_object_size: float) -> Segments:
    """Find the segments of a scan; those wider than an object are walls and left out.

    Args:
        scan: The scan.
        max_object_size: Maximum extent of an object [m].
    """
    beams, count = scan.beams, len(scan.ranges)
    near = np.minimum(scan.ranges, np.roll(scan.ranges, 1))
    gap = np.hypot(*(scan.points - np.roll(scan.points, 1, axis=0)).T)
    with np.errstate(invalid="ignore"):
        cut = ~(gap <= MAX_GAP + (GAP_PER_METRE + beams.spacing) * near)  # true for NaN
    cut |= ~scan.heard | ~np.roll(scan.heard, 1)
    if not beams.ring or not cut.any():
        cut[0] = True
    first = np.flatnonzero(cut)
    last = np.append(first[1:], first[0] + count)  # one past; beyond `count` around the end of a ring
    heard = scan.heard[first]
    first, last = first[heard], last[heard]
    end = (last - 1) % count
    width = np.hypot(*(scan.points[end] - scan.points[first]).T)
    fewest = np.clip(SMALLEST / (beams.spacing * np.maximum(scan.ranges[first], 0.1)), 1.0, 3.0)
    kept = (width <= max_object_size) & (last - first >= np.floor(fewest))
    return _described(scan, first[kept], last[kept], width[kept])


def _described(scan: Scan, first: npt.NDArray[np.intp], last: npt.NDArray[np.intp], width: Array) -> Segments:
    count, counts = len(scan.ranges), last - first
    starts = np.cumsum(counts) - counts
    beams = (np.arange(counts.sum()) + np.repeat(first - starts, counts)) % count
    before, after, end = (first - 1) % count, last % count, (last - 1) % count
    hidden = _hides(scan, before, first).astype(np.intp) + _hides(scan, after, end)
    if not scan.beams.ring:
        hidden += (first == 0).astype(np.intp) + (last == count)
    missed = np.where(counts > 1, scan.beams.spacing * scan.ranges[first], 0.0)  # half a spacing on either side
    radius = np.clip(0.5 * (width + missed), MIN_RADIUS, MAX_RADIUS)
    radius = np.where(hidden > 0, np.maximum(radius, USUAL_RADIUS), radius)
    middle = np.add.reduceat(scan.points[beams], starts) / counts[:, None] if len(counts) else np.zeros((0, 2))
    look = middle - scan.eyes[(first + counts // 2) % count]
    look = look / np.maximum(np.hypot(*look.T), 1e-6)[:, None]
    centre = middle + look * (NEAR_SIDE * radius)[:, None]
    term, deviation = _curvature(scan.points[beams] - np.repeat(middle, counts, axis=0), starts, counts, look)
    noise = scan.beams.noise
    bent = term - deviation * noise > ROUND
    found = Segments(scan, beams, starts, counts, radius, hidden, bent, look, centre)
    return found.taken((hidden == 0) | (term + deviation * noise > ROUND))


def _curvature(
    offset: Array, starts: npt.NDArray[np.intp], counts: npt.NDArray[np.intp], look: Array
) -> tuple[Array, Array]:
    """Quadratic term c of the parabola v = a + b u + c u2 through each segment, and its deviation for noise of 1 m.

    Here u is the offset of an echo from the middle of its segment across the line of sight, and v along it [m].
    """
    if not len(counts):
        return np.zeros(0), np.zeros(0)
    c, s = np.repeat(look, counts, axis=0).T
    u, v = c * offset[:, 1] - s * offset[:, 0], c * offset[:, 0] + s * offset[:, 1]
    square = u * u
    moments = np.stack([square, square * u, square * square, u * v, square * v])
    m2, m3, m4, uv, uuv = np.add.reduceat(moments, starts, axis=1) / counts
    lean = m3 / np.maximum(m2, 1e-9)
    variance = np.maximum(m4 - m2 * m2 - m3 * lean, 1e-12)  # of u2, less what a slope explains
    return (uuv - lean * uv) / variance, 1.0 / np.sqrt(counts * variance)


def _hides(scan: Scan, beside: npt.NDArray[np.intp], end: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Whether the echo beside the end of a segment hides what comes next: it is nearer, or not valid."""
    hides: npt.NDArray[np.bool_] = ~(scan.ranges[beside] >= scan.ranges[end] - HIDDEN)
    return hides
