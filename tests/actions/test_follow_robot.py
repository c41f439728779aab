"""FollowRobot, on a robot whose wheels do exactly what they are told."""

import math

import numpy as np
import pytest

from rocs_bt.actions import FollowRobot
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.event import ActuatorCommanded
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import TicketState

RUNNING, SUCCEEDED, FAILED = TicketState.RUNNING, TicketState.SUCCEEDED, TicketState.FAILED
KEEP = {"distance": 1.2, "room": 1.0, "safety": 0.8}


class Chase:
    """A rig that follows R2, whose pose and twist stand in Knowledge as an Analyze would keep them."""

    def __init__(self, rig, leader, **parameters):
        self.rig, self.leader = rig, leader
        rig.knowledge.graph.add("R2", "peer", tag=2)
        rig.knowledge.graph.set("R1", length=0.5, width=0.4)
        self.known, self.room = True, {"room_ahead": [1.0] * 5, "room_behind": [1.0] * 5, "room_turned": [0.0] * 12}
        self.tell(Twist2(0.0))
        self.ticket = rig.submit(FollowRobot(leader="R2", **{**KEEP, **parameters}))
        self.distances = []

    def tell(self, twist):
        pose = self.leader if self.known else None
        self.rig.knowledge.graph.set("R2", pose=pose, speed=twist.forward, turn_rate=twist.turn)

    def drive(self, seconds, twist, tell=True):
        for _ in range(round(seconds / 0.05)):
            if self.ticket.state.done:
                return
            if tell:
                self.tell(twist)
            for name, room in self.room.items():
                self.rig.knowledge.signals.write(name, room, self.rig.clock.now())
            self.rig.run()
            self.leader = along_arc(self.leader, twist, 0.05)
            self.distances.append(self.rig.pose.distance(self.leader))

    def speeds(self):
        return [e.values for e in self.rig.of(ActuatorCommanded)]


@pytest.fixture
def chase(rig):
    return Chase(rig, Pose2(1.2, 0.0, 0.0))


def test_keeps_its_distance_on_a_straight_and_stands_when_the_leader_does(chase):
    chase.drive(8.0, Twist2(0.4))
    assert np.abs(np.array(chase.distances[100:]) - 1.2).max() < 0.1
    chase.drive(3.0, Twist2(0.0))
    assert chase.distances[-1] > 1.05
    assert chase.rig.wheels.speeds == [0.0, 0.0]
    assert chase.ticket.state is RUNNING


@pytest.mark.parametrize("turn", [0.3, -0.3])
def test_follows_through_a_curve_as_a_trailer_does(chase, turn):
    chase.drive(12.0, Twist2(0.4, turn))
    assert 1.0 < min(chase.distances) <= max(chase.distances) < 1.35
    assert abs(chase.rig.pose.bearing(chase.leader)) < math.radians(60.0)


def test_catches_up_no_faster_than_its_cruise(rig):
    chase = Chase(rig, Pose2(3.0, 0.0, 0.0), cruise=0.6)
    chase.drive(8.0, Twist2(0.2))
    assert chase.distances[-1] == pytest.approx(1.2, abs=0.08)
    assert max(max(map(abs, s)) for s in chase.speeds()) < 0.66


def test_turns_on_the_spot_first_for_a_leader_behind_it(rig):
    chase = Chase(rig, Pose2(-2.5, 0.1, math.pi))
    chase.room["room_turned"] = [1.0] * 12
    chase.drive(1.0, Twist2(0.0))
    assert math.hypot(rig.pose.x, rig.pose.y) < 0.05
    chase.drive(6.0, Twist2(0.0))
    assert chase.distances[-1] == pytest.approx(1.2, abs=0.12)


def test_goes_back_before_a_leader_that_turns_round(chase):
    chase.drive(6.0, Twist2(0.4))
    chase.leader = chase.leader._replace(yaw=math.pi)
    behind = chase.rig.pose.x
    chase.drive(3.0, Twist2(0.3))
    assert chase.rig.pose.x < behind - 0.5
    assert min(chase.distances) > 0.85


def test_stands_within_the_safety_distance_where_there_is_no_way_off(chase):
    chase.leader, chase.room = Pose2(1.5, 0.0, math.pi), {"room_ahead": [1.0] * 5, "room_behind": [0.0] * 5}
    chase.drive(3.0, Twist2(0.3))
    assert min(chase.distances) < 0.7
    assert abs(chase.rig.pose.x) < 0.1
    assert chase.rig.wheels.speeds == [0.0, 0.0]


def test_turns_aside_where_there_is_no_way_back(chase):
    chase.leader = Pose2(1.8, 0.0, math.pi)
    south = [1.0 if i == 3 else 0.0 for i in range(12)]
    chase.room = {"room_ahead": [0.0] * 5, "room_behind": [0.0] * 5, "room_turned": south}
    chase.drive(3.5, Twist2(0.3))
    assert chase.rig.pose.y < -0.4
    assert abs(chase.rig.pose.x) < 0.1
    assert min(chase.distances) > 0.8


def test_makes_room_first_where_a_corner_would_hit_something_if_it_turned(chase):
    chase.leader = Pose2(-2.2, 0.4, 0.0)  # behind it
    chase.room = {"room_ahead": [0.0] * 5, "room_behind": [0.0, 0.0, 0.5, 0.0, 0.0], "free_turn": [0.4, 0.4]}
    chase.drive(2.0, Twist2(0.0))
    assert abs(chase.rig.pose.yaw) < 0.05
    assert chase.rig.pose.x < -0.2
    chase.room |= {"free_turn": [math.pi, math.pi], "room_turned": [1.0] * 12}
    chase.drive(2.0, Twist2(0.0))
    assert abs(chase.rig.pose.bearing(chase.leader)) < math.radians(60.0)


def test_does_not_turn_where_it_does_not_know_what_its_corners_sweep(chase):
    chase.leader = Pose2(-2.2, 0.4, 0.0)
    chase.room = {"room_ahead": [0.0] * 5, "room_behind": [0.0] * 5, "room_turned": [0.0] * 12}
    chase.drive(2.0, Twist2(0.0))
    assert abs(chase.rig.pose.yaw) < 0.05


def test_turns_no_farther_than_its_corners_find_free(chase):
    chase.leader = Pose2(-2.2, 0.0, 0.0)
    chase.room = {"room_ahead": [0.0] * 5, "room_behind": [0.0] * 5, "room_turned": [0.0] * 12, "free_turn": [0.3, 0.3]}
    chase.drive(2.0, Twist2(0.0))
    assert abs(chase.rig.pose.yaw) < 0.05
    chase.room["free_turn"] = [0.0, 0.0]
    chase.known = False  # nor does it look round
    chase.drive(2.0, Twist2(0.0))
    assert abs(chase.rig.pose.yaw) < 0.05


def test_who_does_not_know_the_ground_waits(chase):
    chase.leader, chase.room = Pose2(1.5, 0.0, math.pi), {}
    chase.drive(3.0, Twist2(0.3))
    assert abs(chase.rig.pose.x) < 0.02


def test_goes_on_after_a_prediction_and_fails_when_nobody_knows(chase):
    chase.drive(5.0, Twist2(0.4))
    chase.drive(1.5, Twist2(0.4), tell=False)  # out of view: Knowledge predicts
    assert chase.ticket.state is RUNNING
    assert chase.distances[-1] == pytest.approx(1.2, abs=0.1)
    chase.known = False
    turned, before = 0.0, chase.rig.pose
    for _ in range(200):
        chase.drive(0.05, Twist2(0.0))
        turned += math.remainder(chase.rig.pose.yaw - before.yaw, math.tau)
        before = chase.rig.pose
    assert abs(turned) == pytest.approx(math.tau, abs=0.1)
    assert chase.ticket.state is FAILED
    assert chase.ticket.failure.reason is Reason.LOST_LEADER
    assert "'R2' was not found in a search of 8.3 s; its last known position is x = " in str(chase.ticket.failure)


def test_a_leader_that_is_found_while_it_looks_round_is_followed(chase):
    chase.known = False
    chase.drive(3.0, Twist2(0.0))
    chase.known, chase.leader = True, Pose2(0.0, 2.5, 1.0)
    chase.drive(8.0, Twist2(0.0))
    assert chase.ticket.state is RUNNING
    assert chase.distances[-1] == pytest.approx(1.2, abs=0.12)


def test_it_is_done_when_its_leader_has_rested(rig):
    chase = Chase(rig, Pose2(1.2, 0.0, 0.0), rest=3.0)
    chase.drive(2.0, Twist2(0.4))
    chase.drive(2.5, Twist2(0.0))
    assert chase.ticket.state is RUNNING
    chase.drive(2.0, Twist2(0.0))
    assert chase.ticket.state is SUCCEEDED
    assert rig.knowledge.graph.related("R1", "follows") == []


def test_knowledge_holds_whom_it_follows(chase):
    chase.drive(0.1, Twist2(0.0))
    graph = chase.rig.knowledge.graph
    assert graph.edge("R1", "follows", "R2")["distance"] == 1.2
    chase.rig.pipeline.cancel(chase.ticket, by="test")
    chase.rig.run()
    assert graph.related("R1", "follows") == []


def test_it_waits_for_nobody_in_its_way_but_goes_round(rig):
    chase = Chase(rig, Pose2(3.0, 0.0, 0.0))
    rig.knowledge.graph.add("R4", "peer", pose=Pose2(1.2, 0.05), speed=0.0, turn_rate=0.0)
    away = []
    for _ in range(240):
        chase.drive(0.05, Twist2(0.0))
        away.append(rig.pose.distance(Pose2(1.2, 0.05)))
    assert chase.distances[-1] < 1.55
    assert min(away) > 0.7


def test_it_makes_room_for_somebody_who_crosses_its_way(chase):
    chase.drive(5.0, Twist2(0.4))
    other, away = Pose2(chase.rig.pose.x + 0.4, chase.rig.pose.y + 1.3, -math.pi / 2.0), []
    chase.rig.knowledge.graph.add("R4", "peer", pose=other, speed=0.2, turn_rate=0.0)
    for _ in range(160):
        other = along_arc(other, Twist2(0.2), 0.05)
        chase.rig.knowledge.graph.set("R4", pose=other)
        chase.drive(0.05, Twist2(0.0))
        away.append(chase.rig.pose.distance(other))
    assert min(away) > 0.6


def test_an_unknown_leader_says_so(rig):
    rig.knowledge.graph.add("R2", "peer", tag=2)
    nobody = rig.submit(FollowRobot(leader="R9"))
    rig.run()
    assert nobody.failure.reason is Reason.NO_GOAL
    assert "no other robot is named 'R9'. The world has: R2." in nobody.failure.evidence


def test_distances_that_do_not_ascend_are_a_fault():
    with pytest.raises(InputError, match=r"must ascend, found 0\.8, 1\.1 and 1 m"):
        FollowRobot(leader="R2", distance=1.0, room=1.1)
