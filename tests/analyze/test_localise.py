"""Localise: a pose from odometry and fixes, and none from what is broken."""

import math

import numpy as np
import pytest

from rocs_bt.analyze import Localise, PassPosition
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.event import ListSink, SignalsWritten
from rocs_bt.interfaces.channel import AnalyzeSubscriber, Publisher
from rocs_bt.knowledge import Knowledge

DRIVE = make_locomotion("differential", wheel_separation=0.33, max_wheel_speed=1.2, max_wheel_acceleration=1.5)
PERIOD = 0.05


class Bench:
    """One Localise, and the two ends of its wires."""

    def __init__(self, **parameters):
        self.clock, self.sink = SimulatedClock(PERIOD), ListSink()
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        self.knowledge.robot.locomotion = DRIVE
        self.analyze = Localise("localise", self.knowledge, self.sink, **parameters)
        for signal in self.analyze.signals():
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()
        self.plan = AnalyzeSubscriber()
        self.analyze.attach(self.plan)
        self.publisher = Publisher("monitor")
        self.publisher.connect(self.analyze.inbox)
        self.travel = np.zeros(2)

    def say(self, *samples):
        """One control period."""
        self.clock.advance()
        for sample in samples:
            self.publisher.publish(self.clock.now(), sample)
        self.analyze.run(self.clock.now())
        return self.knowledge.robot.pose()

    def roll(self, left, right):
        self.travel = self.travel + np.array([left, right])
        return {"wheel_travel": self.travel.tolist()}


FIX = {"fix": [1.0, 2.0], "compass": [3.1]}


def begun(**parameters):
    bench = Bench(**parameters)
    bench.say(bench.roll(5.0, 5.0), FIX)
    return bench


def test_it_begins_with_a_position_and_a_heading_together():
    bench = Bench()
    for incomplete in ({"fix": [1.0, 2.0]}, {"compass": [0.3]}, {"fix": [math.nan, 2.0], "compass": [0.3]}):
        assert math.isnan(bench.say(bench.roll(0.1, 0.1), incomplete).x)
    assert bench.say(bench.roll(0.1, 0.1), FIX) == pytest.approx((1.0, 2.0, 3.1))
    assert [s.value.kind for s in bench.plan.inbox.drain()] == ["located"]


def test_between_fixes_it_goes_on_by_the_wheels_over_the_seam_at_pi():
    bench, pose = begun(), Pose2(1.0, 2.0, 3.1)
    for _ in range(10):
        found = bench.say(bench.roll(0.02, 0.03))
        pose = along_arc(pose, Twist2(0.025, 0.01 / 0.33), 1.0)
        assert found == pytest.approx(pose, abs=1e-9)
    assert found.yaw < 0.0


@pytest.mark.parametrize("first", ["wheels", "fix"])
def test_a_fix_meets_the_pose_of_its_own_time_whichever_monitor_spoke_first(first):
    bench = begun(travel_noise=0.0, slip_noise=0.0, turn_noise=0.0, drift_noise=0.0)
    ahead = along_arc(Pose2(1.0, 2.0, 3.1), Twist2(0.5), 1.0)
    rolled, fix = bench.roll(0.5, 0.5), {"fix": [ahead.x, ahead.y], "compass": [3.1]}
    samples = (rolled, fix) if first == "wheels" else (fix, rolled)
    assert bench.say(*samples) == pytest.approx(ahead, abs=1e-9)


def test_a_reading_that_is_missed_or_broken_costs_nothing():
    whole, holey = begun(), begun()
    for i in range(4):
        end = whole.say(whole.roll(0.02, 0.02))
        rolled = holey.roll(0.02, 0.02)
        other = holey.say(*([] if i == 1 else [{"wheel_travel": [math.nan, 1.0]}] if i == 2 else [rolled]))
    assert other == pytest.approx(end, abs=1e-9)


def test_fixes_that_are_broken_or_dropped_leave_it_as_it_was_but_less_sure():
    bench, other = begun(), begun()
    for _ in range(20):
        a = bench.say(bench.roll(0.02, 0.02), {"fix": [math.nan, math.nan], "compass": [math.nan]})
        b = other.say(other.roll(0.02, 0.02))
    assert a == b
    spread = bench.knowledge.signals.value("pose_spread", bench.clock.now())
    bench.say(bench.roll(0.0, 0.0), {"fix": list(a[:2]), "compass": [a.yaw]})
    assert bench.knowledge.signals.value("pose_spread", bench.clock.now()) < spread


def test_without_the_odometer_the_pose_goes_stale_and_comes_back_less_sure():
    bench = begun()
    before = bench.say(bench.roll(0.02, 0.02))
    spread = bench.knowledge.signals.value("pose_spread", bench.clock.now())
    poses = [bench.say({"fix": [1.0, 2.0]}) for _ in range(5)]
    assert not math.isnan(poses[1].x)
    assert math.isnan(poses[-1].x)
    after = bench.say(bench.roll(0.3, 0.3))
    assert before.distance(after) == pytest.approx(0.3, abs=0.05)
    assert bench.knowledge.signals.value("pose_spread", bench.clock.now()) > 3.0 * spread


def test_the_turn_is_the_gyros_where_there_is_one_and_the_wheels_while_it_is_silent():
    bench, yaw = begun(), 3.1
    turns = []
    for rate in ([0.2], [math.nan], None):
        said = bench.roll(-0.0165, 0.0165)  # by the wheels 0.1 rad
        found = bench.say(said if rate is None else {**said, "gyro_rate": rate}).yaw
        turns.append(math.remainder(found - yaw, math.tau))
        yaw = found
    assert turns == pytest.approx([0.2 * PERIOD, 0.1, 0.1], abs=1e-6)


def test_it_says_how_far_the_pursued_goal_is_and_how_sure_it_is():
    bench = begun()
    bench.say(bench.roll(0.0, 0.0))
    now = bench.clock.now
    assert bench.knowledge.signals.value("goal_distance", now()) == math.inf
    bench.knowledge.world.place("dock", Pose2(1.0, 5.0), kind="goal")
    bench.knowledge.world.pursue("dock")
    bench.say(bench.roll(0.0, 0.0))
    assert bench.knowledge.signals.value("goal_distance", now()) == pytest.approx(3.0)
    covariance = bench.knowledge.signals.read("pose_covariance", now())
    assert covariance[[0, 3]] == pytest.approx([0.05**2] * 2, rel=0.01)
    written = [e for e in bench.sink.events if isinstance(e, SignalsWritten)]
    assert written[-1].monitor == "localise"
    assert written[-1].values["pose"] == pytest.approx(list(bench.knowledge.robot.pose()))


def test_others_read_what_it_wrote_from_knowledge():
    bench = begun()
    bench.knowledge.world.place("dock", Pose2(1.0, 2.0), kind="goal", tolerance=0.1)
    arrivals = PassPosition("arrivals", bench.knowledge, bench.sink)
    arrivals.from_knowledge = ("pose",)
    arrivals.attach(bench.plan)
    bench.publisher.connect(arrivals.inbox)
    bench.plan.inbox.drain()
    bench.say(bench.roll(0.0, 0.0))
    arrivals.run(bench.clock.now())
    assert [(s.value.kind, s.value.subject) for s in bench.plan.inbox.drain()] == [("arrived", "dock")]
