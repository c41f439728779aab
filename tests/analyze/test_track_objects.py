"""TrackObjects: things that a sensor shows appear in the graph, move, and vanish again."""

import math

import pytest

from rocs_bt.analyze import ANALYZERS
from rocs_bt.channel import Stamped
from rocs_bt.clock import SimulatedClock
from rocs_bt.errors import InputError
from rocs_bt.event import KnowledgeChanged, ListSink
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Knowledge

from .casting import cast

FIELD = math.radians(270.0)


class World:
    """A robot with a scanner, round things around it, and its analyser."""

    def __init__(self, *things, beams=361, scanner=True, **parameters):
        self.clock, self.sink = SimulatedClock(0.05), ListSink()
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        look = {"rays": beams, "span": FIELD, "mount": Pose2(0.0, 0.0, 0.0)} if scanner else {}
        self.knowledge.graph.add("lidar", "sensor", signal="scan", **look)
        self.knowledge.graph.relate("R2", "has_sensor", "lidar")
        given = {"ranges": "scan", "half_angle": math.radians(0.5), "max_range": 6.0} | parameters
        self.analyze = ANALYZERS["TrackObjects"]("seen", self.knowledge, ListSink(), **given)
        self.pose, self.things, self.beams, self.changes = Pose2(0.0, 0.0, 0.0), list(things), beams, []

    def steps(self, count, *, blind=False, moving=(0.0, 0.0)):
        for _ in range(count):
            self.clock.advance()
            self.things = [(x + 0.05 * moving[0], y + 0.05 * moving[1], r) for x, y, r in self.things]
            bearings = [-0.5 * FIELD + i * FIELD / (self.beams - 1) for i in range(self.beams)]
            ranges = [math.nan] * self.beams if blind else cast(self.pose, bearings, self.things, 6.0)
            t = self.clock.now()
            samples = [Stamped(t, "scan", {"scan": ranges}), Stamped(t, "pose", {"pose": list(self.pose)})]
            self.changes += [(c.kind, c.subject) for c in self.analyze.process(samples)]
        return self

    @property
    def objects(self):
        graph = self.knowledge.graph
        return {name: graph.attributes(name) for name in graph.nodes("object")}


def test_a_thing_appears_with_its_place_its_size_and_how_surely():
    world = World((2.0, 0.5, 0.15)).steps(10)
    assert world.changes == [("appeared", "seen_1")]
    (known,) = world.objects.values()
    assert known["pose"].distance(Pose2(2.0, 0.5)) < 0.08
    assert known["radius"] == pytest.approx(0.15, abs=0.06)
    assert known["existence"] > 0.8
    assert known["covariance"][0] > 0.0
    assert known["moves"] is False
    assert 0.0 < known["seen"] <= 0.5
    assert world.knowledge.graph.related("seen_1", "sensed_by") == ["lidar"]


def test_one_that_is_taken_away_vanishes():
    world = World((2.0, 0.5, 0.15)).steps(10)
    world.things = []
    world.steps(10)
    assert world.changes[-1] == ("vanished", "seen_1")
    assert world.objects == {}


def test_one_behind_the_robot_is_believed_in_for_a_while():
    world = World((2.0, 0.0, 0.15), half_life=5.0).steps(10)
    world.pose = Pose2(0.0, 0.0, math.pi)
    world.steps(60)
    assert list(world.objects) == ["seen_1"]
    world.steps(300)
    assert world.objects == {}


def test_one_that_moves_is_told_so_with_its_heading_and_speed():
    world = World((2.0, -1.0, 0.2)).steps(60, moving=(0.0, 0.6))
    (known,) = world.objects.values()
    assert known["moves"] is True
    assert known["speed"] == pytest.approx(0.6, abs=0.12)
    assert known["pose"].yaw == pytest.approx(math.pi / 2, abs=0.2)
    assert world.changes == [("appeared", "seen_1")], "it is one thing all the time"


def test_a_robot_that_sees_nothing_learns_nothing():
    world = World((2.0, 0.5, 0.15)).steps(10)
    before = world.objects["seen_1"]["pose"]
    world.steps(20, blind=True)
    assert world.objects["seen_1"]["pose"] == before


def test_a_peer_is_left_to_the_robot_sensor():
    world = World((2.0, 0.5, 0.2))
    world.knowledge.graph.add("R1", "peer", tag=1, pose=Pose2(2.1, 0.5))
    assert world.steps(10).objects == {}


def test_what_is_as_it_was_is_not_written_again():
    world = World((2.0, 0.5, 0.15)).steps(40)
    assert world.objects["seen_1"]["seen"] > 0.9
    before = len([e for e in world.sink.events if isinstance(e, KnowledgeChanged)])
    world.steps(100)
    after = len([e for e in world.sink.events if isinstance(e, KnowledgeChanged)])
    assert after - before < 40


def test_somebody_else_may_remove_an_object_and_it_comes_back_while_it_is_seen():
    world = World((2.0, 0.5, 0.15)).steps(10)
    world.knowledge.graph.remove("seen_1")
    assert list(world.steps(2).objects) == ["seen_1"]


def test_a_ring_of_sonars_does_as_well():
    mounts = [[0.2 * math.cos(a), 0.2 * math.sin(a), a] for a in (math.radians(22.5 * i) for i in range(16))]
    world = World((0.9, 0.2, 0.1), mounts=mounts, half_angle=math.radians(12.0), ranges="sonar", max_range=1.5)
    for _ in range(12):
        world.clock.advance()
        cones = [[bearing + d for d in (-0.2, -0.1, 0.0, 0.1, 0.2)] for _, _, bearing in mounts]
        eyes = [Pose2(*world.pose.transform(x, y), 0.0) for x, y, _ in mounts]
        ranges = [min(cast(eye, cone, world.things, 1.5)) for eye, cone in zip(eyes, cones, strict=True)]
        t = world.clock.now()
        samples = [Stamped(t, "sonar", {"sonar": ranges}), Stamped(t, "pose", {"pose": list(world.pose)})]
        list(world.analyze.process(samples))
    (known,) = world.objects.values()
    assert known["pose"].distance(Pose2(0.9, 0.2)) < 0.2


@pytest.mark.parametrize("wrong", [{"scanner": False}, {"half_life": -1.0}, {"max_range": 0.0}])
def test_what_makes_no_sense_is_refused(wrong):
    with pytest.raises(InputError):
        World(**wrong)
