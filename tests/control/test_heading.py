"""Paths that are driven with another heading than their tangent."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2, wrap_angle
from rocs_bt.control.follower import Follower
from rocs_bt.control.heading import NEAR, blended_yaws, toward
from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.control.path import REACH, Path
from rocs_bt.control.profile import BRAKES, speed_profile
from rocs_bt.control.reference import PathReference

from .conftest import LIMITS, PERIOD, Plant

Array = npt.NDArray[np.float64]
TIMES = 0.1 * np.arange(1, 21)
TURN_RATE, TURN_ACCELERATION = 1.5, 2.0
SQUARE = [(0.0, 0.0), (1.5, 0.0), (1.5, 1.5), (0.0, 1.5), (0.0, 0.2)]
corners = st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), min_size=2, max_size=5)
angles = st.floats(-3.1, 3.1)


def mecanum(max_wheel_speed: float = 1.2) -> Locomotion:
    limits = {**LIMITS, "max_wheel_speed": max_wheel_speed}
    return make_locomotion("mecanum", half_length=0.22, half_width=0.2, lag=0.04, **limits)


def reference(path: Path, yaws: Array, drive: Locomotion, cruise: float = 0.5) -> PathReference:
    profile = speed_profile(path, drive, cruise=cruise, yaws=yaws, turn_rate=TURN_RATE)
    made = PathReference(path, profile, turn_rate=TURN_RATE, turn_acceleration=TURN_ACCELERATION, yaws=yaws)
    made.s = 0.0
    return made


def wheel_speeds(drive: Locomotion, forward: Array, left: Array, turn: Array) -> Array:
    """Wheel speeds of twists, shape (n, 4)."""
    unit = [drive.command(Twist2(*each)) for each in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))]
    return np.column_stack([forward, left, turn]) @ np.array(unit)


@given(corners, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_yaws_toward_a_point_meet_it_and_never_jump(points: list[tuple[float, float]], x: float, y: float) -> None:
    path = Path(points)
    yaws, away = toward(path.samples[:, :2], x, y, 0.5), np.hypot(path.samples[:, 0] - x, path.samples[:, 1] - y)
    meant = np.arctan2(y - path.samples[:, 1], x - path.samples[:, 0])
    far = away >= NEAR
    assert np.cos(yaws - meant)[far] == pytest.approx(np.ones(far.sum()), abs=1e-9)
    assert np.abs(np.diff(yaws)).max() <= math.pi / 2 * path.spacing / NEAR + 1e-6 or not far[[0, -1]].all()
    if not far.any():
        assert (yaws == 0.5).all()


@given(angles, angles, st.floats(0.0, 1.5), st.floats(0.5, 5.0))
def test_a_change_of_heading_begins_at_the_robots_yaw_and_ends_at_the_wanted_one(
    wanted: float, yaw: float, s: float, slope: float
) -> None:
    path = Path.line((0.0, 0.0), (2.0, 0.0))
    stations = np.arange(len(path.samples)) * path.spacing
    yaws = blended_yaws(np.full(len(path.samples), wanted), path.spacing, s, yaw, slope)
    turn = abs(wrap_angle(yaw - wanted))
    assert yaws[-1] == pytest.approx(wanted)
    if turn * math.pi / 2 > slope * REACH:
        assert math.cos(np.interp(s, stations, yaws) - yaw) == pytest.approx(1.0, abs=1e-3)
        steepest = max(slope, 0.5 * math.pi * turn / (2.0 - s))
        assert np.abs(np.diff(yaws)).max() <= steepest * path.spacing * (1 + 1e-6) + 1e-12
    assert (np.diff(yaws) <= 1e-12).all() or (np.diff(yaws) >= -1e-12).all()


@given(corners, angles, st.floats(0.1, 1.5), st.floats(-2.0, 2.0))
@settings(max_examples=60)
def test_along_a_profile_with_yaws_no_wheel_is_too_fast(
    points: list[tuple[float, float]], yaw: float, cruise: float, bend: float
) -> None:
    path, drive = Path(points), mecanum()
    yaws = yaw + bend * np.arange(len(path.samples)) * path.spacing
    profile = speed_profile(path, drive, cruise=cruise, yaws=yaws, turn_rate=1.0)
    v, off = profile.speeds, path.samples[:, 2] - yaws
    assert (v <= cruise + 1e-9).all()
    assert (v * v * np.abs(path.samples[:, 3]) <= 1.0 + 1e-9).all()
    if path.length == 0.0:
        return
    turns = v * bend
    assert (np.abs(turns) <= 1.0 + 1e-6).all()
    assert np.abs(wheel_speeds(drive, v * np.cos(off), v * np.sin(off), turns)).max() <= 1.2 + 1e-6
    diagonal = speed_profile(path, drive, cruise=9.0, lateral_acceleration=9.0, yaws=path.samples[:, 2] + math.pi / 4)
    assert diagonal.speeds.max() <= 1.2 / math.sqrt(2.0) + 1e-9


@given(st.floats(-2.0, 2.0), st.floats(0.2, 0.5), angles, st.floats(0.3, 1.5), st.floats(-2.0, 2.0))
@settings(max_examples=40)
def test_round_a_corner_no_wheel_accelerates_too_fast(
    corner: float, radius: float, yaw: float, cruise: float, bend: float
) -> None:
    end = (2.0 + 2.0 * math.cos(corner), 2.0 * math.sin(corner))
    path, drive = Path.through([(0.0, 0.0), (2.0, 0.0), end], radius), mecanum()
    yaws = yaw + bend * np.arange(len(path.samples)) * path.spacing
    profile = speed_profile(path, drive, cruise=cruise, lateral_acceleration=9.0, yaws=yaws)
    v, off = profile.speeds, path.samples[:, 2] - yaws
    wheels = wheel_speeds(drive, v * np.cos(off), v * np.sin(off), v * bend)
    accelerations = np.diff(wheels, axis=0) / path.spacing * 0.5 * (v[1:] + v[:-1])[:, None]
    assert np.abs(accelerations).max() <= 1.5 * (1.0 + BRAKES) + 0.1


@given(
    corners,
    st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), angles),
    st.tuples(st.floats(-0.6, 0.6), st.floats(-1.5, 1.5), st.floats(-0.6, 0.6)),
    angles,
)
@settings(max_examples=80)
def test_previews_turn_within_their_limits_and_their_twists_lead_from_pose_to_pose(
    points: list[tuple[float, float]],
    here: tuple[float, float, float],
    twist: tuple[float, float, float],
    wanted: float,
) -> None:
    path = Path(points)
    pose, moving = Pose2(*here), Twist2(*twist)
    made = reference(path, np.full(len(path.samples), wanted), mecanum())
    preview = made.sample(pose, moving, TIMES, 0.0)
    x, y, yaw, forward, left, turn = preview.stages.T
    assert np.isfinite(preview.stages).all()
    assert preview.heading_error == pytest.approx(wrap_angle(pose.yaw - wanted))
    turns = np.concatenate([[moving.turn], turn])
    assert np.abs(turn).max() <= TURN_RATE + 1e-9
    assert np.abs(np.diff(turns)).max() <= 0.1 * TURN_ACCELERATION + 1e-9
    np.testing.assert_allclose(yaw, pose.yaw + np.cumsum(0.05 * (turns[1:] + turns[:-1])), atol=1e-9)
    speed = np.hypot(forward, left)
    # With the tangents of the same path, the directions of travel and the speeds are the same as with these yaws.
    along = PathReference(path, made.profile, turn_first=math.tau)
    along.s = 0.0
    tangent = along.sample(Pose2(pose.x, pose.y, pose.yaw), moving, TIMES, 0.0).stages
    np.testing.assert_allclose(speed, tangent[:, 3], atol=1e-9)
    np.testing.assert_allclose(np.column_stack([x, y]), tangent[:, :2], atol=1e-12)
    if path.length > 0.0:
        travel = np.arctan2(left, forward) + yaw - tangent[:, 2]
        assert np.cos(travel[speed > 1e-6]) == pytest.approx(1.0, abs=1e-9)


def test_on_a_smooth_path_the_twists_of_a_preview_are_the_velocities_of_its_poses() -> None:
    angles = np.linspace(0.0, math.pi, 400)
    path = Path(np.column_stack([np.cos(angles), np.sin(angles)]))
    made = reference(path, toward(path.samples[:, :2], 0.3, 0.0, 0.0), mecanum())
    pose = Pose2(*made.path.position(0.8).tolist(), 2.0)
    moving, times = Twist2(0.1, 0.2, 0.2), 0.01 * np.arange(1, 201)
    x, y, yaw, forward, left, _ = made.sample(pose, moving, times, 0.0).stages.T
    world = np.column_stack([np.cos(yaw) * forward - np.sin(yaw) * left, np.sin(yaw) * forward + np.cos(yaw) * left])
    moved = np.diff(np.column_stack([x, y]), axis=0)
    np.testing.assert_allclose(0.005 * (world[1:] + world[:-1]), moved, atol=2e-4)
    np.testing.assert_allclose(np.cumsum(0.005 * (world[1:] + world[:-1]), axis=0)[-1], moved.sum(axis=0), atol=5e-3)


def test_a_robot_that_looks_elsewhere_drives_at_once() -> None:
    path = Path.line((0.0, 0.0), (4.0, 0.0))
    preview = reference(path, np.full(len(path.samples), math.pi / 2), mecanum()).sample(
        Pose2(0.0, 0.1, math.pi / 2), Twist2(0.0), TIMES, 0.0
    )
    assert preview.cross_track == pytest.approx(0.1)
    assert preview.heading_error == pytest.approx(0.0)
    np.testing.assert_allclose(preview.stages[:, 2], math.pi / 2)
    np.testing.assert_allclose(preview.stages[:, [3, 5]], 0.0, atol=1e-9)
    assert preview.stages[-1, 4] == pytest.approx(-0.5)


def test_yaws_of_another_path_are_refused() -> None:
    path = Path.line((0.0, 0.0), (2.0, 0.0))
    with pytest.raises(InputError, match="a yaw at each of the 201 samples, found 5"):
        PathReference(path, speed_profile(path, mecanum(), cruise=0.5), yaws=np.zeros(5))


class Drives:
    """Mecanum robot on a plant with lag, yaw slip and lateral slip, which the follower does not know exactly."""

    def __init__(self, path: Path, drive: Locomotion, cruise: float = 0.5) -> None:
        self.path, self.drive, self.cruise = path, drive, cruise
        self.plant = Plant(drive, Pose2(0.0, 0.0), left=0.95)
        self.cross: list[float] = []
        self.heading: list[float] = []
        self.yaws: list[float] = []

    def go(self, wanted: Array | None = None, wanted_at: Callable[[float], Array] | None = None) -> float:
        """Drive to the end of the path; returns the time [s]."""
        follower, t, s = Follower(self.drive), 0.0, 0.0
        made = None
        while t < 60.0:
            if made is None or wanted_at is not None:
                yaws = wanted if wanted_at is None else wanted_at(t)
                assert yaws is not None
                yaws = blended_yaws(yaws, self.path.spacing, s, self.plant.pose.yaw, TURN_RATE / self.cruise)
                made = reference(self.path, yaws, self.drive, self.cruise)
                made.s = s
            command = follower.step(self.plant.pose, None, made, PERIOD)
            assert command.rung == "solved"
            self.plant.move(command.values)
            pose = self.plant.pose
            t, s = t + PERIOD, self.path.project(pose.x, pose.y, made.s)
            x, y, tangent, _ = self.path.sample(s)
            self.cross.append(math.cos(tangent) * (pose.y - y) - math.sin(tangent) * (pose.x - x))
            self.heading.append(command.heading_error)
            self.yaws.append(pose.yaw)
            if self.path.length - s < 0.02:
                return t
        raise AssertionError(f"{self.path.length - s:.2f} m are left")

    def rms(self) -> float:
        return float(np.sqrt(np.mean(np.square(self.cross))))


@pytest.mark.parametrize("radius", [0.2, 0.0])
@pytest.mark.parametrize("yaw", [0.0, 0.8, math.pi])
@pytest.mark.parametrize("max_wheel_speed", [1.2, 0.6])
def test_a_square_is_driven_with_a_fixed_yaw(radius: float, yaw: float, max_wheel_speed: float) -> None:
    path = Path.through(SQUARE, radius)
    robot = Drives(path, mecanum(max_wheel_speed))
    time = robot.go(np.full(len(path.samples), yaw))
    assert robot.rms() <= 0.015
    assert np.abs(robot.cross).max() <= 0.04
    assert np.cos(np.array(robot.yaws[-20:]) - yaw).min() >= math.cos(0.05)
    assert time <= 17.0


@pytest.mark.parametrize("radius", [0.2, 0.0])
def test_a_square_is_driven_while_looking_at_its_centre(radius: float) -> None:
    path = Path.through(SQUARE, radius)
    robot = Drives(path, mecanum())
    robot.go(toward(path.samples[:, :2], 0.75, 0.75, 0.0))
    assert robot.rms() <= 0.015
    assert np.abs(robot.heading[60:]).max() <= 0.1


@pytest.mark.parametrize("radius", [0.2, 0.0])
def test_a_square_is_driven_while_spinning(radius: float) -> None:
    path = Path.through(SQUARE, radius)
    robot = Drives(path, mecanum())
    robot.go(wanted_at=lambda t: np.full(len(path.samples), 0.5 * t))
    assert robot.rms() <= 0.015
    assert robot.yaws[-1] > 4.0
    lags = 0.05 * 0.5 * np.arange(1, len(robot.yaws) + 1) - robot.yaws
    assert np.abs(lags).max() <= 0.3


def test_a_way_that_leads_back_is_driven_without_a_turn() -> None:
    robot = Drives(Path([(0.0, 0.0), (1.5, 0.0), (0.0, 0.0)]), mecanum())
    time = robot.go(np.zeros(len(robot.path.samples)))
    assert np.abs(robot.yaws).max() <= 0.02
    assert time <= 8.0
