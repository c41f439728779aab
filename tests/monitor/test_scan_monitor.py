"""ScanMonitor: a scan, and the gaps between hull and echoes in the groups that rules use."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import ListSink
from rocs_bt.interfaces.device import Reading, Sensor
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import MonitoredSensor, ScanMonitor
from rocs_bt.monitor.scan_monitor import SectorTable

BEAMS, SPAN = 271, math.radians(270.0)  # a degree each
RAYS = [math.radians(i - 135.0) for i in range(BEAMS)]
AHEAD = Pose2(0.1, 0.0, 0.0)
GROUPS = {
    "front": {
        "sectors": [[0.0, math.radians(20.0)], [math.radians(-40.0), math.radians(-20.0)]],
        "weights": [1.0, 0.8],
    },
    "rear": {"blind": True},
}


class Scanner(Sensor):
    """Says what the test wants."""

    def __init__(self, values: list[float]) -> None:
        super().__init__("lidar")
        self.values = values

    def read(self) -> Reading:
        return Reading(0.0, self.values)


def interpreted(values: list[float], mount: Pose2 | None = AHEAD, groups: Any = GROUPS, **looks: Any) -> Any:
    clock = SimulatedClock(0.05)
    knowledge = Knowledge("R", clock, ListSink())
    knowledge.graph.set("R", length=0.5, width=0.4)
    told = {"signal": "scan", "rays": BEAMS, "span": SPAN, "mount": mount} | looks
    knowledge.graph.add("lidar", "sensor", **{key: value for key, value in told.items() if value})
    knowledge.graph.relate("R", "has_sensor", "lidar")
    watched = [MonitoredSensor(Scanner(values), Rate(1, 0.05))]
    monitor = ScanMonitor(
        "scan", watched, knowledge, ListSink(), group={n: SectorTable(**g) for n, g in groups.items()}
    )
    for signal in monitor.signals():
        knowledge.signals.declare(signal)
    monitor.run(0.0, 0)
    return {name: knowledge.signals.read(name, 0.0).tolist() for name in knowledge.signals.names}


def ray(degrees: float) -> int:
    return round(degrees) + 135


def test_an_obstacle_counts_from_the_hull_and_over_its_weight() -> None:
    values = [math.inf] * BEAMS
    values[ray(0)], values[ray(-30)], values[ray(90)] = 1.15, 1.0, 0.3
    found = interpreted(values)
    assert found["scan"] == values
    to_side = 0.2 / math.sin(math.radians(30.0))  # leaves the hull by its front, before its side
    to_front = 0.15 / math.cos(math.radians(30.0))
    assert found["front"] == pytest.approx([1.0, (1.0 - min(to_side, to_front)) / 0.8])
    assert found["rear"] == [math.inf]


def test_what_is_within_the_hull_is_at_its_surface_and_a_dead_ray_blinds_its_sector() -> None:
    values = [2.0] * BEAMS
    values[ray(10)], values[ray(-30)] = 0.06, math.nan
    front = interpreted(values)["front"]
    assert front[0] == 0.0
    assert math.isnan(front[1])


@given(st.floats(-0.2, 0.2), st.floats(-0.15, 0.15), st.floats(-3.0, 3.0))
def test_a_ray_that_ends_on_the_hull_has_no_gap(x: float, y: float, yaw: float) -> None:
    # The hull's outline as seen from the scanner, by an independent way: bisection along each ray.
    bearings = np.linspace(-SPAN / 2, SPAN / 2, BEAMS) + yaw
    low, high = np.zeros(BEAMS), np.full(BEAMS, 2.0)
    for _ in range(50):
        middle = (low + high) / 2
        inside = (abs(x + middle * np.cos(bearings)) <= 0.25) & (abs(y + middle * np.sin(bearings)) <= 0.2)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    sectors = {"all": {"sectors": [[b, b] for b in (0.0, 1.0471975511965976, -2.0943951023931953)]}}
    found = interpreted((low + 0.3).tolist(), Pose2(x, y, yaw), sectors)["all"]
    assert found == pytest.approx([0.3] * 3, abs=1e-9)


# Rounding decides about a bound within 1e-9 rad of a ray.
bearings = st.floats(-135.0, 135.0).map(math.radians).filter(lambda b: all(abs(b - ray) > 1e-9 for ray in RAYS))


@settings(max_examples=40)
@given(st.lists(st.tuples(bearings, bearings, st.sampled_from([0.5, 0.8, 1.0])), min_size=1, max_size=5), st.data())
def test_a_sector_has_the_rays_between_its_bearings_and_no_other(sectors: list[Any], data: Any) -> None:
    values = data.draw(st.lists(st.sampled_from([1.0, 1.5, 2.0, 3.0, math.inf]), min_size=BEAMS, max_size=BEAMS))
    each = interpreted(values, groups={f"ray{i}": {"sectors": [[b, b]]} for i, b in enumerate(RAYS)})
    sectors = [s for s in sectors if any(min(s[:2]) <= b <= max(s[:2]) for b in RAYS)]
    groups = {"all": {"sectors": [list(s[:2]) for s in sectors], "weights": [s[2] for s in sectors]}}
    expected = [
        min(each[f"ray{i}"][0] for i, b in enumerate(RAYS) if min(low, high) <= b <= max(low, high)) / weight
        for low, high, weight in sectors
    ]
    if sectors:
        assert interpreted(values, groups=groups)["all"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rays": 5000}, "takes at most 4000 rays"),
        ({"span": 7.0}, "over at most 360 deg, found 271 and 401.1 deg"),
        ({"mount": None}, "no sensor of 'R' has the signal 'scan' and declares rays, span and mount.*mount ="),
        ({"signal": "range"}, "no sensor of 'R' has the signal 'scan' and declares"),
        ({"groups": {"front": {}}}, "group 'front' of monitor 'scan' needs sectors.*blind = true"),
        ({"groups": {"front": {"sectors": [[0.0, 1.0]], "weights": [2.0]}}}, "one weight in"),
        ({"groups": {"front": {"sectors": [[3.0, 3.1]]}}}, "two bearings with rays between them"),
        ({"groups": {"front": {"sectors": [[0.1, 0.2, 0.3]]}}}, "two bearings with rays between them"),
    ],
)
def test_says_what_is_wrong(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        interpreted([1.0] * BEAMS, **wrong)
