"""ClearanceWatch: it measures seldom, and misses nothing."""

from __future__ import annotations

import math

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink, MinClearanceLowered
from rocs_bt.simulation import SimulatedWorld


@pytest.mark.parametrize(("scenario", "agents"), [("exp1", ("R2",)), ("exp3", ("R2", "R3"))])
def test_it_tells_the_least_distance_of_all_periods(catalog: Catalog, scenario: str, agents: tuple[str, ...]) -> None:
    stages: list[SimulatedWorld] = []
    least: dict[str, list[tuple[float, str]]] = {name: [] for name in agents}

    def look(t: float) -> None:
        """Measure in every period, as the watch need not."""
        for name, found in least.items():
            near = stages[0].world.clearance(name)
            if near[0] < (found[-1][0] if found else math.inf):
                found.append(near)

    sink = ListSink()
    rocs_bt.run(
        scenario, catalog, seed=1, duration=15.0, report=False, prepare=stages.append, progress=look, sinks=[sink]
    )
    told = [event for event in sink.events if isinstance(event, MinClearanceLowered)]
    for name, found in least.items():
        assert [(event.distance, event.other) for event in told if event.agent == name] == found
        assert len(found) > 3
