"""SpaceTime in a closed loop without physics: the robot drives each plan exactly for a fifth of a second."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.footprint import Footprint
from rocs_bt.control.space_time import LAYER, LAYERS, PARTS, Manners, MotionLimits, SpaceTime
from rocs_bt.control.way_field import USED, WayField, distances
from rocs_bt.knowledge import Movers

HULL = Footprint(0.5, 0.43)
LIMITS = MotionLimits(cruise=1.2, back=0.8, turn_rate=1.5, acceleration=2.0, deceleration=2.5, turn_acceleration=5.0)
EVERY = 0.2


def wall(*corners, step=0.03):
    """Points on a polyline."""
    parts = [np.linspace(a, b, max(2, round(math.dist(a, b) / step))) for a, b in pairwise(corners)]
    return np.vstack(parts)


class Robot:
    """A robot that drives its plans exactly, from `start` to `goal`."""

    def __init__(self, start, goal, points=None, manners=None, limits=LIMITS):
        self.search = SpaceTime(HULL, limits, manners or Manners())
        self.points = np.zeros((0, 2)) if points is None else points
        self.pose, self.twist, self.goal = Pose2(*start), Twist2(0.0), np.array(goal)
        self.plans = []
        self.field = None

    def step(self, t, movers):
        here = np.array(self.pose[:2])
        if len(self.plans) % 4 == 0:
            self.field = WayField(here, 6.0, self.points, HULL)
            slow = np.hypot(*movers.mean[:, 2:].T) < 0.25
            self.field.lead(np.array([here, self.goal]), np.column_stack([movers.mean[:, :2], movers.radius])[slow])
        plan = self.search.plan(t, self.pose, self.twist, self.field, movers.predict(self.search.times(t)))
        self.plans.append(plan)
        at = [np.interp(t + EVERY, plan.times, column) for column in plan.poses.T]
        forward = math.cos(self.pose.yaw) * (at[0] - self.pose.x) + math.sin(self.pose.yaw) * (at[1] - self.pose.y)
        self.twist = Twist2(forward / EVERY, (at[2] - self.pose.yaw) / EVERY)
        self.pose = Pose2(*at)

    @property
    def arrived(self):
        return math.dist(self.pose[:2], self.goal) < 0.3


def moved(x, y, vx, vy):
    return lambda t: (x + vx * t, y + vy * t, vx, vy)


def driven(robot, walkers, seconds=20.0):
    """Time of arrival [s], or None; and the smallest gap between hull and walkers ever [m]."""
    least, t = math.inf, 0.0
    while t < seconds:
        rows = np.array([walker(t) for walker in walkers]).reshape(-1, 4)
        movers = Movers.of(t, rows)
        robot.step(t, movers)
        t += EVERY
        for walker in walkers:
            x, y, *_ = walker(t)
            away = _body(robot.pose, x, y)
            least = min(least, float(HULL.gap(*np.array(away))) - 0.25)
        assert HULL.clearance(np.array([robot.pose]), robot.points)[0] > 0.0, "it touches no wall"
        if robot.arrived:
            return t, least
    return None, least


def _body(pose, x, y):
    c, s, dx, dy = math.cos(pose.yaw), math.sin(pose.yaw), x - pose.x, y - pose.y
    return c * dx + s * dy, c * dy - s * dx


def test_without_movers_it_drives_straight_to_the_goal() -> None:
    robot = Robot((0.0, 0.0, 0.0), (6.0, 0.0))
    took, _ = driven(robot, [])
    assert took is not None
    assert took < 6.0 / LIMITS.cruise + 1.5
    assert max(abs(float(plan.poses[1, 1])) for plan in robot.plans) < 0.1


def test_a_plan_respects_the_limits_and_is_continuous() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        robot = Robot((*rng.uniform(-1.0, 1.0, 2), rng.uniform(-3.0, 3.0)), rng.uniform(-5.0, 5.0, 2))
        rows = np.column_stack([rng.uniform(-4.0, 4.0, (6, 2)), rng.uniform(-1.0, 1.0, (6, 2))])
        robot.twist = Twist2(float(rng.uniform(-0.3, 1.2)), float(rng.uniform(-1.0, 1.0)))
        start, twist = robot.pose, robot.twist
        robot.step(2.0, Movers.of(2.0, rows))
        plan = robot.plans[0]
        assert plan.times[0] == 2.0
        assert plan.times[-1] >= 2.0 + (LAYERS + 1) * LAYER
        slowing = 0.5 * (LAYER / PARTS) ** 2 * LIMITS.deceleration
        assert np.hypot(*(plan.poses[-1] - plan.poses[-2])[:2]) <= slowing + 1e-9, "it ends in a stop"
        assert tuple(plan.poses[0]) == pytest.approx(tuple(start))
        step = np.diff(plan.times)
        speed = np.hypot(*np.diff(plan.poses[:, :2], axis=0).T) / step
        turn = np.diff(plan.poses[:, 2]) / step
        assert speed.max() <= LIMITS.cruise + 1e-6
        assert np.abs(turn).max() <= LIMITS.turn_rate + 1e-6
        assert abs(speed[0] - abs(twist.forward)) <= LIMITS.deceleration * 0.4
        assert np.abs(np.diff(turn)).max() <= LIMITS.turn_acceleration * LAYER + 1e-6


@pytest.mark.parametrize(
    "walkers",
    [
        [moved(3.0, -3.0, 0.0, 1.0)],
        [moved(3.0, -2.5, 0.0, 1.0), moved(4.0, 2.5, 0.0, -1.0)],
        [moved(6.0, 0.05, -1.0, 0.0)],
        [moved(2.0, 0.0, 0.0, 0.0)],
        [moved(2.0, 0.0, 0.5, 0.0)],
        [moved(7.0, -0.6, -0.8, 0.0), moved(7.5, 0.6, -0.8, 0.0)],
    ],
    ids=["crosses", "two cross", "oncoming", "in the way", "ahead and slower", "two abreast"],
)
def test_it_arrives_without_a_contact(walkers) -> None:
    took, least = driven(Robot((0.0, 0.0, 0.0), (6.0, 0.0)), walkers)
    assert took is not None
    assert least > 0.05


@pytest.mark.parametrize(("side", "sign"), [("right", -1.0), ("left", 1.0)])
def test_it_passes_on_the_side_of_its_manners(side, sign) -> None:
    robot = Robot((0.0, 0.0, 0.0), (7.0, 0.0), manners=Manners(side=side))
    path = []
    walker = moved(7.0, 0.0, -0.8, 0.0)
    for k in range(40):
        robot.step(EVERY * k, Movers.of(EVERY * k, np.array([walker(EVERY * k)])))
        path.append(robot.pose[:2])
    aside = max(path, key=lambda at: abs(at[1]))[1]
    assert aside * sign > 0.2


def planned(rows, goal=(4.0, 0.0), speed=0.0, points=None):
    """Plan of a robot at the origin."""
    points = np.zeros((0, 2)) if points is None else points
    search, field = SpaceTime(HULL, LIMITS, Manners()), WayField(np.zeros(2), 6.0, points, HULL)
    field.lead(np.array([(0.0, 0.0), goal]), np.zeros((0, 3)))
    movers = Movers.of(0.0, np.array(rows))
    return search.plan(0.0, Pose2(0.0, 0.0, 0.0), Twist2(speed), field, movers.predict(search.times(0.0)))


def test_one_that_touches_the_robot_costs_nothing_if_the_robot_leaves() -> None:
    free, touched = planned([(-5.0, 4.0, 0.0, 0.0)]), planned([(-0.51, 0.0, 0.0, 0.0)])
    assert touched.contact == 0.0
    assert touched.cost == pytest.approx(free.cost, abs=1.0)
    walls = np.vstack([wall((-0.3, 0.3), (0.6, 0.3), (0.6, -0.3), (-0.3, -0.3)), wall((-0.31, -0.3), (-0.31, 0.3))])
    kept = planned([(0.52, 0.0, 0.0, 0.0)], goal=(0.1, 0.0), points=walls)
    assert kept.contact == 1.0, "it has to leave, and cannot"
    beside = planned([(0.0, -0.47, 0.0, 0.0)])
    assert beside.contact == 0.0
    assert beside.poses[-1, 0] > 2.0


def test_a_contact_with_one_does_not_make_those_with_others_free() -> None:
    struck = [(0.0, 1.0, 0.0, -2.0), (0.0, -1.0, 0.0, 2.0)]
    one, two = planned(struck[:1]).cost, planned(struck).cost
    both = planned([*struck, (0.45, 0.5, 0.0, -0.8), (-0.45, 0.5, 0.0, -0.8)]).cost
    assert one < two < both


@pytest.mark.parametrize("beside", [0.26, 0.28, 0.30])
@pytest.mark.parametrize("goal", [(0.0, -4.0), (-4.0, -0.05)])
@pytest.mark.parametrize("back", [0.0, 0.8])
def test_a_turn_beside_a_wall_leaves_its_corners_outside(beside, goal, back) -> None:
    walls = wall((-6.0, beside), (6.0, beside))
    search, field = SpaceTime(HULL, LIMITS, Manners()), WayField(np.zeros(2), 8.0, walls, HULL)
    field.lead(np.array([(0.0, 0.0), goal]), np.zeros((0, 3)))
    oncoming = Movers.of(0.0, np.array([[2.0, -0.3, -0.8, 0.0]])).predict(search.times(0.0))
    plan = search.plan(0.0, Pose2(0.0, 0.0, 0.0), Twist2(0.0), field, oncoming, back)
    at = np.linspace(0.0, plan.times[-1], 200)
    poses = np.column_stack([np.interp(at, plan.times, column) for column in plan.poses.T])
    assert HULL.clearance(poses, walls).min() > -0.01


def test_to_drive_into_another_costs_more_than_to_be_struck() -> None:
    driven = planned([(0.65, 0.0, 0.0, 0.0)], speed=1.0)
    struck = planned([(0.0, 1.2, 0.0, -3.0)])
    assert driven.contact == struck.contact == 1.0, "neither can be avoided"
    free, rest = planned([(-5.0, 4.0, 0.0, 0.0)], speed=1.0), planned([(-5.0, 4.0, 0.0, 0.0)])
    assert driven.cost - free.cost > struck.cost - rest.cost


def test_it_does_not_turn_while_another_strikes_its_flank() -> None:
    plan = planned([(0.0, 0.7, 0.0, -1.0)], goal=(0.0, -4.0))
    assert plan.contact == 1.0, "it cannot be avoided"
    assert np.abs(plan.poses[plan.times < LAYER + 1e-9, 2]).max() == 0.0, "a turning flank would drive into the other"
    assert np.abs(plan.poses[:, 2]).max() > 0.5, "later it turns to its goal"


def test_two_that_meet_in_a_corridor_pass_each_other() -> None:
    walls = np.vstack([wall((-2.0, 1.0), (10.0, 1.0)), wall((-2.0, -1.0), (10.0, -1.0))])
    robots = [Robot((0.0, 0.0, 0.0), (8.0, 0.0), walls), Robot((8.0, 0.0, math.pi), (0.0, 0.0), walls)]
    least = math.inf
    for k in range(60):
        t, rows = EVERY * k, []
        for robot in robots:
            v = robot.twist.forward
            rows.append((*robot.pose[:2], v * math.cos(robot.pose.yaw), v * math.sin(robot.pose.yaw)))
        for robot, other in zip(robots, reversed(rows), strict=True):
            if not robot.arrived:
                robot.step(t, Movers.of(t, np.array([other]), 0.33))
        gap = float(HULL.gap(*np.array(_body(robots[0].pose, *robots[1].pose[:2])))) - 0.215
        least = min(least, gap)
        if all(robot.arrived for robot in robots):
            break
    assert all(robot.arrived for robot in robots)
    assert least > 0.0


def test_it_backs_away_from_an_oncoming_one_where_there_is_no_room_aside() -> None:
    walls = np.vstack([wall((-6.0, 0.4), (8.0, 0.4)), wall((-6.0, -0.4), (8.0, -0.4))])
    robot = Robot((1.0, 0.0, 0.0), (6.0, 0.0), walls)
    walker = moved(4.0, 0.0, -0.5, 0.0)
    least = math.inf
    for k in range(30):
        t = EVERY * k
        robot.step(t, Movers.of(t, np.array([walker(t)])))
        x, y, *_ = walker(t + EVERY)
        least = min(least, float(HULL.gap(*np.array(_body(robot.pose, x, y)))) - 0.25)
    assert robot.pose.x < 1.0
    assert least > 0.0


@pytest.mark.parametrize("far", [0.5, 1.5, 2.0, 2.8, 3.0, 3.4, 4.0, 5.0])
def test_from_rest_it_arrives_without_delay_at_any_distance_from_its_goal(far) -> None:
    took, _ = driven(Robot((0.0, 0.0, 0.0), (far, 0.0)), [moved(-5.0, 4.0, 0.0, 0.0)], seconds=9.0)
    assert took is not None
    assert took < far / LIMITS.cruise + 2.5


def test_it_does_not_drive_back_faster_than_the_ground_behind_allows() -> None:
    for back in (0.0, 0.2):
        search = SpaceTime(HULL, LIMITS, Manners())
        field = WayField(np.zeros(2), 6.0, np.zeros((0, 2)), HULL)
        field.lead(np.array([[0.0, 0.0], [-3.0, 0.0]]), np.zeros((0, 3)))
        ahead = Movers.of(0.0, np.array([[1.2, 0.0, -0.6, 0.0]])).predict(search.times(0.0))
        plan = search.plan(0.0, Pose2(0.0, 0.0, 0.0), Twist2(0.0), field, ahead, back)
        steps, yaws = np.diff(plan.poses[:, :2], axis=0), plan.poses[:-1, 2]
        speed = (steps * np.column_stack([np.cos(yaws), np.sin(yaws)])).sum(axis=1) / np.diff(plan.times)
        assert speed.min() >= -back - 0.02


def test_the_way_to_a_goal_beside_the_middle_of_a_cell_is_exact_near_it() -> None:
    field = WayField(np.array([0.0, 0.0]), 4.0, np.zeros((0, 2)), HULL)
    goal = np.array([1.09, 0.09])
    field.lead(np.array([[0.0, 0.0], goal]), np.zeros((0, 3)))
    at = goal + np.array([[0.0, 0.0], [0.05, 0.0], [0.0, -0.1]])
    left = field.to_go(*at.T)
    assert left[0] == pytest.approx(0.0, abs=1e-9)
    assert left[1:] == pytest.approx([0.05, 0.1], abs=0.04)


def test_the_way_leads_around_walls_and_stationary_ones() -> None:
    field = WayField(np.zeros(2), 6.0, wall((2.0, -2.0), (2.0, 2.0)), HULL)
    field.lead(np.array([[0.0, 0.0], [0.0, 3.0], [4.0, 3.0], [4.0, 0.0]]), np.zeros((0, 3)))
    x, y = np.array([0.0, 4.0, 1.5]), np.zeros(3)
    left = field.to_go(x, y)
    assert left[0] > 5.0, "not through the wall"
    assert left[1] < 0.2
    open_field = WayField(np.zeros(2), 6.0, np.zeros((0, 2)), HULL)
    open_field.lead(np.array([[0.0, 0.0], [4.0, 0.0]]), np.zeros((0, 3)))
    straight = float(open_field.to_go(np.zeros(1), np.zeros(1))[0])
    assert straight == pytest.approx(4.0, abs=0.2)
    open_field.lead(np.array([[0.0, 0.0], [4.0, 0.0]]), np.array([[2.0, 0.0, 0.25]]))
    assert float(open_field.to_go(np.zeros(1), np.zeros(1))[0]) > straight


@pytest.mark.parametrize("size", [(0.5, 0.43), (0.4, 0.4), (0.3, 0.6), (1.2, 0.4)])
def test_gaps_of_the_field_are_those_of_the_hull_less_a_part_of_its_width(size) -> None:
    rng, hull = np.random.default_rng(5), Footprint(*size)
    points = rng.uniform(-3.0, 3.0, (30, 2))
    field = WayField(np.zeros(2), 6.0, points, hull)
    poses = np.column_stack([rng.uniform(-3.0, 3.0, (200, 2)), rng.uniform(-math.pi, math.pi, 200)])
    true = hull.clearance(poses, points)
    found, fine = (
        field.gaps(*poses.T[:2], np.cos(poses[:, 2]), np.sin(poses[:, 2]), fine=fine) for fine in (False, True)
    )
    outside = true > 0.0
    assert (found <= true + 0.04)[outside].all()
    assert np.abs(true - fine)[outside & (fine < USED)].max() < 0.1
    assert (np.minimum(true, USED) - found)[outside].max() < 0.07 + min(size) / 3.0


def test_the_way_of_a_wide_robot_does_not_lead_through_a_gap_that_is_too_narrow() -> None:
    points = np.vstack([wall((2.0, 0.3), (2.0, 3.0)), wall((2.0, -0.3), (2.0, -3.0))])
    left = []
    for hull in (Footprint(0.4, 0.3), Footprint(0.3, 0.7)):
        field = WayField(np.zeros(2), 6.0, points, hull)
        field.lead(np.array([[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]]), np.zeros((0, 3)))
        left.append(float(field.to_go(np.zeros(1), np.zeros(1))[0]))
    assert left[0] < 5.0
    assert left[1] > 6.0, "around the walls"


def test_distances_between_cells_are_those_of_scipy_up_to_their_maximum():
    rng = np.random.default_rng(3)
    for share in (0.0, 0.002, 0.05, 1.0):
        taken = rng.random((60, 80)) < share
        exact = distance_transform_edt(~taken) if taken.any() else np.full(taken.shape, np.inf)
        assert np.array_equal(distances(taken, 13), np.minimum(exact, 13.0))
