"""PeerAnalyze: peers seen, held through short occlusions, given up after long ones."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rocs_bt.analyze import PeerAnalyze
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.event import ListSink
from rocs_bt.interfaces.channel import Stamped
from rocs_bt.knowledge import Knowledge

NOBODY = (0.0, math.inf, 0.0)


class World:
    """R3 at a pose, R2 driving an arc; an analyser that hears of both."""

    def __init__(self, twist=None, **parameters):
        self.clock = SimulatedClock(0.05)
        self.knowledge = Knowledge("R3", self.clock, ListSink())
        self.knowledge.graph.add("R2", "peer", tag=2)
        self.analyze = PeerAnalyze("peers", self.knowledge, ListSink(), **parameters)
        self.here, self.leader, self.twist = Pose2(0.0, 0.0, 0.2), Pose2(1.0, 0.0, 0.0), twist or Twist2(0.4)
        self.rng = np.random.default_rng(1)
        self.changes = []

    def step(self, *, seen=True, tag=2.0, blind=False, lost=False):
        self.clock.advance()
        self.leader = along_arc(self.leader, self.twist, 0.05)
        slot = NOBODY
        if seen:
            noise = self.rng.normal(0.0, [0.03, 0.017])
            slot = (tag, self.here.distance(self.leader) + noise[0], self.here.bearing(self.leader) + noise[1])
        if blind:
            slot = (math.nan,) * 3
        t, signals = self.clock.now(), {}
        for name, value in zip(("peer_tag", "peer_range", "peer_bearing"), slot, strict=True):
            signals[name] = [value]
        pose = [math.nan] * 3 if lost else list(self.here)
        samples = [Stamped(t, "peers", signals), Stamped(t, "pose", {"pose": pose})]
        found = [(c.kind, c.subject) for c in self.analyze.process(samples)]
        self.changes += found
        return found

    def steps(self, count, **how):
        for _ in range(count):
            self.step(**how)

    def get(self, attribute):
        return self.knowledge.graph.get("R2", attribute)


@pytest.fixture
def world():
    return World()


def test_a_peer_that_comes_into_view_is_placed_and_told_once(world):
    assert world.step() == [("seen", "R2")]
    world.steps(40)
    assert world.changes == [("seen", "R2")]
    assert world.get("pose").distance(world.leader) < 0.06
    assert world.get("speed") == pytest.approx(0.4, abs=0.12)
    assert abs(world.get("pose").yaw) < 0.3
    assert 0.0 < world.get("spread") < 0.05
    assert world.knowledge.graph.related("R3", "sees") == ["R2"]


def test_how_sure_it_is_of_a_peer_is_told_anew_only_where_that_changed(world):
    told = []
    world.knowledge.graph.subscribe(lambda change: told.append((change.name, change.value)), node="R2")
    world.steps(200)
    spreads = [value for name, value in told if name == "spread"]
    assert sum(name == "pose" for name, _ in told) == 200
    assert 2 <= len(spreads) < 50
    assert all(abs(b - a) > 0.1 * a for a, b in pairwise(spreads))
    world.steps(20, seen=False)
    assert world.get("spread") > 2.0 * spreads[-1]  # nobody looked: less and less sure


def test_what_somebody_else_told_of_a_peer_gives_way_to_what_is_seen(world):
    world.steps(40)
    own = world.get("spread")
    world.step(seen=False)
    world.knowledge.graph.set("R2", pose=Pose2(9.0, 9.0), spread=5.0)
    world.step(seen=False)
    assert world.get("spread") == 5.0
    world.steps(10)
    assert world.get("spread") == pytest.approx(own, rel=0.3)


def test_knowledge_predicts_the_way_of_a_peer():
    world = World(Twist2(0.4, 0.5))
    world.steps(80)
    now = world.clock.now()
    for ahead in (0.0, 0.5, 1.0):
        wanted = along_arc(world.leader, world.twist, ahead)
        assert world.knowledge.world.predicted("R2", now + ahead).distance(wanted) < 0.05 + 0.15 * ahead


def test_a_short_occlusion_is_held_by_prediction_and_a_long_one_given_up(world):
    world.steps(40)
    world.steps(8, seen=False)
    assert world.changes == [("seen", "R2")]
    world.steps(12, seen=False)  # a second in all
    assert world.changes[1:] == [("lost", "R2")]
    assert world.get("pose").distance(world.leader) < 0.2
    assert world.knowledge.graph.related("R3", "sees") == []
    world.step()
    assert world.changes[2:] == [("seen", "R2")]
    world.steps(61, seen=False)
    assert world.changes[3:] == [("lost", "R2"), ("given up", "R2")]
    assert world.get("pose") is None
    assert world.knowledge.world.predicted("R2", world.clock.now()) is None
    world.step()
    assert world.changes[5:] == [("seen", "R2")]


@pytest.mark.parametrize("fault", [{"blind": True}, {"lost": True}])
def test_invalid_readings_or_no_pose_are_as_if_nobody_was_seen(world, fault):
    world.steps(40)
    world.steps(62, **fault)
    assert world.changes == [("seen", "R2"), ("lost", "R2"), ("given up", "R2")]


SUMMIT = {"range_noise": 0.04, "bearing_noise": math.radians(1.5)}  # as robots/summit_xl has them


@pytest.mark.parametrize("seed", range(4))
def test_a_standing_peer_has_no_speed_and_keeps_its_heading(seed):
    world = World(Twist2(0.4), **SUMMIT)
    world.rng = np.random.default_rng(seed)
    world.steps(40)
    world.twist = Twist2(0.0)
    world.steps(30)
    heading = world.get("pose").yaw
    assert abs(heading) < 0.8
    moving = 0
    for _ in range(600):
        world.step()
        moving += world.get("speed") > 0.0
    assert moving <= 6, "half a minute, of which noise makes it seem to move for three tenths of a second at most"
    assert moving or world.get("pose").yaw == heading


@pytest.mark.parametrize(("speed", "latest"), [(0.5, 0.5), (0.3, 0.7), (0.2, 1.0)])
def test_a_peer_that_begins_to_move_is_noticed_and_not_lost_again(speed, latest):
    for seed in range(4):
        world = World(Twist2(0.0), **SUMMIT)
        world.rng = np.random.default_rng(seed)
        world.steps(60)
        world.twist = Twist2(speed)
        world.steps(round(latest / 0.05))
        seen = []
        for _ in range(60):
            world.step()
            seen.append(world.get("speed"))
        assert sum(v > 0.0 for v in seen) >= 58
        assert float(np.mean(seen)) == pytest.approx(speed, abs=0.08)


def test_a_stranger_gets_a_name_of_its_own(world):
    assert world.step(tag=7.0) == [("seen", "robot 7")]
    assert world.knowledge.world.peers() == ["R2", "robot 7"]


def test_a_peer_is_lost_before_it_is_given_up():
    with pytest.raises(InputError, match="lost_after of 'peers' must be below give_up_after, found 2 s and 2 s"):
        World(lost_after=2.0, give_up_after=2.0)
