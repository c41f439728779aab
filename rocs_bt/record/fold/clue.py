"""Clues to the firing of a rule: a sensor that is silent or at its limit, and the object that is nearest."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Collection, Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...event import GuardInfo
from ..file.header import AgentInfo, Outline, Point, RunHeader
from .track import Curve, TrackSet

Numbers = NDArray[np.float64]

_SECTORS = {"front": 0.0, "left_gap": math.pi / 2.0, "rear": math.pi, "right_gap": -math.pi / 2.0}  # [rad]
_HALF = math.radians(65.0)  # half of a sector: neighbours overlap
_FINE = 0.02  # [m] between the points of an outline
_FAR = 2.0  # [m] distance up to which an object is looked for
_AGAIN = 1.0  # [s] between the clues to an event that is repeated: they cost more than the event
SAME = 5e-4
"""Difference from a limit up to which a value is that limit [m]; values of the page are rounded."""


class Clues:
    """Finds the clues of one run."""

    def __init__(self, header: RunHeader, tracks: TrackSet) -> None:
        self._header, self._tracks = header, tracks
        self._told: dict[tuple[str, str], float] = {}
        self._valid: dict[tuple[str, str], tuple[int, int]] = {}
        self._agents = {agent.name: agent for agent in header.agents}
        self._bodies = {body.name: body for body in header.bodies}
        self._guards = {(a.name, guard.rule): (guard, _read(guard, a)) for a in header.agents for guard in a.guards}

    def replace(self, agent: str, guard: GuardInfo) -> None:
        """Take the new guard of a rule, from now on."""
        self._guards[agent, guard.rule] = guard, _read(guard, self._agents[agent])

    def due(self, agent: str, source: str, t: float) -> bool:
        """Whether a clue to a repeated event of a rule or leaf is due: the last one is a second old."""
        if t < self._told.get((agent, source), -math.inf) + _AGAIN:
            return False
        self._told[agent, source] = t
        return True

    def of(self, agent: str, rule: str, t: float) -> str:
        """Clues to the guard of a rule at a time, in words; empty if there are none."""
        guard, read = self._guards.get((agent, rule), (None, ()))
        if guard is None:
            return ""
        values = {name: value for name in read if (value := self._tracks.curve(agent, "signal", name).at(t))}
        invalid = [name for name, value in values.items() if any(map(math.isnan, value))]
        first = "could not be evaluated" if invalid else "held"
        lasts = [f"{guard.hold:.3g} s after its guard first {first}: for = {guard.hold:.3g} s"] if guard.hold else []
        lasts += self._scripted(self._agents[agent], values, t)
        if invalid:
            return "; ".join([*lasts, *self._silent(self._agents[agent], invalid, t)])
        units = {signal.name: signal.units for signal in self._agents[agent].signals}
        least = min((min(value) for name, value in values.items() if {*units[name]} == {"m"}), default=math.nan)
        limits = filter(None, [limit_text(guard, least)])
        nearest = self.nearest(agent, t, [_SECTORS[name] for name in values if name in _SECTORS])
        return "; ".join([*lasts, *limits, *([nearest] if nearest else [])])

    def _scripted(self, agent: AgentInfo, names: Collection[str], t: float) -> Iterator[str]:
        """Sensors of signals that the script of the run breaks at a time."""
        for sensor in agent.sensors:
            event = self._tracks.steps(agent.name, "script", f"sensor\n{sensor.name}").at(t)
            reads = not {*sensor.signals, *sensor.derived}.isdisjoint(names)
            if reads and event is not None and (event.until is None or t < event.until):
                yield f"{event.sentence} since t = {event.t:.2f} s"

    def _silent(self, agent: AgentInfo, invalid: list[str], t: float) -> Iterator[str]:
        """Sensors without which signals are invalid, and since when; those that have failed if that is known."""
        named = set[str]()
        for name in invalid:
            sensors = {s.name for s in agent.sensors if name in s.signals or name in s.derived}
            broken = [(each, at) for each in sorted(sensors) if (at := self._failed(agent.name, each)) is not None]
            if named.isdisjoint(sensors):
                what = " or ".join(f"'{each}'" for each in sorted(sensors))
                other = (
                    f"no valid value of {what and 'the sensor '}{what or repr(name)}{self._since(agent.name, name, t)}"
                )
                yield from (failed_text(*each) for each in broken) if broken else (other,)
            named |= sensors or {name}

    def _failed(self, agent: str, sensor: str) -> float | None:
        """Time of the last failure of a sensor [s]; None if it has not failed."""
        track = self._tracks.steps(agent, "sensor", sensor)
        return next((t for t, detail in zip(reversed(track.t), reversed(track.v), strict=True) if detail), None)

    def _since(self, agent: str, name: str, t: float) -> str:
        """Time of the last valid value, in words; a sample that was found invalid is not looked at again."""
        curve = self._tracks.curve(agent, "signal", name)
        seen, last = self._valid.get((agent, name), (0, -1))
        end = bisect_right(curve.t, t)
        last = next((i for i in reversed(range(seen, end)) if not _nan(curve, i)), last)
        self._valid[agent, name] = (end, last)
        return " so far" if last < 0 else f" since t = {curve.t[last]:.2f} s"

    def nearest(self, agent: str, t: float, sectors: Collection[float] = tuple(_SECTORS.values())) -> str:
        """Nearest object in the recorded world at a time, in words; empty if none is near or the world is not known.

        Args:
            agent: Name of the agent.
            t: Time [s].
            sectors: Directions in which it may be, body frame [rad]; all by default.
        """
        pose, body = self._pose(agent, t), self._bodies.get(agent)
        if not self._header.simulated or not sectors or pose is None or body is None or len(body.hull) < 3:
            return ""
        owners, points = [self._still[0]], [self._still[1]]
        for name, (index, hull, size) in self._hulls.items():
            there = self._pose(name, t) if name != agent else None
            if there is not None and math.hypot(*(there - pose)[:2]) < _FAR + size:
                owners.append(np.full(len(hull), index))
                points.append(_placed(hull, there))
        rows, owner = _seen(np.concatenate(points), pose), np.concatenate(owners)
        away, bearing = np.hypot(*rows.T), np.arctan2(rows[:, 1], rows[:, 0])
        inside = np.any([np.cos(bearing - sector) >= math.cos(_HALF) for sector in sectors], axis=0) & (away < _FAR)
        if not inside.any():
            return ""
        inside &= away <= away[inside].min() + self._hulls[agent][2]  # others cannot be nearer to the hull
        distances = _distances(rows[inside], body.hull)
        name = self._names[owner[inside][distances.argmin()]]
        return f"in the recorded world '{name}' is nearest, {distances.min():.2f} m away"

    @cached_property
    def _names(self) -> list[str]:
        """Names of all objects: of what never moves, then of the bodies."""
        return [*(outline.name for outline in self._header.outlines), *self._bodies]

    @cached_property
    def _still(self) -> tuple[NDArray[np.int64], Numbers]:
        """Points of everything that never moves: index of the name, and position."""
        rows = [_points(outline) for outline in self._header.outlines]
        owners = np.repeat(np.arange(len(rows)), [len(part) for part in rows])
        return owners, np.concatenate([np.empty((0, 2)), *rows])

    @cached_property
    def _hulls(self) -> dict[str, tuple[int, Numbers, float]]:
        """Bodies: index of the name, points of the outline in its own frame, and its size [m]."""
        rows = {name: _points(Outline(name=name, points=b.hull)) for name, b in self._bodies.items() if b.hull}
        return {name: (self._names.index(name), at, float(np.hypot(*at.T).max())) for name, at in rows.items()}

    def _pose(self, body: str, t: float) -> Numbers | None:
        found = self._tracks.curve(body, "pose").last(t)
        return None if found is None else np.array(found[1][:3])


def limit_text(guard: GuardInfo, value: float) -> str:
    """Sentence about a value that is a limit of a sensor that the guard reads; empty if it is none."""
    return next((text for limit, text in guard.limits if abs(value - limit) < SAME), "")


def failed_text(sensor: str, t: float) -> str:
    """Sentence about a sensor that failed at a time [s]."""
    return f"the sensor '{sensor}' failed at t = {t:.2f} s"


def _read(guard: GuardInfo, agent: AgentInfo) -> list[str]:
    """Signals that the condition of a guard reads."""
    words = set(re.findall(r"\w+", " ".join(guard.sources[:1])))
    return [signal.name for signal in agent.signals if signal.name in words]


def _nan(curve: Curve, i: int) -> bool:
    return any(map(math.isnan, curve.data[i * curve.width : (i + 1) * curve.width]))


def _points(outline: Outline) -> Numbers:
    """Points along an outline, shape (n, 2)."""
    if outline.radius > 0.0:
        angles = np.arange(0.0, 2.0 * np.pi, _FINE / max(outline.radius, _FINE))
        circle: Numbers = outline.points[0] + outline.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return circle
    corners = np.array(outline.points)
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([np.linspace(a, b, 1 + math.ceil(math.dist(a, b) / _FINE), endpoint=False) for a, b in sides])


def _placed(points: Numbers, pose: Numbers) -> Numbers:
    """Points of a body in the world frame."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    rows: Numbers = points @ np.array([[c, s], [-s, c]]) + pose[:2]
    return rows


def _seen(points: Numbers, pose: Numbers) -> Numbers:
    """Points of the world in the frame of a body."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    rows: Numbers = (points - pose[:2]) @ np.array([[c, -s], [s, c]])
    return rows


def _distances(points: Numbers, hull: tuple[Point, ...]) -> Numbers:
    """Distances of points from a convex outline [m]; 0 inside."""
    corners = np.array(hull)
    a, edge = corners, np.roll(corners, -1, axis=0) - corners
    offset = points[:, None, :] - a
    part = np.clip((offset * edge).sum(axis=2) / np.maximum((edge**2).sum(axis=1), 1e-12), 0.0, 1.0)
    away = np.linalg.norm(offset - part[..., None] * edge, axis=2).min(axis=1)
    side = edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0]
    inside = (side >= 0.0).all(axis=1) | (side <= 0.0).all(axis=1)
    return np.where(inside, 0.0, away)
