"""Dock: a staging pose, a turn, a slow way in; askew is backed out of; whoever cannot get in says why."""

import math
from itertools import pairwise

import pytest

from rocs_bt.actions import Dock
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.event import AtomicStarted
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import TicketState

DOCK = Pose2(2.0, 1.0, math.radians(90.0))


@pytest.fixture
def docked(rig):
    def run(limit=3000, **parameters):
        rig.knowledge.world.place("bay", DOCK, kind="goal")
        ticket = rig.submit(Dock(goal="bay", **parameters))
        rig.finish(ticket, limit)
        return ticket

    return run


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (2.0, 0.9, 0.0), (4.0, 3.0, 200.0), (2.0, 0.4, 90.0)])
def test_it_stands_in_the_dock_wherever_it_began(rig, docked, start):
    rig.put(*start)
    assert docked().state is TicketState.SUCCEEDED
    assert rig.pose.distance(DOCK) <= 0.05
    assert abs(wrap_angle(rig.pose.yaw - DOCK.yaw)) <= 0.1
    assert rig.knowledge.world.pursued() is None


def test_the_last_of_the_way_is_along_the_docks_heading_and_slow(rig, docked):
    docked()
    last = [p for p in rig.path if p.distance(DOCK) < 0.45]
    assert max(abs(p.x - DOCK.x) for p in last) < 0.05
    steps = [a.distance(b) / 0.05 for a, b in pairwise(last)]
    assert 0.05 < max(steps) <= 0.12


def test_touching_is_being_in(rig, docked):
    sense = rig.sense

    def sense_front():
        sense()
        rig.knowledge.signals.write("front", [max(DOCK.y + 0.1 - rig.pose.y, 0.0)], rig.clock.now())

    rig.sense = sense_front
    assert docked(touch=0.2).state is TicketState.SUCCEEDED
    assert DOCK.y - rig.pose.y == pytest.approx(0.1, abs=0.02)


def test_something_before_the_dock_blocks_it(rig, docked):
    sense = rig.sense

    def sense_front():
        sense()
        rig.knowledge.signals.write("front", [0.1], rig.clock.now())

    rig.sense = sense_front
    ticket = docked(touch=0.2)
    assert ticket.failure.reason is Reason.BLOCKED
    assert "front = 0.10 m" in ticket.failure.evidence
    assert "before 'bay'" in ticket.failure.evidence


def test_touch_without_a_reading_is_a_lost_sensor(rig, docked):
    ticket = docked(touch=0.2)
    assert ticket.failure.reason is Reason.LOST_SENSOR


def test_pushed_aside_it_backs_out_and_tries_again(rig, docked):
    pushed = []
    run = rig.execute.run

    def push(t):
        if not pushed and rig.pose.distance(DOCK) < 0.04:
            pushed.append(t)
            rig.pose = Pose2(rig.pose.x + 0.1, DOCK.y, rig.pose.yaw)
            rig.sense()
        run(t)

    rig.execute.run = push
    assert docked().state is TicketState.SUCCEEDED
    assert pushed
    assert rig.pose.distance(DOCK) <= 0.05
    assert any(
        min(e.parameters["speeds"]) == max(e.parameters["speeds"]) == -0.1
        for e in rig.of(AtomicStarted)
        if e.action == "SetWheelSpeed"
    )


def test_one_that_never_gets_in_tells_by_how_much(rig, docked):
    run = rig.execute.run

    def push(t):
        if rig.pose.distance(DOCK) < 0.04:
            rig.pose = Pose2(DOCK.x + 0.1, DOCK.y, rig.pose.yaw)
            rig.sense()
        run(t)

    rig.execute.run = push
    ticket = docked(attempts=2)
    assert ticket.failure.reason is Reason.STUCK
    assert "missed 'bay' 2 times" in ticket.failure.evidence
    assert rig.knowledge.world.pursued() is None


def test_an_unknown_dock_says_which_there_are(rig):
    rig.knowledge.world.place("bay", DOCK)
    ticket = rig.submit(Dock(goal="bey"))
    rig.finish(ticket)
    assert ticket.failure.reason is Reason.NO_GOAL
    assert "Did you mean 'bay'" in ticket.failure.evidence


def test_it_says_how_far_it_is_from_done(rig):
    rig.knowledge.world.place("bay", Pose2(3.0, 4.0))
    assert Dock(goal="bay").remaining(rig.knowledge) == pytest.approx(5.0)
    assert math.isnan(Dock(goal="nowhere").remaining(rig.knowledge))
