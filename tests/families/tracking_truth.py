"""Tracking against truth: what a scanner heard in a scene with people, and where the people were."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rocs_bt._run import run
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import CachingCatalog
from rocs_bt.compare import Post, load_family
from rocs_bt.control.tracking import Beams, Tracker, segments_of
from rocs_bt.event import BodyMoved, SignalsWritten, unpack

PERIOD, MOUNT, REACH, FIELD = 0.05, 0.12, 6.0, math.radians(133.0)
BEARINGS = np.radians(np.linspace(-135.0, 135.0, 720))
RADIUS = 0.25


class _Sink:
    def __init__(self):
        self.scans, self.poses, self.rows = {}, {}, {}

    def emit(self, event):
        if isinstance(event, BodyMoved):
            self.rows.setdefault(event.body, {})[round(event.t / PERIOD)] = (event.x, event.y)
        elif isinstance(event, SignalsWritten):
            values = np.split(np.array(unpack(event.data)), np.cumsum(event.sizes)[:-1])
            for name, kept in (("scan", self.scans), ("pose", self.poses)):
                if name in event.signals:
                    kept[round(event.t / PERIOD)] = values[event.signals.index(name)]


@dataclass
class Walk:
    """Scans, poses of the robot and positions of people by control period, and where pillars are."""

    scans: dict[int, np.ndarray]
    poses: dict[int, np.ndarray]
    people: dict[str, dict[int, tuple[float, float]]]
    pillars: list[tuple[float, float, float]]


def played(family: str, index: int, planner: str = "hybrid", duration: float = 12.0, **parameters: object) -> Walk:
    """Play a scene and keep what happened."""
    catalog, sink = CachingCatalog(None, code=True), _Sink()
    scene = load_family(catalog, family, parameters).scene(index)
    scene = dataclasses.replace(scene, scenario={**scene.scenario, "duration": f"{duration} s"})
    catalog = scene.added_to(catalog)
    spec = catalog.load_planner(planner).drives(catalog.load_scenario(scene.name), "R", scene.privileged)
    run(spec, catalog, seed=1, report=False, sinks=[sink])
    pillars = [(o.x, o.y, o.radius) for o in scene.floor.obstacles if isinstance(o, Post)]
    people = {name: row for name, row in sink.rows.items() if name.startswith("P")}
    return Walk(sink.scans, sink.poses, people, pillars)


@dataclass
class Figures:
    """Errors of movers in view, and counts of those that were missed and of movers that nobody is."""

    position: list[float] = field(default_factory=list)
    velocity: list[float] = field(default_factory=list)
    latency: list[float] = field(default_factory=list)
    missed: int = 0
    false: int = 0
    out_of_view: int = 0
    scans: int = 0

    @property
    def missed_share(self) -> float:
        """Part of the people in view that were no movers."""
        return self.missed / (self.missed + len(self.position))

    def __str__(self) -> str:
        position, velocity, latency = map(np.array, (self.position, self.velocity, self.latency))
        return (
            f"position {position.mean():.3f} m (p95 {np.percentile(position, 95):.3f}), velocity "
            f"{np.median(velocity):.3f} m/s (p95 {np.percentile(velocity, 95):.2f}), latency {latency.mean():.3f} s, "
            f"missed {100 * self.missed_share:.1f} %, false a scan {self.false / self.scans:.3f} in view, "
            f"{self.out_of_view / self.scans:.3f} out of view"
        )


def measure(
    walks: Sequence[Walk], noise: float = 1.0, dropped: float = 0.0, drift: Sequence[float] = (0.0, 0.0, 0.0)
) -> Figures:
    """Figures of the tracker on what was heard.

    Args:
        walks: Scenes.
        noise: Factor of the noise of a range.
        dropped: Part of the scans that are lost.
        drift: Standard deviation of the drift of the pose in each period [m, m, rad].
    """
    figures, rng = Figures(), np.random.default_rng(1)
    beams = Beams([(MOUNT, 0.0, float(a)) for a in BEARINGS], math.radians(0.19), 8.0, noise=0.01)
    for walk in walks:
        tracker, offset, since = Tracker(), np.zeros(3), {}
        for k, scan in walk.scans.items():
            offset += rng.normal(0.0, 1.0, 3) * drift
            if rng.random() < dropped or k not in walk.poses:
                continue
            heard = scan + rng.normal(0.0, 0.01 * math.sqrt(noise**2 - 1.0), len(scan))
            pose = walk.poses[k] + offset
            tracker.update(k * PERIOD, segments_of(beams.scan(Pose2(*pose.tolist()), heard), 0.9))
            people = {n: row for n, row in walk.people.items() if {k - 1, k, k + 1} <= row.keys()}
            if people:
                _compare(figures, tracker, k, walk, people, pose, since)
    return figures


def _compare(figures, tracker, k, walk, people, pose, since):
    turn, true = pose[2] - walk.poses[k][2], walk.poses[k]
    c, s = math.cos(turn), math.sin(turn)
    to_believed = np.array([[c, s], [-s, c]])
    at = np.array([row[k] for row in people.values()])
    velocity = np.array([np.subtract(row[k + 1], row[k - 1]) / (2 * PERIOD) for row in people.values()]) @ to_believed
    shown = _shown(at, true, walk.pillars) & (np.hypot(*velocity.T) > 0.2)
    at = (at - true[:2]) @ to_believed + pose[:2]
    tracks = tracker.tracks.taken(tracker.tracks.confirmed & tracker.tracks.movers(k * PERIOD))
    seen = tracks.seen >= k * PERIOD - 1e-9
    away = np.hypot(*(tracks.mean[:, None, :2] - at).transpose(2, 0, 1))
    figures.scans += 1
    figures.false += int((away[seen].min(axis=1, initial=np.inf) > 0.6).sum())
    figures.out_of_view += int((away[~seen].min(axis=1, initial=np.inf) > 0.6).sum())
    for i, name in enumerate(people):
        if not shown[i]:
            since.pop(name, None)
            continue
        since.setdefault(name, k)
        near = np.flatnonzero(seen & (away[:, i] < 0.4))
        if not len(near):
            figures.missed += 1
            continue
        best = near[away[near, i].argmin()]
        figures.position.append(float(away[best, i]))
        figures.velocity.append(float(np.hypot(*(tracks.mean[best, 2:] - velocity[i]))))
        if since[name] is not None:
            figures.latency.append((k - since[name]) * PERIOD)
            since[name] = None


def _shown(at, pose, pillars):
    """Which people the scanner sees: in its field of view and reach, with the middle not hidden."""
    eye = pose[:2] + MOUNT * np.array([math.cos(pose[2]), math.sin(pose[2])])
    things = np.vstack([np.column_stack([at, np.full(len(at), RADIUS)]), np.reshape(pillars, (-1, 3))])
    to = things[:, :2] - eye
    away, angle = np.hypot(*to.T), np.arctan2(to[:, 1], to[:, 0])
    half = np.arcsin(np.minimum(things[:, 2] / np.maximum(away, things[:, 2] + 0.01), 1.0))
    n = len(at)
    apart = np.abs(np.mod(angle[:n, None] - angle + math.pi, math.tau) - math.pi)
    hidden = ((apart < half) & (away < away[:n, None] - 1e-9)).any(axis=1)
    ahead = np.abs(np.mod(angle[:n] - pose[2] + math.pi, math.tau) - math.pi)
    return ~hidden & (away[:n] < REACH) & (ahead < FIELD)
