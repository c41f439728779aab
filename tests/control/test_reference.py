from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.control.path import Path
from rocs_bt.control.profile import speed_profile
from rocs_bt.control.reference import TURN_RATE, PathReference, TimedReference, TurnReference

from .conftest import LOCOMOTIONS

TIMES = 0.1 * np.arange(1, 21)
STILL = Twist2(0.0)
Row = tuple[float, float, float]


def along(drive: Locomotion, path: Path, cruise: float = 0.5) -> PathReference:
    gentle = replace(drive, max_acceleration=np.array(0.5))
    return PathReference(path, speed_profile(path, gentle, cruise=cruise))


def test_a_robot_at_rest_is_asked_to_gain_speed_from_where_it_is(drive: Locomotion) -> None:
    preview = along(drive, Path.line((0, 0), (10, 0))).sample(Pose2(2.0, 0.3, 0.1), STILL, TIMES, 0.0)
    assert preview.cross_track == pytest.approx(0.3)
    assert preview.heading_error == pytest.approx(0.1)
    gained = np.minimum(TIMES, 1.0)
    expected = 2.0 + 0.25 * gained**2 + 0.5 * np.maximum(TIMES - 1.0, 0.0)
    np.testing.assert_allclose(preview.stages[:, 0], expected, atol=5e-3)
    np.testing.assert_allclose(preview.stages[:, 3], 0.5 * gained, atol=5e-3)
    np.testing.assert_allclose(preview.stages[:, [1, 2, 4, 5]], 0.0, atol=1e-12)


def test_the_end_is_reached_in_finite_time_and_held(drive: Locomotion) -> None:
    preview = along(drive, Path.line((0, 0), (1, 0))).sample(Pose2(0.7, 0.0, 0.0), Twist2(0.5), TIMES, 0.0)
    np.testing.assert_allclose(preview.stages[-5:, 0], 1.0, atol=1e-9)
    np.testing.assert_allclose(preview.stages[-5:, 3], 0.0, atol=1e-6)
    assert (np.diff(preview.stages[:, 0]) >= -1e-12).all()


@given(st.floats(-3.0, 12.0), st.floats(-2.0, 2.0), st.floats(-3.1, 3.1), st.floats(-1.0, 1.0))
def test_previews_never_outrun_profile_or_acceleration(x: float, y: float, yaw: float, speed: float) -> None:
    reference = along(LOCOMOTIONS["differential"], Path.through([(0, 0), (5, 0), (5, 4)], corner_radius=0.3))
    preview = reference.sample(Pose2(x, y, yaw), Twist2(speed), TIMES, 0.0)
    speeds = preview.stages[:, 3]
    assert np.isfinite(preview.stages).all()
    assert (speeds >= 0.0).all()
    assert (speeds <= max(0.5, speed) + 0.1).all()
    assert (np.diff(speeds) <= 0.5 * 0.1 * 2 + 1e-9).all()
    assert abs(preview.stages[0, 2] - yaw) <= math.pi + 0.4
    if abs(preview.heading_error) > math.pi / 2:
        np.testing.assert_allclose(preview.stages[:, :2], [[x, y]] * 20)


def test_a_robot_that_looks_backwards_turns_first(drive: Locomotion) -> None:
    preview = along(drive, Path.line((0, 0), (10, 0))).sample(Pose2(1.0, 0.0, 3.0), STILL, TIMES, 0.0)
    np.testing.assert_allclose(preview.stages[:, :2], [[1.0, 0.0]] * 20)
    assert (np.diff(preview.stages[:, 2]) <= 0.0).all()
    assert preview.stages[-1, 2] < 1.0
    assert preview.stages[:, 5].min() == pytest.approx(-1.5)


def test_yaw_never_jumps_over_many_laps(drive: Locomotion) -> None:
    angles = np.linspace(0.0, 6.0 * np.pi, 1200)
    reference = along(drive, Path(np.column_stack([np.cos(angles), np.sin(angles)])))
    reference.s = 5.0 * math.pi
    preview = reference.sample(Pose2(-1.0, 0.0, -math.pi / 2), Twist2(0.4), TIMES, 0.0)
    assert reference.s == pytest.approx(5.0 * math.pi, abs=0.02)
    np.testing.assert_allclose(preview.stages[0, 2], -math.pi / 2, atol=0.1)
    assert np.abs(np.diff(preview.stages[:, 2])).max() < 0.1


def test_a_path_of_one_place_asks_for_no_heading(drive: Locomotion) -> None:
    preview = along(drive, Path([(1.0, 1.0)])).sample(Pose2(1.0, 1.0, 2.0), STILL, TIMES, 0.0)
    np.testing.assert_allclose(preview.stages, [[1.0, 1.0, 2.0, 0.0, 0.0, 0.0]] * 20, atol=1e-12)


def test_a_timetable_is_read_on_its_clock_and_ahead_of_it() -> None:
    times, poses = [10.0, 12.0, 14.0], [(0, 0, 0), (2, 0, 0), (2, 2, math.pi / 2)]
    reference = TimedReference(times, poses, now=lambda: 10.5)
    preview = reference.sample(Pose2(0.7, 0.1, 0.0), STILL, np.array([0.5, 1.0, 9.0]), lead=0.2)
    np.testing.assert_allclose(preview.stages[:, 0], [1.2, 1.7, 2.0])
    np.testing.assert_allclose(preview.stages[:2, 3:], [[1.0, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(preview.stages[2], [2.0, 2.0, math.pi / 2, 0.0, 0.0, 0.0], atol=1e-12)
    assert preview.cross_track == pytest.approx(0.1)


@given(
    st.lists(st.floats(0.01, 1.0), min_size=1, max_size=6),
    st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-1.0, 1.0)), min_size=6, max_size=6),
    st.floats(-2.0, 8.0),
)
def test_between_its_poses_a_timetable_is_linear_to_the_bit(steps: list[float], rows: list[Row], now: float) -> None:
    times, poses = np.cumsum(steps), np.array(rows)[: len(steps)]
    stages = TimedReference(times, poses, now=lambda: now).sample(Pose2(0.0, 0.0), STILL, TIMES, lead=0.1).stages
    for column in (0, 1):
        assert stages[:, column].tolist() == np.interp(now + 0.1 + TIMES, times, poses[:, column]).tolist()


def test_a_timetable_turns_the_short_way_round_and_near_the_robot() -> None:
    reference = TimedReference([0.0, 1.0], [(0, 0, 3.0), (0, 0, -3.0)], now=lambda: 0.0)
    preview = reference.sample(Pose2(0, 0, -3.1), STILL, np.array([0.5, 1.0]), 0.0)
    assert preview.stages[:, 2] == pytest.approx([math.pi - math.tau, -3.0])
    assert preview.stages[0, 5] == pytest.approx(math.tau - 6.0)


@pytest.mark.parametrize(
    ("times", "poses"),
    [([], np.zeros((0, 3))), ([0.0, 1.0], [(0, 0, 0)]), ([0.0, 0.0], np.zeros((2, 3))), ([math.nan], [(0, 0, 0)])],
)
def test_timetables_that_are_none_are_refused(times: list[float], poses: object) -> None:
    with pytest.raises(InputError, match="timed reference"):
        TimedReference(times, poses, now=lambda: 0.0)


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.floats(-2.0, 2.0))
def test_turns_stay_within_rate_and_acceleration_and_do_not_pass_the_goal(yaw: float, goal: float, turn: float) -> None:
    preview = TurnReference(goal, 1.0, 2.0).sample(
        Pose2(1.0, 2.0, yaw), Twist2(0.0, turn), 0.1 * np.arange(1, 101), 0.0
    )
    yaws, rates = preview.stages[:, 2], preview.stages[:, 5]
    assert math.cos(yaws[-1] - goal) == pytest.approx(1.0, abs=1e-6)
    assert np.abs(rates).max() <= max(TURN_RATE, abs(turn)) + 1e-9
    steps = np.diff(np.concatenate([[yaw], yaws]))
    assert (steps >= -1e-9).all() or (steps <= 1e-9).all()
    assert abs(yaws[-1] - yaw) <= math.tau


def test_half_way_round_a_turn_goes_on_in_its_direction() -> None:
    def last(turn: float) -> float:
        preview = TurnReference(0.0, 0.0, 0.0).sample(Pose2(0.0, 0.0, 3.1), Twist2(0.0, turn), TIMES, 0.0)
        return float(preview.stages[-1, 2])

    assert last(0.5) > 3.1
    assert last(-0.5) < 3.1


def test_a_turn_on_the_spot_leaves_the_pivot_where_it_is_and_asks_for_what_the_drive_then_does() -> None:
    icr_offset, pose = 0.2, Pose2(1.0, 2.0, 0.5)
    skidding = make_locomotion(
        "skid", effective_wheel_separation=0.5, max_wheel_speed=2.0, max_wheel_acceleration=2.0, icr_offset=icr_offset
    )
    back = Path.line((1.0, 2.0), (1.0 - math.cos(0.5), 2.0 - math.sin(0.5)))
    along = PathReference(back, speed_profile(back, skidding, cruise=0.5), icr_offset=icr_offset)
    for reference in (along, TurnReference(-2.0, 1.0, 2.0, icr_offset=icr_offset)):
        stages = reference.sample(pose, Twist2(0.0), TIMES, 0.0).stages
        assert abs(stages[-1, 2] - 0.5) > 2.0
        places = stages[:, :2] + icr_offset * np.column_stack([np.cos(stages[:, 2]), np.sin(stages[:, 2])])
        assert places == pytest.approx(np.full_like(places, pose.transform(icr_offset, 0.0)))
        for forward, left, turn in stages[:, 3:]:
            made = skidding.twist(skidding.command(Twist2(forward, turn, left)))
            assert made == pytest.approx(Twist2(forward, turn, left), abs=1e-9)


def test_a_profile_of_another_path_is_refused(drive: Locomotion) -> None:
    profile = speed_profile(Path.line((0, 0), (2, 0)), drive, cruise=0.5)
    with pytest.raises(InputError, match="its own path"):
        PathReference(Path.line((0, 0), (3, 0)), profile)


@given(st.lists(st.floats(-1.5, 1.5), min_size=2, max_size=8), st.floats(-3.0, 3.0))
def test_yaws_of_a_timetable_may_be_wrapped_or_not(turns: list[float], start: float) -> None:
    yaws = start + np.cumsum(turns)
    poses = np.column_stack([np.arange(len(yaws)), np.zeros(len(yaws)), yaws])
    wrapped = poses.copy()
    wrapped[:, 2] = [math.remainder(yaw, math.tau) for yaw in yaws]
    times = 0.3 * np.arange(len(yaws))
    here = Pose2(0.0, 0.1, 0.2)
    one, other = (
        TimedReference(times, rows, lambda: 0.1).sample(here, STILL, TIMES, 0.05) for rows in (poses, wrapped)
    )
    np.testing.assert_allclose(one.stages, other.stages, atol=1e-9)
    assert one.heading_error == pytest.approx(other.heading_error, abs=1e-9)


@pytest.mark.parametrize("degrees", [110, -135, 150, 172])
def test_at_a_corner_that_leads_back_a_robot_turns_and_does_not_return(drive: Locomotion, degrees: float) -> None:
    yaw = math.radians(degrees)
    leg = np.array([math.cos(yaw), math.sin(yaw)])
    reference = along(drive, Path([(-2.0, 0.0), (0.0, 0.0), tuple(2.0 * leg)]))
    reference.sample(Pose2(-0.2, 0.0, 0.0), STILL, TIMES, 0.0)
    assert reference.s == pytest.approx(1.8)
    for heading in np.linspace(0.0, yaw, 9):  # some cm before the corner: the same turn, all the way
        preview = reference.sample(Pose2(-0.04, 0.0, float(heading)), STILL, TIMES, 0.0)
        assert preview.heading_error == pytest.approx(heading - yaw, abs=0.02)
    for way in (0.02, 0.1, 0.3):  # beside the first leg again, on its way back
        reference.sample(Pose2(*(way * leg - (0.04, 0.0)), yaw), STILL, TIMES, 0.0)
        assert (reference.s or 0.0) >= 2.0


def test_a_corner_that_can_be_driven_round_is_driven_round(drive: Locomotion) -> None:
    reference = along(drive, Path([(-2.0, 0.0), (0.0, 0.0), (0.0, 2.0)]))
    preview = reference.sample(Pose2(-0.04, 0.0, 0.0), Twist2(0.1), TIMES, 0.0)
    assert reference.s == pytest.approx(1.96)
    assert preview.stages[0, 3] > 0.0
