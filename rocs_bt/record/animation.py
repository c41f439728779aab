"""Data of the report's animation: plain lists, rounded to the resolution of a screen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..event import NodeTicked, SensorRead, SubtreeSwapped
from .figures.commands import motion_command
from .header import AgentInfo, Beam, Fan
from .history import AgentHistory, BodyHistory, History
from .tree_state import TreeState

_MOST = 4000  # maximum number of samples in a time series; of longer series only every n-th sample is kept
_RAYS, _ECHOES = 180, 120_000  # maximum number of drawn scanner rays: of one scan, and in total
_LEVEL = 0.1  # [m] changes of height up to which the height of a body is not shown
Json = dict[str, Any]


def animation(run: History) -> Json:
    """Data for the script of the report's animation: world, trajectories of bodies, and agents' states over time."""
    header = run.header
    hulls = {b.name: b.hull for b in header.bodies}
    return {
        "start": header.start,
        "end": run.end,
        "bounds": _bounds(run),
        "outlines": [{"name": o.name, "points": o.points, "radius": o.radius} for o in header.outlines],
        "grounds": [{"name": o.name, "points": o.points, "height": o.height} for o in header.grounds],
        "places": [
            {"name": p.name, "x": p.x, "y": p.y, "radius": p.radius, "kind": p.kind, "known": p.known}
            for p in header.places
        ],
        "bodies": [
            {"name": name, "agent": name in run.agents, "hull": hulls.get(name, ()), **_track(body)}
            for name, body in run.bodies.items()
            if len(body.t)
        ],
        "agents": [_agent(run, name, agent) for name, agent in run.agents.items()],
    }


def _bounds(run: History) -> list[float]:
    """Bounds of the world, places and paths: minimum x, minimum y, maximum x, maximum y [m]."""
    places = [(p.x - p.radius, p.y - p.radius, p.x + p.radius, p.y + p.radius) for p in run.header.places]
    found = np.array([run.header.bounds(), *places, *(_extent(b) for b in run.bodies.values())])
    found = found[np.isfinite(found).all(axis=1)]
    if not len(found):
        return [-1.0, -1.0, 1.0, 1.0]
    return [*found[:, :2].min(axis=0).tolist(), *found[:, 2:].max(axis=0).tolist()]


def _extent(body: BodyHistory) -> tuple[float, float, float, float]:
    if not len(body.t):
        return (math.nan,) * 4
    low, high = np.nanmin(body.pose[:, :2], axis=0), np.nanmax(body.pose[:, :2], axis=0)
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _track(body: BodyHistory) -> Json:
    every = max(1, math.ceil(len(body.t) / _MOST))
    pose = np.nan_to_num(body.pose[::every])
    climbs = body.spatial and np.nanmax(body.height) - np.nanmin(body.height) > _LEVEL
    return {
        "t": _rounded(body.t[::every], 3),
        **{k: _rounded(pose[:, i], 4) for i, k in enumerate(("x", "y", "yaw"))},
        **({"z": _rounded(body.height[::every], 3)} if climbs else {}),
        **({"tilt": _rounded(body.tilt[::every], 4)} if body.spatial else {}),
    }


def _agent(run: History, name: str, agent: AgentHistory) -> Json:
    own = [body for body in run.header.bodies if body.name == name]
    beams = {s: b for body in own for s, b in body.beams.items()}
    fans = {s: f for body in own for s, f in body.fans.items()}
    command = motion_command(run, name)
    every = 1 if command is None else max(1, math.ceil(len(command.t) / _MOST))
    return {
        "name": name,
        "routes": [[s.name, round(s.begin, 3), round(s.end, 3)] for s in agent.routes],
        "switches": agent.switches,
        "rules": [[round(e.t, 3), e.rule, e.phase, e.reading] for e in agent.rules],
        "tree": [[round(e.t, 3), e.node, e.status] for e in agent.tree],
        "leaves": [
            [n.path, n.path.rpartition("/")[2] + n.ports]
            for i in run.header.agents
            if i.name == name
            for n in agent.nodes(i)
            if not n.children
        ],
        "waits": [row for i in run.header.agents if i.name == name for row in _waits(i, agent)],
        "tickets": [[round(e.t, 3), e.ticket, e.action, e.state] for e in agent.tickets],
        "atomic": [[round(e.t, 3), e.action, e.route] for e in agent.atomic],
        "axes": [axis for i in run.header.agents if i.name == name for axis in i.axes],
        "motion": []
        if command is None
        else [
            [round(t, 3), *_rounded(v, 3)]
            for t, v in zip(command.t[::every].tolist(), command.values[::every], strict=True)
        ],
        "beams": [_ranges(beams[s], reads) for s, reads in agent.readings.items() if s in beams],
        "scans": [_scans(fans[s], reads) for s, reads in agent.readings.items() if s in fans],
    }


def _waits(info: AgentInfo, agent: AgentHistory) -> list[list[Any]]:
    """Rows of time and text: the nodes in which the mission waits from this time, with their values and deadlines."""
    state, rows = TreeState(info.nodes), list[list[Any]]()
    ports = {node.path: node.ports for node in (*info.nodes, *agent.nodes(info))}
    for event in sorted([*agent.tree, *agent.swaps], key=lambda e: e.t):
        if isinstance(event, SubtreeSwapped):
            state.swap(event)
        elif isinstance(event, NodeTicked):
            state.take(event)
        texts = []
        for node, _ in state.waiting():
            what = "; ".join(filter(None, (node.feedback, *state.deadlines(node.node))))
            texts.append(node.node.rpartition("/")[2] + ports.get(node.node, "") + (f": {what}" if what else ""))
        t, text = round(event.t, 3), ", ".join(texts)
        if rows and rows[-1][0] == t:
            rows[-1][1] = text
        elif not rows or rows[-1][1] != text:
            rows.append([t, text])
    return rows


def _ranges(beams: tuple[Beam, ...], reads: list[SensorRead]) -> Json:
    fits = [r for r in reads if len(r.data) == 8 * len(beams)]
    fits = fits[:: max(1, math.ceil(len(fits) / _MOST))]
    return {
        "beams": [[round(v, 4) for v in (b.x, b.y, b.yaw, b.reach, b.cone, b.elevation)] for b in beams],
        "t": [round(r.t, 3) for r in fits],
        "ranges": [[_range(v) for v in r.values] for r in fits],
    }


def _scans(fan: Fan, reads: list[SensorRead]) -> Json:
    """Scans of a laser scanner, with only every n-th ray and scan kept, to limit the numbers of rays and echoes."""
    every = math.ceil(fan.rays / _RAYS)
    fits = [r for r in reads if len(r.data) == 8 * fan.rays]
    fits = fits[:: max(1, math.ceil(len(fits) * fan.rays / (every * _ECHOES)))]
    return {
        "fan": [round(v, 6) for v in (fan.x, fan.y, fan.yaw, fan.step * every, fan.reach)],
        "t": [round(r.stamp, 3) for r in fits],
        "ranges": [[_range(v) for v in r.values[::every]] for r in fits],
    }


def _range(value: float) -> float | None:
    """Range rounded to centimetres for JSON: None for no echo, -1 for an invalid value."""
    if math.isnan(value):
        return -1
    return round(value, 2) if math.isfinite(value) else None


def _rounded(values: Any, digits: int) -> list[float]:
    return [round(v, digits) if math.isfinite(v) else 0.0 for v in values.tolist()]
