"""Headings and heights of the motion actions, on bodies that move in every direction."""

import math

import numpy as np
import pytest

from rocs_bt.actions import FollowPath, FollowRobot, FollowRoute, GoTo, action_table
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.base.units import LENGTH
from rocs_bt.control.locomotion_kinds import Axis, TurnAxis, make_locomotion
from rocs_bt.event import FollowerStepped, TicketChanged
from rocs_bt.interfaces.action import Reason, make_action, misfits_of
from rocs_bt.interfaces.pipeline import TicketState
from rocs_bt.knowledge import Movers, OccupancyGrid

from ..conftest import Rig

PERIOD = 0.05
LIMITS = {"max_wheel_speed": 0.8, "max_wheel_acceleration": 1.5}
AXES = {
    "vx": Axis(max_speed=0.8, max_acceleration=1.0),
    "vy": Axis(max_speed=0.6, max_acceleration=1.0),
    "vz": Axis(max_speed=0.5, max_acceleration=0.8),
    "wz": TurnAxis(max_speed=1.5, max_acceleration=3.0),
}
WALKING = {axis: limits for axis, limits in AXES.items() if axis != "vz"}
BODIES = {
    "differential": make_locomotion("differential", wheel_separation=0.33, **LIMITS),
    "mecanum": make_locomotion("mecanum", half_length=0.22, half_width=0.2, **LIMITS),
    "flying": make_locomotion("flying", lag=0.15, **AXES),
    "steady": make_locomotion("legged", **WALKING),
    "swaying": make_locomotion("legged", sway=0.03, **WALKING),
}


class Robot(Rig):
    """Rig of a body that follows its commands with its lag, in height too, and measures ranges above and below it."""

    def __init__(self, kind="mecanum", ranges=None):
        self.ranges, self.height, self.sees_height = ranges or {}, 0.0, True
        groups = [(name, 2, (LENGTH, LENGTH)) for name in self.ranges]
        super().__init__(locomotion=BODIES[kind], more=[("height", 1, (LENGTH,)), *groups])
        self.values = np.array(self.wheels.speeds)

    def sense(self):
        super().sense()
        measured = {name: measure(self) for name, measure in self.ranges.items()}
        for name, value in (measured | ({"height": [self.height]} if self.sees_height else {})).items():
            self.knowledge.signals.write(name, value, self.clock.now())

    def move(self, twist, period):
        lag, wanted = self.locomotion.response.lag, np.array(self.wheels.speeds)
        self.values = wanted + (self.values - wanted) * (math.exp(-period / lag) if lag else 0.0)
        self.wheels.speeds = self.values.tolist()
        twist = self.locomotion.twist3(self.values)
        super().move(twist, period)
        self.height += period * twist.up
        self.path[-1] = (*self.pose, self.height)

    def go(self, action):
        """Run an action to its end; its ticket."""
        ticket = self.submit(action)
        self.finish(ticket)
        return ticket

    def place(self, name, x, y, kind="place"):
        self.knowledge.world.place(name, Pose2(x, y), kind=kind)


@pytest.fixture
def robot():
    made = Robot()
    made.place("dock", 1.0, 1.0, "goal")
    return made


def yaws(robot):
    return np.unwrap([yaw for _, _, yaw, _ in robot.path])


class TestGoTo:
    def test_keeps_its_yaw_and_drives_straight(self, robot):
        robot.pose = Pose2(0.0, 0.0, -2.0)
        robot.sense()
        assert robot.go(GoTo(goal="dock", heading="keep")).state is TicketState.SUCCEEDED
        assert robot.pose.distance(Pose2(1.0, 1.0)) <= 0.05
        assert yaws(robot) == pytest.approx(-2.0, abs=0.02)
        assert max(abs(x - y) for x, y, _, _ in robot.path) <= 0.03
        assert len(robot.path) * PERIOD <= 5.0

    @pytest.mark.parametrize(("text", "yaw"), [("90 deg", math.pi / 2), ("-3.1 rad", -3.1), ("0 deg", 0.0)])
    def test_takes_an_angle_while_it_drives(self, robot, text, yaw):
        robot.go(GoTo(goal="dock", heading=text))
        assert wrap_angle(robot.pose.yaw - yaw) == pytest.approx(0.0, abs=0.05)
        assert max(abs(x - y) for x, y, _, _ in robot.path) <= 0.03
        turned = np.diff(yaws(robot)) / PERIOD
        assert np.abs(turned).max() <= 1.5 + 0.1
        x, y, *_ = robot.path[20]  # no turn on the spot before
        assert math.hypot(x, y) > 0.05

    def test_looks_at_a_place_on_its_way(self, robot):
        robot.place("person", 1.0, 0.0)
        robot.go(GoTo(goal="dock", heading="look_at person"))
        bearings = [Pose2(x, y, yaw).bearing(Pose2(1.0, 0.0)) for x, y, yaw, _ in robot.path]
        assert np.abs(bearings).max() <= 0.1
        assert robot.pose.yaw == pytest.approx(-math.pi / 2, abs=0.1)

    def test_looks_at_a_place_that_moves(self, robot):
        robot.place("person", 2.0, 0.0)
        ticket = robot.submit(GoTo(goal="dock", heading="look_at person", cruise=0.3))
        errors = []
        for _ in range(400):
            angle = 0.4 * robot.clock.now()
            person = Pose2(0.5 + 1.5 * math.cos(angle), 0.5 + 1.5 * math.sin(angle))
            robot.place("person", person.x, person.y)
            robot.run()
            errors.append(abs(robot.pose.bearing(person)))
            if ticket.state.done:
                break
        assert ticket.state is TicketState.SUCCEEDED
        assert max(errors[20:]) <= 0.4
        assert max(abs(x - y) for x, y, _, _ in robot.path) <= 0.03

    def test_holds_its_yaw_near_the_place_that_it_looks_at(self, robot):
        robot.go(GoTo(goal="dock", heading="look_at dock"))
        assert robot.pose.distance(Pose2(1.0, 1.0)) <= 0.05
        assert robot.pose.yaw == pytest.approx(math.pi / 4, abs=0.1)

    def test_a_reflex_does_not_change_the_yaw_that_is_kept(self, robot):
        first, after = GoTo(goal="dock", heading="keep"), GoTo(goal="dock", heading="keep")
        ticket = robot.submit(first)
        robot.run(20)
        robot.pipeline.cancel(ticket, "test")
        robot.run()
        robot.pose = Pose2(robot.pose.x, robot.pose.y, 0.7)
        robot.sense()
        after.resume(first)
        robot.go(after)
        assert robot.pose.yaw == pytest.approx(0.0, abs=0.03)

    def test_an_unknown_place_ends_it(self, robot):
        robot.place("person", 1.0, 0.0)
        ticket = robot.go(GoTo(goal="dock", heading="look_at preson"))
        assert ticket.failure.reason is Reason.NO_GOAL
        assert "Did you mean 'person'" in ticket.failure.evidence

    def test_notes_the_errors_relative_to_the_wanted_yaw(self, robot):
        robot.go(GoTo(goal="dock", heading="keep"))
        assert max(abs(e.heading_error) for e in robot.of(FollowerStepped)) <= 0.02
        assert max(abs(e.cross_track) for e in robot.of(FollowerStepped)) <= 0.03

    def test_an_unknown_turn_rate_is_no_standstill(self):
        robot = Robot("flying")
        robot.place("near", 0.0, 0.0, "goal")
        ticket = robot.submit(GoTo(goal="near", heading="0 deg"))
        signals, write = robot.knowledge.signals, robot.knowledge.signals.write
        signals.write = lambda name, value, t: write(name, [math.nan] if name == "turn_rate" else value, t)
        robot.sense()
        robot.run(10)
        assert not ticket.state.done
        signals.write = write
        robot.run(10)
        assert ticket.state is TicketState.SUCCEEDED

    @pytest.mark.parametrize("kind", ["mecanum", "flying"])
    def test_arrives_only_with_the_yaw_of_an_angle(self, kind):
        robot = Robot(kind)
        robot.place("near", 0.02, 0.0, "goal")
        for action in (
            GoTo(goal="near", heading="90 deg"),
            FollowPath(points=[(0, 0), (0.02, 0)], heading="90 deg"),
            FollowRoute(points=[(0, 0), (0.02, 0)], goal="near", heading="90 deg"),
        ):
            robot.pose = Pose2(0.0, 0.0, 0.0)
            robot.sense()
            assert robot.go(action).state is TicketState.SUCCEEDED
            assert robot.pose.yaw == pytest.approx(math.pi / 2, abs=math.radians(5.0))

    @pytest.mark.parametrize("kind", ["mecanum", "flying"])
    def test_among_movers_too_it_arrives_with_the_yaw_of_an_angle(self, kind):
        robot = Robot(kind)
        robot.place("far", 1.5, 0.0, "goal")
        robot.knowledge.graph.set("R1", length=0.6, width=0.4)
        robot.knowledge.world.occupancy = OccupancyGrid(0.05, 12.0)
        robot.knowledge.world.movers = Movers.of(0.0, np.array([[3.0, 3.0, -0.1, 0.0]]))
        route = FollowRoute(points=[(0, 0), (1.5, 0)], goal="far", heading="90 deg", tolerance=0.2, cruise=0.6)
        assert robot.go(route).state is TicketState.SUCCEEDED
        assert robot.pose.yaw == pytest.approx(math.pi / 2, abs=math.radians(5.0))
        assert math.dist(robot.pose[:2], (1.5, 0.0)) <= 0.2


class TestOtherActions:
    def test_a_path_is_followed_sideways_round_its_corners(self, robot):
        path = [(0, 0), (1.5, 0), (1.5, 1.5), (0, 1.5), (0, 0)]
        robot.go(FollowPath(points=path, heading="keep"))
        assert math.hypot(robot.pose.x, robot.pose.y) <= 0.05
        assert yaws(robot) == pytest.approx(0.0, abs=0.02)
        cross = [e.cross_track for e in robot.of(FollowerStepped)]
        assert np.sqrt(np.mean(np.square(cross))) <= 0.015
        assert np.abs(cross).max() <= 0.04

    def test_a_way_back_needs_no_turn(self, robot):
        robot.go(FollowPath(points=[(0, 0), (1.5, 0), (0, 0)], heading="keep"))
        assert max(x for x, *_ in robot.path) >= 1.38
        assert yaws(robot) == pytest.approx(0.0, abs=0.02)

    def test_a_route_that_begins_behind_is_driven_without_a_turn(self, robot):
        robot.place("back", -1.5, 0.2, "goal")
        ticket = robot.go(FollowRoute(points=[(0, 0), (-1.5, 0.2)], goal="back", heading="keep"))
        assert ticket.state is TicketState.SUCCEEDED
        assert yaws(robot) == pytest.approx(0.0, abs=0.02)

    def test_a_route_is_slow_where_the_turned_hull_is_near_to_walls(self):
        speeds = {}
        for yaw in (0.0, math.pi / 2):
            robot = Robot()
            robot.pose = Pose2(0.0, 0.0, yaw)
            robot.sense()
            robot.place("far", 3.0, 0.0, "goal")
            robot.knowledge.graph.set("R1", length=0.7, width=0.3)
            robot.knowledge.world.occupancy = grid = OccupancyGrid(0.05, 12.0)
            route = FollowRoute(points=[(0, 0), (3, 0)], goal="far", heading="keep", cruise=0.6, ease=0.3)
            ticket = robot.submit(route)
            robot.run(5)
            walls = np.array([(x, side * 0.5) for x in np.arange(1.0, 2.0, 0.05) for side in (-1, 1)])
            for _ in range(3):
                grid.add_scan(walls, np.empty((0, 2), dtype=np.intp))
            while not ticket.state.done and len(robot.path) < 400:
                robot.run()
            assert ticket.state is TicketState.SUCCEEDED
            xs = np.array([x for x, *_ in robot.path])
            speeds[yaw] = np.diff(xs)[(xs[1:] > 1.3) & (xs[1:] < 1.7)].mean() / PERIOD
        assert speeds[0.0] >= 0.55
        assert speeds[math.pi / 2] <= 0.45

    def test_a_leader_is_followed_while_looking_at_it_and_at_rest_too(self, robot):
        graph, speed = robot.knowledge.graph, 0.3
        graph.add("R2", "peer", pose=Pose2(0.0, 1.5), speed=speed, turn_rate=0.0)
        follow = FollowRobot(leader="R2", heading="look_at R2", rest=4.0)
        ticket, errors = robot.submit(follow), []
        for period in range(600):
            speed = 0.3 if period < 150 else 0.0
            leader = Pose2(0.3 * PERIOD * min(period, 150), 1.5)
            graph.set("R2", pose=leader, speed=speed, turn_rate=0.0)
            robot.run()
            errors.append(abs(robot.pose.bearing(leader)))
            if ticket.state.done:
                break
        assert ticket.state is TicketState.SUCCEEDED
        assert errors[0] > 1.5
        assert max(errors[60:]) <= 0.2
        assert errors[-1] <= 0.06
        assert robot.pose.distance(leader) <= 1.3
        assert min(x for x, *_ in robot.path) > -0.05  # sideways from the beginning


@pytest.mark.parametrize("body", ["steady", "swaying"])
def test_a_body_that_sways_arrives_within_its_sway(body):
    robot = Robot(body)
    robot.place("dock", 1.0, 0.0, "goal")
    robot.pose = Pose2(1.0, 0.07)
    robot.sense()
    ticket = robot.submit(GoTo(goal="dock"))
    robot.run(2)
    assert (ticket.state is TicketState.SUCCEEDED) == (body == "swaying")


class TestHeight:
    def flying(self):
        robot = Robot("flying")
        robot.place("dock", 2.0, 0.0, "goal")
        return robot

    @pytest.mark.parametrize("height", [1.5, 0.3])
    def test_a_flying_robot_arrives_in_height_too(self, height):
        robot = self.flying()
        robot.height = 1.0
        robot.sense()
        assert robot.go(GoTo(goal="dock", height=height)).state is TicketState.SUCCEEDED
        assert robot.height == pytest.approx(height, abs=0.06)
        heights = np.array([h for *_, h in robot.path])
        assert heights.max() <= max(1.0, height) + 0.03
        assert heights.min() >= min(1.0, height) - 0.03
        climbs = np.diff(heights) / PERIOD
        assert np.abs(climbs).max() <= 0.5 + 1e-6
        assert np.abs(np.diff(climbs)).max() <= 0.8 * PERIOD + 1e-6

    def test_it_climbs_at_its_goal_before_it_has_arrived(self):
        robot = self.flying()
        robot.pose = Pose2(2.0, 0.0)
        robot.sense()
        robot.go(GoTo(goal="dock", height=1.0, heading="90 deg"))
        assert robot.height == pytest.approx(1.0, abs=0.06)
        assert robot.pose.distance(Pose2(2.0, 0.0)) <= 0.06

    def test_a_route_is_not_stuck_while_the_robot_climbs_at_its_end(self):
        robot = self.flying()
        ticket = robot.go(FollowRoute(points=[(0, 0), (2, 0)], goal="dock", height=4.0))
        assert ticket.state is TicketState.SUCCEEDED
        assert robot.height == pytest.approx(4.0, abs=0.11)

    def test_a_route_is_not_stuck_while_the_robot_climbs_over_its_start(self):
        robot = self.flying()
        robot.place("near", 0.5, 0.0, "goal")
        route = FollowRoute(points=[(0, 0), (0.5, 0)], goal="near", cruise=0.02, patience=2.0, height=4.0)
        ticket = robot.submit(route)
        robot.run(140)
        assert ticket.failure is None
        assert robot.height > 2.5
        assert robot.pose.x < 0.2

    def test_a_route_is_stuck_at_its_end_if_the_robot_does_not_climb(self):
        robot = self.flying()
        robot.pose = Pose2(2.0, 0.0)
        robot.sense()
        robot.knowledge.signals.write("height", [0.0], 0.0)
        ticket = robot.submit(FollowRoute(points=[(2, 0), (2, 0)], goal="dock", height=4.0))
        for _ in range(100):
            robot.height = 0.0
            robot.sense()
            robot.run()
        assert ticket.failure.reason is Reason.STUCK

    def test_it_keeps_its_distance_from_a_thing_below_also_while_few_beams_detect_it(self):
        def below(robot):
            over = robot.pose.x < 0.8 and robot.clock.now() % 0.5 < 0.05  # in one of ten periods
            return [robot.height, robot.height - 0.5 if over else robot.height]

        robot = Robot("flying", {"below": below})
        robot.place("dock", 2.0, 0.0, "goal")
        robot.height = 0.9
        robot.sense()
        assert robot.go(GoTo(goal="dock", height=0.3, cruise=0.2)).state is TicketState.SUCCEEDED
        assert min(h for x, _, _, h in robot.path if x < 0.8) > 0.6
        assert robot.height == pytest.approx(0.3, abs=0.06)

    def test_it_keeps_its_distance_from_a_roof_and_flies_in_the_middle_of_a_narrow_gap(self):
        robot = Robot("flying", {"above": lambda robot: [1.0 - robot.height] * 2})
        robot.place("dock", 2.0, 0.0, "goal")
        robot.submit(GoTo(goal="dock", height=1.5))
        robot.run(240)
        assert max(h for *_, h in robot.path) == pytest.approx(0.85, abs=0.03)
        narrow = {"above": lambda robot: [0.6 - robot.height] * 2, "below": lambda robot: [robot.height - 0.4] * 2}
        robot = Robot("flying", narrow)
        robot.place("dock", 2.0, 0.0, "goal")
        robot.height = 0.45
        robot.sense()
        robot.submit(GoTo(goal="dock", height=1.5))
        robot.run(240)
        assert robot.height == pytest.approx(0.5, abs=0.03)

    @pytest.mark.parametrize(("group", "height"), [("below", 0.3), ("above", 1.5)])
    def test_it_does_not_move_toward_an_invalid_range(self, group, height):
        robot = Robot("flying", {group: lambda robot: [3.0, math.nan]})
        robot.place("dock", 2.0, 0.0, "goal")
        robot.height = 1.0
        robot.sense()
        robot.submit(GoTo(goal="dock", height=height))
        robot.run(200)
        assert robot.height == pytest.approx(1.0, abs=0.05)

    def test_it_climbs_first_and_descends_while_it_moves(self):
        robot = self.flying()
        robot.go(GoTo(goal="dock", height=1.0))
        assert max(x for x, _, _, h in robot.path if h < 0.6) < 0.1
        robot.place("dock", 0.0, 0.0, "goal")
        before = len(robot.path)
        robot.go(GoTo(goal="dock", height=0.3, heading="keep"))
        assert min(h for x, _, _, h in robot.path[before:] if x > 1.5) < 0.9

    def test_without_a_height_it_stays_level(self):
        robot = self.flying()
        robot.go(GoTo(goal="dock"))
        assert [h for *_, h in robot.path] == pytest.approx([0.0] * len(robot.path))

    def test_a_height_that_stays_unknown_ends_it(self):
        robot = self.flying()
        ticket = robot.submit(GoTo(goal="dock", height=5.0))
        robot.run(20)
        robot.sees_height = False
        robot.run(20)
        assert ticket.failure.reason is Reason.LOST_SENSOR
        assert "'height'" in ticket.failure.evidence


class TestFaults:
    @pytest.mark.parametrize("text", ["sideways", "90", "1 m", "look_at", "", "inf deg"])
    def test_a_text_that_is_no_heading_is_refused(self, text):
        with pytest.raises(InputError, match="heading must be 'along', 'keep', an angle such as '90 deg', or 'look_at"):
            make_action(action_table(), "GoTo", {"goal": "dock", "heading": text})

    @pytest.mark.parametrize("text", ["keep", "90 deg", "look_at dock"])
    def test_a_robot_that_cannot_move_sideways_faces_along_its_path(self, text):
        robot = Robot("differential")
        robot.place("dock", 1.0, 1.0, "goal")
        assert misfits_of(GoTo, {"goal": "dock", "heading": text}, robot.knowledge)[0][0] == "heading"
        ticket = robot.go(GoTo(goal="dock", heading=text))
        assert ticket.failure.reason is Reason.CANNOT
        assert "cannot move sideways" in ticket.failure.evidence
        assert not misfits_of(GoTo, {"goal": "dock", "heading": "along"}, robot.knowledge)

    def test_a_robot_on_the_ground_has_no_height(self, robot):
        assert misfits_of(FollowPath, {"height": 1.0}, robot.knowledge)[0][0] == "height"
        ticket = robot.go(GoTo(goal="dock", height=1.0))
        assert ticket.failure.reason is Reason.CANNOT
        assert "cannot fly" in ticket.failure.evidence

    def test_only_what_is_set_is_recorded(self, robot):
        robot.go(GoTo(goal="dock", tolerance=2.0))
        robot.go(GoTo(goal="dock", tolerance=2.0, heading="keep"))
        plain, kept = (e.parameters for e in robot.of(TicketChanged) if e.state == "QUEUED")
        assert list(plain) == ["goal", "cruise", "tolerance"]
        assert kept == {**plain, "heading": "keep"}
