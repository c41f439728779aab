"""LocalMap: what a lidar sees, drawn from where it was seen, and the time of the next contact."""

import math

import numpy as np
import pytest

from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2, Twist2, along_arc, wrap_angle
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.event import ListSink, MapChanged
from rocs_bt.interfaces.channel import AnalyzeSubscriber, Publisher
from rocs_bt.knowledge import FREE, OCCUPIED, UNKNOWN, Knowledge, Movers

FIELD, BEAMS, AHEAD = math.radians(270.0), 541, 0.1
ORIGIN = Pose2(0.0, 0.0)
WALL = 2.0  # [m] x of a wall without end


class Bench:
    """A LocalMap, and a robot in a world that is one wall."""

    def __init__(self, **parameters):
        self.clock, self.sink = SimulatedClock(0.05), ListSink()
        self.knowledge = Knowledge("R", self.clock, self.sink)
        self.knowledge.graph.set("R", length=0.5, width=0.4)
        mount = Pose2(AHEAD, 0.0)
        self.knowledge.graph.add("lidar", "sensor", signal="scan", rays=BEAMS, span=FIELD, mount=mount)
        self.knowledge.graph.relate("R", "has_sensor", "lidar")
        self.analyze = ANALYZERS["LocalMap"]("map", self.knowledge, self.sink, **parameters)
        for signal in self.analyze.signals():
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.declare(Signal("scan", BEAMS, (LENGTH,)))
        self.knowledge.signals.declare(Signal("speed", 1, (SPEED,)))
        self.knowledge.signals.declare(Signal("turn_rate", 1, (TURN_RATE,)))
        self.knowledge.signals.freeze()
        self.plan = AnalyzeSubscriber()
        self.analyze.attach(self.plan)
        self.publisher = Publisher("monitor")
        self.publisher.connect(self.analyze.inbox)

    def scan(self, pose, wall=WALL):
        angles = np.linspace(-0.5 * FIELD, 0.5 * FIELD, BEAMS) + pose.yaw
        x, _ = pose.transform(AHEAD, 0.0)
        with np.errstate(divide="ignore"):
            ranges = (wall - x) / np.cos(angles)
        return np.where((ranges > 0.0) & (ranges < 10.0), ranges, math.inf).tolist()

    def look(self, place=ORIGIN, /, speed=0.0, turn=0.0, late=0.0, **samples):
        self.clock.advance()
        now = self.clock.now()
        self.knowledge.signals.update({"speed": [speed], "turn_rate": [turn]}, now)
        for sample in ({"scan": self.scan(place)}, {"pose": list(place)}) if not samples else (samples,):
            self.publisher.publish(now - late, sample)
        self.analyze.run(now)
        return self.knowledge.signals.value("contact_time", now)

    def state(self, x, y):
        return self.knowledge.world.occupancy.state(x, y)


def test_it_draws_what_stands_there_what_is_free_and_leaves_the_rest():
    bench = Bench()
    bench.look()
    assert bench.state(WALL + 0.01, 0.5) == OCCUPIED
    assert bench.state(1.0, 0.5) == FREE
    assert bench.state(WALL + 0.5, 0.0) == UNKNOWN  # behind the wall
    assert bench.state(-1.0, 0.0) == UNKNOWN  # behind the robot, where no beam looks


@pytest.mark.parametrize("pose", [Pose2(0.31, -1.2, 0.5), Pose2(-2.0, 0.4, -0.3), Pose2(1.0, 1.0, 1.2)])
def test_from_wherever_it_looks_the_wall_stands_in_the_same_place(pose):
    bench = Bench()
    for _ in range(3):
        bench.look(pose)
    points = bench.knowledge.world.occupancy.window((-5.0, -5.0), (5.0, 5.0)).points()
    assert len(points) > 20
    assert points[:, 0] == pytest.approx(np.full(len(points), WALL), abs=1e-6)


@pytest.mark.parametrize("pose", [Pose2(0.048, -0.047, 0.3), Pose2(0.052, 0.046, 2.5), Pose2(-0.04, 0.049, -1.6)])
def test_cells_are_free_exactly_up_to_where_the_beams_end(pose):
    bench, reach = Bench(), 1.0
    cell = bench.knowledge.world.occupancy.cell
    bench.look(scan=[reach] * BEAMS, pose=list(pose))
    eye = pose.compose(Pose2(AHEAD, 0.0))
    centres = (np.arange(-round(1.5 / cell), round(1.5 / cell)) + 0.5) * cell
    for x, y in ((x, y) for x in centres for y in centres):
        away, bearing = math.hypot(x - eye.x, y - eye.y), wrap_angle(math.atan2(y - eye.y, x - eye.x) - eye.yaw)
        if away > 0.5 and abs(bearing) < 0.5 * FIELD - 0.1 and abs(away - reach + 0.5 * cell) > 0.006:
            assert (bench.state(x, y) == UNKNOWN) <= (away > reach - 0.5 * cell), (x, y)
            assert (bench.state(x, y) == FREE) <= (away < reach - 0.5 * cell), (x, y)


def test_a_change_is_told_when_something_new_stands_somewhere_and_only_then():
    bench = Bench()
    bench.look()
    (change,) = [sample.value for sample in bench.plan.inbox.drain()]
    assert change.kind == "map"
    bench.look()
    assert bench.plan.inbox.drain() == []


def test_what_is_seen_no_more_is_forgotten_and_what_is_out_of_view_is_kept():
    bench = Bench()
    for _ in range(5):
        bench.look()
    for _ in range(12):
        bench.look(Pose2(0.0, 0.0, math.pi))  # it looks away
    assert bench.state(WALL + 0.01, 0.0) == OCCUPIED
    for _ in range(12):
        bench.look(scan=bench.scan(Pose2(0.0, 0.0), wall=4.0), pose=[0.0, 0.0, 0.0])
    assert bench.state(WALL + 0.01, 0.0) == FREE


def test_a_scan_is_drawn_from_the_pose_of_its_moment():
    bench = Bench()
    bench.clock.advance()
    turned = Pose2(0.0, 0.0, 0.4)
    bench.publisher.publish(0.10, {"scan": bench.scan(Pose2(0.0, 0.0, 0.2))})
    for t, pose in ((0.05, Pose2(0.0, 0.0)), (0.15, turned)):  # half-way between the two
        bench.publisher.publish(t, {"pose": list(pose)})
    bench.analyze.run(0.15)
    points = bench.knowledge.world.occupancy.window((-5.0, -5.0), (5.0, 5.0)).points()
    assert points[:, 0] == pytest.approx(np.full(len(points), WALL), abs=1e-6)


def test_without_a_pose_nothing_is_drawn_and_nothing_told():
    bench = Bench()
    bench.look(scan=bench.scan(Pose2(0.0, 0.0)), pose=[math.nan] * 3)
    assert len(bench.knowledge.world.occupancy.occupied()) == 0
    assert math.isnan(bench.knowledge.signals.value("contact_time", bench.clock.now()))


def test_a_beam_that_says_nan_draws_nothing_and_nobody_tells_of_contact():
    bench = Bench()
    assert math.isnan(bench.look(scan=[math.nan] * BEAMS, pose=[0.0, 0.0, 0.0]))
    assert bench.state(1.0, 0.0) == UNKNOWN


def test_contact_is_told_by_how_the_wheels_turn():
    bench = Bench()
    pose = Pose2(1.25, 0.0)  # 0.5 m before the wall
    assert bench.look(pose) == math.inf
    assert bench.look(pose, speed=1.0) == pytest.approx(0.5, abs=0.06)
    assert bench.look(pose, speed=0.2) == math.inf  # not within what it looks ahead
    assert bench.look(pose, speed=-1.0) == math.inf
    near = Pose2(WALL - 0.27, 0.0)
    assert bench.look(near, turn=1.0) < 0.3  # its corners sweep the wall
    assert math.isnan(bench.look(pose, speed=math.nan))


@pytest.mark.parametrize("late", [0.05, 0.1, 0.2])
@pytest.mark.parametrize(("speed", "turn"), [(1.0, 0.0), (0.8, 0.6), (0.5, -0.3)])
def test_late_readings_change_no_contact_time(late, speed, turn):
    here, twist = Pose2(1.3, 0.3, 0.2), Twist2(speed, turn)
    before = here.compose(along_arc(ORIGIN, twist, -late))
    fresh, found = Bench().look(here, speed, turn), Bench().look(before, speed, turn, late)
    assert found == pytest.approx(fresh, abs=0.051)
    assert 0.3 < found < 1.2


@pytest.mark.parametrize("turn", [-0.8, -1.2])
def test_contact_is_told_of_what_stands_beside_the_way_of_a_turn(turn):
    here, twist = Pose2(WALL - 0.75, 0.0, 0.5 * math.pi), Twist2(1.0, turn)
    times = np.arange(0.0, 1.5, 0.01)
    corners = [(x, y) for x in (-0.25, 0.25) for y in (-0.2, 0.2)]
    on_the_way = [here.compose(along_arc(ORIGIN, twist, t)) for t in times]
    touches = next(
        t for t, at in zip(times, on_the_way, strict=True) if max(at.transform(*c)[0] for c in corners) > WALL
    )
    assert Bench().look(here, 1.0, turn) == pytest.approx(touches, abs=0.08)


def test_contact_comes_sooner_where_a_turn_skids_towards_it():
    beside = Pose2(WALL - 0.25, 0.0, 0.5 * math.pi)
    bench, skidding = Bench(), Bench()
    limits = {"effective_wheel_separation": 0.5, "max_wheel_speed": 2.0, "max_wheel_acceleration": 2.0}
    skidding.knowledge.robot.locomotion = make_locomotion("skid", icr_offset=0.3, **limits)
    rolls, skids = (each.look(beside, speed=1.0, turn=0.5) for each in (bench, skidding))
    assert skids < rolls


def test_recorded_changes_add_up_to_the_map():
    bench, cells, times = Bench(), set(), []
    rng = np.random.default_rng(1)
    for step in range(400):
        if step % 20 == 0:
            place, wall = Pose2(*rng.uniform(-1.0, 1.0, 2), rng.uniform(-0.5, 0.5)), float(rng.uniform(2.0, 4.0))
        bench.look(place, **({"scan": bench.scan(place, wall)} if step % 2 else {"pose": list(place)}))
        for event in [e for e in bench.sink.events if isinstance(e, MapChanged)][len(times) :]:
            assert not cells & {*event.occupied}
            assert {*event.cleared} <= cells
            cells = (cells | {*event.occupied}) - {*event.cleared}
            times.append(event.t)
            assert cells == {(x, y) for y, x in bench.knowledge.world.occupancy.occupied().tolist()}
    assert len(times) > 5
    assert np.diff(times).min() >= 1.0 - 1e-9


def test_what_moves_is_an_obstacle_but_leaves_nothing_in_the_map():
    bench, pose = Bench(), Pose2(1.25, 0.0)
    for _ in range(3):
        bench.look(pose)
    assert bench.state(WALL + 0.01, 0.5) == OCCUPIED
    for step in range(8):  # a part of what the scanner hears is somebody's who walks along the wall
        at = 0.1 * step
        bench.knowledge.world.movers = Movers.of(bench.clock.now(), np.array([[WALL + 0.02, at, 0.0, 2.0]]), 0.15)
        assert bench.look(pose, speed=1.0) < 0.6
        assert bench.state(WALL + 0.01, at + 0.1) == UNKNOWN
    points = bench.knowledge.world.occupancy.points((1.9, -1.0), (2.1, 2.0))
    static = bench.knowledge.world.occupancy.points((1.9, -1.0), (2.1, 2.0), moving=False)
    assert len(points) > len(static) > 0
    assert not (abs(static[:, 1] - 0.75) < 0.1).any()
