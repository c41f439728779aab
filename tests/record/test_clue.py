"""Clues to the firing of a rule: silent sensors, limits of sensors, and the nearest object of the recorded world."""

import math
import re

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, RuleChanged, SensorFailed, SignalsWritten, TicketChanged, pack
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import Why
from rocs_bt.record.explanation.why_not import Held
from rocs_bt.record.file.header import AgentInfo, BodyInfo, GuardInfo, Outline, RunHeader, SensorInfo, SignalInfo
from rocs_bt.record.fold.clue import limit_text
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.testing.faults import DeadSensor, FrozenSensor, LyingSensor, break_sensor

HULL = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))
GROUPS = {"front": 0, "left_gap": 90, "rear": 180, "right_gap": -90}  # [deg]


def clue(signals=(), outlines=(), others=(), pose=(0.0, 0.0, 0.0), failed=(), simulated=True, hold=0.0):
    """Clue of a rule at 1 s that reads all given signals; values are written at 0 s and at 1 s."""
    infos = tuple(SignalInfo(name=name, size=len(values), units=("m",)) for name, values in signals)
    sensors = (
        SensorInfo(name="sonar", signals=tuple(name for name, _ in signals if name != "goal")),
        SensorInfo(name="gps", signals=("pose",), derived=("goal",)),
    )
    text = " + ".join(f"min({name})" for name, _ in signals)
    limits = ((0.1, "0.1 m is the minimum of the sensor 'sonar'"), (5.0, "5 m is the maximum of the sensor 'sonar'"))
    limits = limits if any(name != "goal" for name, _ in signals) else ()
    guard = GuardInfo(rule="f/A", when=text, sources=(f"({text} < 1 m)",), limits=limits, hold=hold)
    agent = AgentInfo(name="R", robot="r", mission="m", signals=infos, guards=(guard,), sensors=sensors)
    bodies = (BodyInfo(name="R", hull=HULL), *(BodyInfo(name=name, hull=HULL) for name, _ in others))
    tracks = Tracks(
        RunHeader(scenario="x", seed=1, agents=(agent,), bodies=bodies, outlines=tuple(outlines), simulated=simulated)
    )
    for name, (x, y, yaw) in (("R", pose), *others):
        tracks.emit(BodyMoved(t=0.0, agent="", body=name, x=x, y=y, yaw=yaw))
    for t, values in ((0.0, [[1.0] * len(v) for _, v in signals]), (1.0, [v for _, v in signals])):
        data, names = pack(v for row in values for v in row), tuple(name for name, _ in signals)
        tracks.emit(
            SignalsWritten(t=t, agent="R", monitor="m", signals=names, sizes=tuple(map(len, values)), data=data)
        )
    tracks.take([SensorFailed(t=0.5, agent="R", sensor=sensor, detail="silent") for sensor in failed])
    tracks.emit(RuleChanged(t=1.0, agent="R", rule="f/A", phase="fired", priority=1))
    return tracks.get("R", "clue", "f/A").v[-1]


NAN = math.nan


@pytest.mark.parametrize(("value", "first"), [(0.3, "held"), (NAN, "could not be evaluated")])
def test_a_guard_that_has_to_hold_for_a_time_says_so(value, first):
    assert clue([("front", [value])], hold=0.9).startswith(f"0.9 s after its guard first {first}: for = 0.9 s")


@pytest.mark.parametrize(
    ("signals", "failed", "text"),
    [
        ([("front", [0.1, 2.0])], (), "0.1 m is the minimum of the sensor 'sonar'"),
        ([("front", [0.101, 2.0])], (), ""),
        ([("front", [5.0, 5.0])], (), "5 m is the maximum of the sensor 'sonar'"),
        ([("front", [0.3, 5.0])], (), ""),  # the least decides
        ([("goal", [0.1])], (), ""),  # a distance that is no reading
        ([("front", [NAN, 2.0])], (), "no valid value of the sensor 'sonar' since t = 0.00 s"),
        ([("front", [NAN, 2.0])], ("sonar",), "the sensor 'sonar' failed at t = 0.50 s"),
        ([("front", [NAN]), ("rear", [NAN])], ("gps",), "no valid value of the sensor 'sonar' since t = 0.00 s"),
        ([("goal", [NAN])], ("gps",), "the sensor 'gps' failed at t = 0.50 s"),
        (
            [("front", [NAN]), ("goal", [NAN])],
            ("gps",),
            "no valid value of the sensor 'sonar' since t = 0.00 s; the sensor 'gps' failed at t = 0.50 s",
        ),
    ],
)
def test_a_silent_sensor_and_a_limit_are_named(signals, failed, text):
    assert clue(signals, failed=failed) == text


def segment(point, a, b):
    """Distance of a point from a segment."""
    point, a, b = map(np.array, (point, a, b))
    part = np.clip(np.dot(point - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return float(np.linalg.norm(point - a - part * (b - a)))


def test_the_blocker_is_the_nearest_object_within_the_groups_of_the_guard():
    """Small objects around the robot, in random directions, against plain geometry."""
    random, seen = np.random.default_rng(3), 0
    for _ in range(80):
        pose = (*random.uniform(-3.0, 3.0, 2), random.uniform(-math.pi, math.pi))
        groups = random.choice(list(GROUPS), random.integers(1, 5), replace=False).tolist()
        outlines, expected = [], []
        for k in range(5):
            bearing, away = random.uniform(-math.pi, math.pi), random.uniform(0.5, 2.5)
            x, y = away * math.cos(bearing), away * math.sin(bearing)
            c, s = math.cos(pose[2]), math.sin(pose[2])
            centre = (pose[0] + c * x - s * y, pose[1] + s * x + c * y)
            outlines.append(Outline.circle(f"post{k}", centre, 0.02))
            apart = min(segment((x, y), a, b) for a, b in zip(HULL, (*HULL[1:], HULL[0]), strict=True)) - 0.02
            degrees = [abs((math.degrees(bearing) - GROUPS[name] + 180) % 360 - 180) for name in groups]
            if min(degrees) < 60 and away < 1.9:
                expected.append((apart, f"post{k}"))
            elif min(degrees) < 70:  # at the edge of a group, or of what is near
                expected.append((math.nan, ""))
        text = clue([(name, [0.4]) for name in groups], outlines, pose=pose)
        if any(math.isnan(apart) for apart, _ in expected):
            continue
        seen += bool(expected)
        if not expected:
            assert text == ""
            continue
        apart, name = min(expected)
        found = re.fullmatch(r"in the recorded world '(post\d)' is nearest, (\d\.\d\d) m away", text)
        assert found[1] == name
        assert float(found[2]) == pytest.approx(apart, abs=0.015)
    assert seen > 20


def test_other_robots_block_where_they_are_and_an_unknown_world_is_not_told():
    front = [("front", [0.4])]
    assert clue(front, others=[("P", (1.0, 0.0, 0.0))]) == "in the recorded world 'P' is nearest, 0.40 m away"
    assert clue(front, others=[("P", (-1.0, 0.0, 0.0))]) == ""
    assert clue(front, others=[("P", (0.5, 0.0, 0.0))]) == "in the recorded world 'P' is nearest, 0.00 m away"
    assert clue(front, others=[("P", (1.0, 0.0, 0.0))], simulated=False) == ""
    assert clue([("goal", [0.4])], others=[("P", (1.0, 0.0, 0.0))]) == ""


def test_where_an_action_failed_is_told_with_what_was_near_in_any_direction():
    hull = BodyInfo(name="R", hull=HULL)
    door = Outline.box("door", Pose2(-1.0, 0.0, 0.0), (0.2, 2.0))
    tracks = Tracks(RunHeader(scenario="x", seed=1, bodies=(hull,), outlines=(door,)))
    tracks.emit(BodyMoved(t=0.0, agent="R", body="R", x=0.0, y=0.0, yaw=1.0))
    ticket = {"agent": "R", "ticket": 7, "action": "GoTo", "priority": "NORMAL", "by": "m"}
    tracks.emit(TicketChanged(t=0.1, state="RUNNING", **ticket))
    assert tracks.get("R", "clue", "7") is None
    tracks.emit(TicketChanged(t=0.2, state="FAILED", **ticket))
    near = re.fullmatch(r"in the recorded world 'door' is nearest, (0\.\d\d) m away", tracks.get("R", "clue", "7").v[0])
    corners = [(math.cos(1.0) * x - math.sin(1.0) * y) for x, y in HULL]
    assert float(near[1]) == pytest.approx(min(corners) + 0.9, abs=0.011)


@pytest.mark.parametrize("kind", [DeadSensor, FrozenSensor, LyingSensor])
@pytest.mark.parametrize("sensor", ["sonar", "position"])
def test_the_sensor_that_fell_silent_is_named_by_why_and_in_the_reason(kind, sensor, tmp_path):
    broken = run(
        "exp1", seed=1, out=tmp_path, report=False, prepare=lambda world: break_sensor(world, sensor, kind, at=2.0)
    )
    tracks = Tracks.of_recording(Recording.open(tmp_path))
    assert f"the sensor '{sensor}'" in Why(tracks, 3.0).answer
    result = broken.summary.agents["R2"]
    assert result.outcome == "stuck"
    assert tracks.get("R2", "clue", "outcome").v[0].startswith("in the recorded world 'box' is nearest, ")
    assert f"the sensor '{sensor}' failed at t = 2." in result.reason


def test_the_header_has_the_limits_that_each_guard_meets_and_which_sensor_writes_each_signal(tmp_path):
    run("exp3", seed=1, duration=0.2, out=tmp_path, report=False)
    for agent in Recording.open(tmp_path).header.agents:
        robot = Catalog.here().load_robot(agent.robot)
        ranges = {sensor.name: sensor.arguments["range"] for sensor in robot.sensors if "range" in sensor.arguments}
        writes = {sensor.name: sensor.signals for sensor in agent.sensors}
        assert ranges
        for guard in agent.guards:
            read = [name for name in ranges if any(re.search(rf"\b{s}\b", str(guard.sources)) for s in writes[name])]
            assert sorted(value for value, _ in guard.limits) == sorted(v for name in read for v in ranges[name])
        written = {name for sensor in agent.sensors for name in (*sensor.signals, *sensor.derived)}
        assert written >= {signal.name for signal in agent.signals}


def test_a_rule_that_a_limit_keeps_from_firing_says_so(tmp_path):
    """The reading of the page is rounded, so that a value counts as the limit within half a millimetre."""
    guard = GuardInfo(rule="f/A", when="d < 0.05 m", limits=((0.1, "0.1 m is the minimum of the sensor 'sonar'"),))
    assert limit_text(guard, 0.1004) == limit_text(guard, 0.0996) == guard.limits[0][1]
    assert limit_text(guard, 0.1006) == limit_text(guard, math.nan) == ""
    held = Held("d < 0.05 m", 0.1, 0.05, "m", False, limit_text(guard, 0.1))
    text = "'d < 0.05 m' does not hold by 0.05 m (0.1 against 0.05 m; 0.1 m is the minimum of the sensor 'sonar')"
    assert str(held) == text
