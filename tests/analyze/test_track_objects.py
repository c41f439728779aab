"""TrackObjects: things that a sensor shows appear in the graph, move, and vanish again."""

import math

import numpy as np
import pytest

from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE
from rocs_bt.control.footprint import Footprint
from rocs_bt.event import Change, KnowledgeChanged, ListSink
from rocs_bt.interfaces.channel import Stamped
from rocs_bt.knowledge import Knowledge

from .casting import cast

FIELD = math.radians(270.0)


class World:
    """A robot with a scanner, round things around it, and its analyser."""

    def __init__(self, *things, beams=361, scanner=True, body=None, sideways=False, **parameters):
        self.clock, self.sink, self.changed = SimulatedClock(0.05), ListSink(), ListSink()
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        look = {"rays": beams, "span": FIELD, "mount": Pose2(0.0, 0.0, 0.0)} if scanner else {}
        self.knowledge.graph.add("lidar", "sensor", signal="scan", **look)
        self.knowledge.graph.relate("R2", "has_sensor", "lidar")
        self.knowledge.graph.set("R2", **(body or {}))
        given = {"ranges": "scan", "half_angle": math.radians(0.5), "max_range": 6.0} | parameters
        self.analyze = ANALYZERS["TrackObjects"]("seen", self.knowledge, self.changed, **given)
        own = [Signal("scan", beams, (LENGTH,)), Signal("speed", 1, (SPEED,)), Signal("turn_rate", 1, (TURN_RATE,))]
        own += [Signal("lateral_speed", 1, (SPEED,))] if sideways else []
        for signal in [*self.analyze.signals(), *own]:
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()
        self.speed = self.lateral_speed = self.turn_rate = 0.0
        self.late, self.readings = 0, []  # [periods] delay of all readings
        self.pose, self.things, self.beams, self.changes = Pose2(0.0, 0.0, 0.0), list(things), beams, []

    def steps(self, count, *, blind=False, moving=(0.0, 0.0), scan=True, twist=None):
        for _ in range(count):
            self.clock.advance()
            if twist is not None:
                self.pose = self.pose.compose(along_arc(Pose2(0.0, 0.0), twist, 0.05))
            self.things = [(x + 0.05 * moving[0], y + 0.05 * moving[1], r) for x, y, r in self.things]
            bearings = [-0.5 * FIELD + i * FIELD / (self.beams - 1) for i in range(self.beams)]
            ranges = [math.nan] * self.beams if blind else cast(self.pose, bearings, self.things, 6.0)
            t = self.clock.now()
            speeds = {"speed": self.speed, "lateral_speed": self.lateral_speed, "turn_rate": self.turn_rate}
            known = {name: [value] for name, value in speeds.items() if name in self.knowledge.signals}
            self.knowledge.signals.update(known, t)
            samples = [Stamped(t, "pose", {"pose": list(self.pose)})]
            samples = [Stamped(t, "scan", {"scan": ranges}), *samples] if scan else samples
            self.readings.append(samples)
            for sample in self.readings[-1 - self.late] if len(self.readings) > self.late else []:
                self.analyze.inbox.put(sample)
            before = len(self.changed.events)
            self.analyze.run(t)
            self.changes += [(e.kind, e.subject) for e in self.changed.events[before:] if isinstance(e, Change)]
        return self

    def signal(self, name):
        return self.knowledge.signals.value(name, self.clock.now())

    @property
    def objects(self):
        graph = self.knowledge.graph
        return {name: graph.attributes(name) for name in graph.nodes("object")}


def test_a_thing_appears_with_its_place_its_size_and_how_surely():
    world = World((2.0, 0.5, 0.15)).steps(16)
    assert world.changes == [("appeared", "seen_1")]
    (known,) = world.objects.values()
    assert known["pose"].distance(Pose2(2.0, 0.5)) < 0.08
    assert known["radius"] == pytest.approx(0.15, abs=0.06)
    assert known["existence"] > 0.8
    assert known["covariance"][0] > 0.0
    assert known["moves"] is False
    assert 0.5 < known["seen"] <= 0.8
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


BODY = {"length": 0.5, "width": 0.4}


def test_what_moves_is_a_mover_and_what_does_not_is_none():
    world = World((2.0, -1.0, 0.2), static_objects=False).steps(20)
    assert len(world.knowledge.world.movers) == 0
    assert world.objects == {}
    world.steps(40, moving=(0.0, 0.6))
    movers = world.knowledge.world.movers
    assert movers.ids.tolist() == [1]
    assert movers.t == world.clock.now()
    assert movers.mean[0] == pytest.approx([2.0, 0.2, 0.0, 0.6], abs=0.08)
    assert movers.radius == pytest.approx([0.2], abs=0.03)
    assert movers.moves.tolist() == [True]
    assert list(world.objects) == ["seen_1"]
    before = movers.mean.copy()
    world.steps(5, moving=(0.0, 0.6))
    assert world.knowledge.world.movers is not movers
    assert (movers.mean == before).all()


def test_one_out_of_view_is_a_mover_for_two_seconds():
    world = World((2.0, -1.0, 0.2)).steps(40, moving=(0.0, 0.6))
    world.pose = Pose2(0.0, 0.0, math.pi)
    world.steps(38)
    assert world.knowledge.world.movers.ids.tolist() == [1]
    world.steps(4)
    assert len(world.knowledge.world.movers) == 0


def test_the_graph_is_written_twice_a_second():
    world = World((4.0, -2.0, 0.2)).steps(20, moving=(0.0, 0.6))
    before = len([e for e in world.sink.events if isinstance(e, KnowledgeChanged)])
    world.steps(60, moving=(0.0, 0.6))
    assert len([e for e in world.sink.events if isinstance(e, KnowledgeChanged)]) - before <= 7 * 7


def test_the_signals_say_when_and_how_near_what_moves_will_be():
    world = World((2.0, 1.4, 0.2), body=BODY).steps(40, moving=(0.0, -0.4))  # now at 0.6 m to the left
    world.speed = 0.9
    world.steps(1, moving=(0.0, -0.4))
    # The robot's front is at the mover's near side after 1.55 / 0.9 = 1.72 s; the mover is then at its middle.
    assert world.signal("collision_time") == pytest.approx(1.75, abs=0.1)
    assert world.signal("predicted_clearance") < 0.0
    world.speed = 0.0
    world.steps(1, moving=(0.0, -0.4))
    assert world.signal("collision_time") == math.inf
    assert world.signal("predicted_clearance") == pytest.approx(1.55, abs=0.15)
    world.steps(1, blind=True)
    assert math.isnan(world.signal("collision_time"))


def test_the_signals_are_as_of_now_while_scans_are_lost():
    world = World((2.0, 1.4, 0.2), body=BODY).steps(40, moving=(0.0, -0.4))
    world.speed = 0.9
    world.steps(1, moving=(0.0, -0.4))
    at_scan = world.signal("collision_time")
    seen = []
    for _ in range(3):  # a robot that drives as announced, without a scan
        world.pose = Pose2(world.pose.x + 0.045, 0.0, 0.0)
        seen.append(world.steps(1, moving=(0.0, -0.4), scan=False).signal("collision_time"))
    assert seen == pytest.approx([at_scan - 0.05 * late for late in (1, 2, 3)], abs=0.051)
    assert seen == sorted(seen, reverse=True)
    assert seen[-1] < at_scan - 0.09


def collision(twist, late):
    """Signal `collision_time` with readings that are some periods late, head-on to a mover; and the truth [s]."""
    walk, until = (-0.5, 0.1), 1.8
    there = along_arc(Pose2(0.0, 0.0), twist, 12 * 0.05 + until)
    world = World((there.x - walk[0] * (42 * 0.05 + until), there.y - walk[1] * (42 * 0.05 + until), 0.2), body=BODY)
    world.late = late
    world.steps(30, moving=walk)
    world.speed, world.turn_rate = twist.forward, twist.turn
    world.steps(12, moving=walk, twist=twist)
    (x, y, radius), times = world.things[0], np.arange(0.0, 3.0, 0.005)
    poses = np.array([world.pose.compose(along_arc(Pose2(0.0, 0.0), twist, float(t))) for t in times])
    dx, dy = x + walk[0] * times - poses[:, 0], y + walk[1] * times - poses[:, 1]
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    touches = Footprint(**BODY).gap(c * dx + s * dy, c * dy - s * dx) < radius
    return world.signal("collision_time"), float(times[touches.argmax()])


@pytest.mark.parametrize("twist", [Twist2(1.5, 0.0), Twist2(1.0, 0.25), Twist2(0.4, -0.1)], ids=str)
def test_late_scans_and_poses_change_no_collision_time(twist):
    fresh, expected = collision(twist, 0)
    assert fresh == pytest.approx(expected, abs=0.08)
    assert [collision(twist, late)[0] for late in (1, 2, 4)] == pytest.approx([fresh] * 3, abs=0.051)


def test_a_second_tracker_on_sonars_leaves_the_signals_to_that_of_the_scanner():
    world = World((2.0, 1.4, 0.2), body=BODY)
    ring = ANALYZERS["TrackObjects"]("ring", world.knowledge, world.changed, ranges="sonar", mounts=[[0.2, 0.0, 0.0]])
    assert ring.signals() == []
    for blind in (False, True):
        world.steps(40 if not blind else 1, moving=(0.0, -0.4), blind=blind)
        before, t = world.signal("collision_time"), world.clock.now()
        for sample in (Stamped(t, "sonar", {"sonar": [math.inf]}), Stamped(t, "pose", {"pose": list(world.pose)})):
            ring.inbox.put(sample)
        ring.run(t)
        assert world.signal("collision_time") == pytest.approx(before, nan_ok=True)
        assert math.isnan(before) is blind


def test_motion_to_the_side_counts():
    world = World((0.0, 3.0, 0.2), body=BODY, sideways=True).steps(40, moving=(0.0, -0.4))  # now at 2.2 m to the left
    world.lateral_speed = 0.6
    world.steps(1, moving=(0.0, -0.4))
    # The hull reaches the mover after (2.2 - 0.2 - 0.2) / (0.6 + 0.4) = 1.8 s.
    assert world.signal("collision_time") == pytest.approx(1.8, abs=0.25)  # 4.5 s without it
    world.lateral_speed = math.nan
    world.steps(1, moving=(0.0, -0.4))
    assert math.isnan(world.signal("collision_time"))


def test_without_movers_nothing_is_near():
    world = World((2.0, 0.5, 0.15), body=BODY).steps(20)
    assert world.signal("collision_time") == world.signal("predicted_clearance") == math.inf


def test_a_sonar_ring_claims_nothing_about_what_moves():
    world = World(mounts=[[0.2, 0.0, 0.0]], body=BODY).steps(1)
    assert world.knowledge.world.movers is None
    assert "collision_time" not in world.knowledge.signals


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
    before = len(world.sink.events)
    world.steps(100)
    written = [e.name for e in world.sink.events[before:] if isinstance(e, KnowledgeChanged)]
    assert written.count("seen") == 5  # once a second, to say that it is still there


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
