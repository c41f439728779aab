"""FollowRoute: along a way that changes, slower where it is tight, backward where there is no room to turn."""

import math

import numpy as np

from rocs_bt.actions import FollowRoute
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import ActuatorCommanded, FollowerStepped
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import TicketState
from rocs_bt.knowledge import OccupancyGrid

STRAIGHT = [(0.1 * k, 0.0) for k in range(31)]


def mapped(rig, *points):
    """Give the robot a size, and a map on which these points stand."""
    rig.knowledge.graph.set("R1", length=0.5, width=0.4)
    rig.knowledge.world.occupancy = grid = OccupancyGrid(0.05, 12.0)
    for _ in range(3):
        grid.add_scan(np.array(points).reshape(-1, 2), np.empty((0, 2), dtype=np.intp))


def begin(rig, points=STRAIGHT, **parameters):
    rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
    return rig.submit(FollowRoute(points=points, goal="goal", **parameters))


def speeds(rig):
    return np.array([e.values for e in rig.of(ActuatorCommanded)]).mean(axis=1)


def wall(y):
    return [(x, y) for x in np.arange(1.0, 2.0, 0.05)]


def test_it_arrives_and_stands_and_pursues_its_goal_meanwhile(rig):
    ticket = begin(rig)
    rig.run(5)
    assert rig.knowledge.world.pursued() == "goal"
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED
    assert rig.pose.distance(Pose2(3.0, 0.0)) <= 0.1
    assert abs(speeds(rig)[-2]) < 0.1
    assert rig.knowledge.world.pursued() is None


def test_in_passing_it_does_not_slow_down(rig):
    rig.finish(begin(rig, tolerance=0.5, passing=True))
    assert rig.pose.x < 2.7
    assert speeds(rig)[-2] > 0.8


def test_it_is_slower_where_there_is_less_room(rig):
    mapped(rig, *wall(0.3), *wall(-0.3))  # 10 cm on either side
    rig.finish(begin(rig))
    v = np.diff([p.x for p in rig.path]) / rig.body.period
    between = [s for s, p in zip(v, rig.path, strict=False) if 1.1 < p.x < 1.8]
    assert max(between) < 0.45
    assert max(v) > 0.8


def test_a_way_that_is_replaced_is_taken_at_once(rig):
    ticket = begin(rig)
    rig.run(20)
    here = rig.pose
    ticket.action.update(points=[(here.x, 0.0), (here.x + 0.4, 0.0), (2.0, 0.8), (2.6, 0.8), (3.0, 0.0)])
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED
    assert max(p.y for p in rig.path) > 0.5


def test_a_map_that_changes_slows_it_on_the_same_way(rig):
    mapped(rig)
    ticket = begin(rig)
    rig.run(10)
    for _ in range(3):
        rig.knowledge.world.occupancy.add_scan(np.array([*wall(0.3), *wall(-0.3)]), np.empty((0, 2), dtype=np.intp))
    rig.finish(ticket)
    v = np.diff([p.x for p in rig.path]) / rig.body.period
    assert max(s for s, p in zip(v, rig.path, strict=False) if 1.2 < p.x < 1.8) < 0.5


def test_in_a_dead_end_it_leaves_backward_and_turns_where_there_is_room(rig):
    x = np.arange(-1.0, 0.4, 0.05)
    mapped(rig, *((a, s * 0.27) for a in x for s in (-1, 1)), *((0.4, b) for b in np.arange(-0.27, 0.27, 0.05)))
    rig.knowledge.world.place("goal", Pose2(-3.0, 0.0), kind="goal")
    rig.heard["room_behind"] = (2.0,) * 5
    rig.sense()
    ticket = rig.submit(FollowRoute(points=[(-a, 0.0) for a, _ in STRAIGHT], goal="goal"))
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED
    inside = [p for p in rig.path if p.x > -0.9]
    assert max(abs(p.yaw) for p in inside) < 0.3  # it did not turn there
    assert abs(rig.pose.yaw) > 2.8  # it did later


def test_it_does_not_leave_backward_over_ground_that_it_does_not_know(rig):
    mapped(rig, *((a, s * 0.27) for a in np.arange(-1.0, 0.4, 0.05) for s in (-1, 1)))
    rig.knowledge.world.place("goal", Pose2(-3.0, 0.0), kind="goal")
    ticket = rig.submit(FollowRoute(points=[(-a, 0.0) for a, _ in STRAIGHT], goal="goal"))
    rig.finish(ticket)
    assert ticket.failure.reason is Reason.STUCK
    assert rig.pose.x >= 0.0


def test_nobody_turns_on_the_spot_where_the_hull_would_swing_into_something(rig):
    up = [(0.0, 0.1 * k) for k in range(31)]
    mapped(rig, (-0.26, -0.18))  # beside it, where its rear comes by
    rig.knowledge.world.place("goal", Pose2(0.0, 3.0), kind="goal")
    ticket = rig.submit(FollowRoute(points=up, goal="goal"))
    rig.finish(ticket)
    assert ticket.failure.reason is Reason.STUCK
    assert "no room to turn" in str(ticket.failure)
    assert max(abs(pose.yaw) for pose in rig.path) < 0.05
    mapped(rig, (-0.26, 0.25))  # where its rear turns away from
    ticket = rig.submit(FollowRoute(points=up, goal="goal"))
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED


def test_who_gets_nowhere_is_stuck(rig):
    ticket = begin(rig, patience=1.0)
    rig.run(5)
    rig.wheels.command = lambda values: None  # the wheels hang
    rig.wheels.speeds = [0.0, 0.0]
    rig.finish(ticket)
    assert ticket.failure.reason is Reason.STUCK


def test_a_lost_pose_stops_it_and_a_missing_goal_fails_it(rig):
    ticket = begin(rig)
    rig.run(10)
    rig.lost = True
    rig.finish(ticket)
    assert ticket.failure.reason is Reason.LOST_POSE
    nobody = rig.submit(FollowRoute(points=STRAIGHT, goal="nowhere"))
    rig.lost = False
    rig.finish(nobody)
    assert nobody.failure.reason is Reason.NO_GOAL


def test_it_tells_how_it_follows_and_what_remains(rig):
    ticket = begin(rig)
    rig.run(20)
    assert max(abs(e.cross_track) for e in rig.of(FollowerStepped)) < 0.02
    assert ticket.action.remaining(rig.knowledge) == rig.knowledge.robot.pose().distance(Pose2(3.0, 0.0))
    assert math.isnan(FollowRoute(points=STRAIGHT, goal="nowhere").remaining(rig.knowledge))
