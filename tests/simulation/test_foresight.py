"""Foresight: what an oracle foresees is what happens, and no other planner is given it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from rocs_bt._run import run
from rocs_bt.agent import Agent
from rocs_bt.catalog import CachingCatalog
from rocs_bt.compare import load_family
from rocs_bt.declare import replaced
from rocs_bt.event import BodyMoved

CATALOG = CachingCatalog(None, code=True)
PERIOD = 0.05
POLITE = {"motion": "polite", "density": "sparse"}


class _Places:
    """Where the people were, by name and control period."""

    def __init__(self):
        self.rows = {}

    def emit(self, event):
        if isinstance(event, BodyMoved) and event.body.startswith("P") and "_" not in event.body:
            self.rows.setdefault(round(event.t / PERIOD), {})[event.body] = (event.x, event.y)


def played(monkeypatch, planner, family="crowd", duration=1.3, index=3001, change=None, **parameters):
    """Movers of the agent by control period, and where the people were: (n, 2) arrays by control period."""
    scene = load_family(CATALOG, family, parameters).scene(index)
    scene = dataclasses.replace(scene, scenario={**scene.scenario, "duration": f"{duration} s"})
    catalog, places, movers, step = scene.added_to(CATALOG), _Places(), {}, Agent.step

    def watched(self, count):
        step(self, count)
        movers[count] = self.knowledge.world.movers, self.knowledge.world.foreseen

    monkeypatch.setattr(Agent, "step", watched)
    spec = replaced(catalog.load_planner(planner), **(change or {})).drives(
        catalog.load_scenario(scene.name), "R", scene.privileged
    )
    run(spec, catalog, seed=1, report=False, sinks=[places])
    return movers, {k: np.array(list(row.values())) for k, row in places.rows.items()}


def errors(movers, places, ahead):
    """Distances between where people were foreseen and where they were, this time ahead [s]."""
    later = round(ahead / PERIOD)
    found = []
    for k, (known, _) in movers.items():
        if k + later in places:
            at = known.predict([(k + later) * PERIOD]).positions[:, 0]
            found.append(np.hypot(*(at - places[k + later]).T))
    return np.concatenate(found)


@pytest.mark.parametrize(("family", "more"), [("crowd", {"motion": "blind"}), ("dynabarn", {})])
def test_the_future_of_those_that_see_nothing_is_exact(family, more, monkeypatch):
    movers, places = played(monkeypatch, "among_oracle", family, **more)
    for ahead in (0.0, PERIOD, 1.0):
        assert errors(movers, places, ahead).max() < 0.001


@pytest.mark.parametrize("legs", [0, 1])
def test_the_future_of_those_that_yield_is_exact_if_the_robot_stays(legs, monkeypatch):
    movers, places = played(monkeypatch, "none", change={"oracle": True}, **POLITE, legs=legs, middle=1)
    for ahead in (0.0, PERIOD, 1.0):
        assert errors(movers, places, ahead).max() < 0.001


def test_the_future_of_those_that_yield_is_near_if_the_robot_drives(monkeypatch):
    movers, places = played(monkeypatch, "among_oracle", duration=2.0, **POLITE)
    off = errors(movers, places, 1.0)
    assert np.median(off) < 0.01
    assert np.percentile(off, 95) < 0.1


@pytest.mark.parametrize("planner", ["hybrid", "among", "dynamic_window", "oracle", "among_oracle"])
def test_only_an_oracle_is_given_it(planner, monkeypatch):
    movers, _ = played(monkeypatch, planner, duration=0.3)
    for known, foreseen in movers.values():
        assert (foreseen is not None) == ("oracle" in planner)
        assert (known is foreseen) == ("oracle" in planner)
