"""Metrics, against numbers worked out by hand and against what must not matter."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rocs_bt.base.errors import UnknownName
from rocs_bt.compare.metric import METRICS, EpisodeData, barn_score, cvar, measure_all, metric, turning
from rocs_bt.compare.runner import MetricSink
from rocs_bt.event import BodyMoved, pack
from rocs_bt.record import AgentResult, Finding, TrackingError

FINDING = Finding(
    name="keeps clear",
    require="always true",
    verdict="violated",
    margin=-0.05,
    unit="m",
    worst=1.0,
    violated=1.0,
    samples=1,
    unknown=0,
)
AGENT = AgentResult(
    robot="r",
    mission="m",
    rules=(),
    outcome="success",
    time_to_goal=12.0,
    path_length=8.0,
    min_clearance=0.2,
    collisions=0,
    time_reactive=1.0,
    time_deliberative=3.0,
    route_switches=4,
    replans=2,
    tracking_error=TrackingError(cross_rms=0.03),
    requirements=(FINDING,),
)


def measured(outcome="success", length=6.0, **changed):
    return EpisodeData(outcome, 60.0, length, replace(AGENT, **changed))


def test_a_success_by_hand():
    found = measure_all(measured())
    assert found["success"] == 1.0
    assert found["time"] == 12.0
    assert found["spl"] == pytest.approx(6.0 / 8.0)
    assert found["barn2024"] == pytest.approx(3.0 / 12.0)  # 6 m at 2 m/s are 3 s, and 12 s are 4 times that
    assert found["barn2022"] == pytest.approx(1.0 / 4.0)
    assert found["reflex_share"] == 0.25
    assert found["tracking"] == 0.03
    assert found["margin of keeps clear"] == -0.05


@pytest.mark.parametrize("outcome", ["collision", "failed", "stuck", "timeout", "error"])
def test_a_failure_counts_and_never_flatters(outcome):
    found = measure_all(measured(outcome, collisions=int(outcome == "collision")))
    assert found["time"] == 60.0  # even where it was at the goal before
    assert [found[name] for name in ("success", "spl", "barn2022", "barn2024")] == [0.0, 0.0, 0.0, 0.0]
    assert found["collision"] == float(outcome == "collision")
    assert found["path_length"] == 8.0


@pytest.mark.parametrize(
    ("outcome", "changed", "clean", "fell"),
    [
        ("success", {}, 1.0, 0.0),
        ("success", {"collisions": 1}, 0.0, 0.0),
        ("success", {"fell": True}, 0.0, 1.0),
        ("success", {"collisions": None, "fell": None}, 1.0, 0.0),
        ("timeout", {}, 0.0, 0.0),
        ("collision", {"collisions": 1, "fell": True}, 0.0, 1.0),
    ],
)
def test_clean_is_success_without_a_collision_and_without_a_fall(outcome, changed, clean, fell):
    found = measure_all(measured(outcome, **changed))
    assert (found["clean"], found["fell"]) == (clean, fell)


def test_without_a_reference_way_nothing_is_claimed_of_it():
    found = measure_all(measured(length=0.0))
    assert (found["spl"], found["barn2022"], found["barn2024"]) == (None, None, None)


def test_who_drives_shorter_than_the_reference_wins_no_more_than_all():
    assert measure_all(measured(path_length=5.0))["spl"] == 1.0


@pytest.mark.parametrize(
    ("time", "low", "score"),
    [(5.0, 2.0, 0.5), (10.0, 2.0, 0.5), (20.0, 2.0, 0.25), (40.0, 2.0, 0.125), (99.0, 2.0, 0.125), (5.0, 4.0, 0.25)],
)
def test_the_barn_score_by_hand(time, low, score):
    assert barn_score(time, 10.0, low=low, high=8.0) == pytest.approx(score)  # 10 m are 5 s at 2 m/s


def test_the_worst_twentieth_by_hand():
    assert cvar([float(i) for i in range(100)]) == pytest.approx(2.0)  # of 0, 1, 2, 3, 4
    assert cvar([3.0, 1.0]) == pytest.approx(1.0)
    assert cvar([]) is None
    assert cvar([5.0, 1.0, *[9.0] * 28]) == pytest.approx((1.0 + 0.5 * 5.0) / 1.5)  # of 30 values 1.5


@given(st.lists(st.floats(-1.0, 10.0), min_size=1, max_size=60))
def test_the_worst_twentieth_is_between_the_least_and_the_mean(values):
    assert min(values) - 1e-9 <= cvar(values) <= np.mean(values) + 1e-9


def drive(points, wheels=()):
    sink = MetricSink("R")
    for i, (x, y) in enumerate(points):
        rims = pack([wheels[i], wheels[i]]) if len(wheels) else b""
        sink.emit(BodyMoved(t=0.05 * i, agent="R", body="R", x=x, y=y, yaw=0.0, wheels=rims))
        sink.emit(BodyMoved(t=0.05 * i, body="other", x=9.0, y=9.0, yaw=0.0))
    return sink


def circle(n, radius=1.0):
    angles = np.linspace(0.0, 2.0 * math.pi, n)
    return list(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True))


def test_a_circle_turns_by_its_curvature():
    assert turning(drive(circle(500)).path()) == pytest.approx(1.0, rel=0.03)
    assert turning(drive(circle(2000, radius=2.0)).path()) == pytest.approx(0.5, rel=0.03)
    assert turning(drive([(0.0, 0.0), (5.0, 0.0)]).path()) == pytest.approx(0.0)
    assert turning(drive([(0.0, 0.0)]).path()) is None


@settings(max_examples=30)
@given(st.integers(100, 800), st.integers(1, 4))
def test_smoothness_does_not_depend_on_how_often_one_looks(n, times):
    """The same way, looked at several times as often, also while it stands still."""
    points = [(0.01 * i, 0.3 * math.sin(0.03 * i)) for i in range(n)]
    dense = [p for a, b in pairwise(points) for p in _between(a, b, times)] + points[-1:] * 50
    assert turning(drive(dense).path()) == pytest.approx(turning(drive(points).path()), rel=0.02, abs=1e-3)


def _between(a, b, times):
    return [(a[0] + (b[0] - a[0]) * k / times, a[1] + (b[1] - a[1]) * k / times) for k in range(times)]


def test_energy_counts_gathered_speed_alone():
    sink = drive([(0.0, 0.0)] * 6, wheels=[0.0, 0.4, 1.0, 1.0, 0.2, 0.6])
    assert sink.energy == pytest.approx(0.5 * 1.0**2 + 0.5 * (0.6**2 - 0.2**2))
    assert drive([(0.0, 0.0)]).energy is None


def test_a_track_begins_and_ends_where_the_way_does():
    points = [(0.03 * i, 0.0) for i in range(100)]
    track = np.frombuffer(drive(points).track(), dtype=np.float32).reshape(-1, 2)
    assert track[0].tolist() == [0.0, 0.0]
    assert track[-1][0] == pytest.approx(2.97)
    assert 30 <= len(track) <= 32


def test_each_metric_tells_what_it_is():
    for name, each in METRICS.items():
        assert each is metric(name)
        assert each.doc.endswith(".")
        assert each.direction in ("up", "down")
    assert metric("margin of keeps clear").direction == "up"
    assert metric("holds keeps clear").direction == "up"
    with pytest.raises(UnknownName, match="no metric is named 'speed'"):
        metric("speed")


def test_the_jerk_of_a_constant_acceleration_is_zero_and_of_a_cubic_is_its_third_derivative():
    times = 0.05 * np.arange(200)
    assert drive([(0.5 * t * t, 1.0) for t in times]).jerk() == pytest.approx(0.0, abs=1e-6)
    assert drive([(0.1 * t**3, 0.0) for t in times]).jerk() == pytest.approx(0.6)
    assert drive([(0.0, 0.0)] * 3).jerk() is None
