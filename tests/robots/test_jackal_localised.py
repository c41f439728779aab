"""The Jackal without ground truth: it drives by its own estimate, which stays near the truth."""

from __future__ import annotations

import dataclasses
import math

from rocs_bt import run
from rocs_bt.catalog import CachingCatalog
from rocs_bt.compare.family import load_family
from rocs_bt.event import BodyMoved, ListSink, SensorRead, SignalsWritten

CATALOG = CachingCatalog()


def test_it_drives_by_its_own_estimate():
    scene = load_family(CATALOG, "barn_like", {}).scene(13)
    (agent,) = scene.scenario["agent"]
    moved = {**scene.scenario, "agent": [{**agent, "robot": "jackal_localised"}]}
    catalog = dataclasses.replace(scene, scenario=moved).added_to(CATALOG)
    planned = catalog.load_planner("hybrid").drives(catalog.load_scenario(scene.name), agent["name"], scene.privileged)
    sink = ListSink()
    played = run(planned, catalog, seed=1, duration=3.0, report=False, sinks=[sink]).summary.agents[agent["name"]]
    truth = {round(e.t, 3): e for e in sink.events if isinstance(e, BodyMoved) and e.body == agent["name"]}
    poses = {
        round(e.t, 3): e.values["pose"] for e in sink.events if isinstance(e, SignalsWritten) and "pose" in e.signals
    }
    pairs = [(truth[t], pose) for t, pose in poses.items() if t in truth]
    fixes = {e.stamp for e in sink.events if isinstance(e, SensorRead) and e.sensor == "position"}
    assert played.path_length > 0.8
    assert len(pairs) > 50
    assert len(fixes) <= 7
    assert max(math.hypot(x - e.x, y - e.y) for e, (x, y, _) in pairs) < 0.2
    assert max(abs(math.remainder(yaw - e.yaw, math.tau)) for e, (_, _, yaw) in pairs) < 0.2
