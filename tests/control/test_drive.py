from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.control.drive import DRIVES, Drive, differential_drive, make_drive, mecanum_drive, skid_drive
from rocs_bt.errors import InputError, UnknownName
from rocs_bt.geometry import Twist2

LIMITS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
NUMBERS = {
    "differential": {"wheel_separation": 0.33, **LIMITS},
    "skid": {"effective_wheel_separation": 1.0, **LIMITS},
    "mecanum": {"half_length": 0.22, "half_width": 0.2, **LIMITS},
}
drives = st.sampled_from(sorted(NUMBERS)).map(lambda kind: make_drive(kind, **NUMBERS[kind]))
speeds = st.floats(-3.0, 3.0)


def test_every_kind_in_the_table_is_exercised_here() -> None:
    assert set(NUMBERS) == set(DRIVES)


@given(drives, speeds, speeds, speeds)
def test_wheel_speeds_and_twist_are_inverse(drive: Drive, forward: float, turn: float, left: float) -> None:
    sideways = left if drive.name == "mecanum" else 0.0
    wanted = Twist2(forward, turn, sideways)
    assert drive.twist(drive.wheel_speeds(wanted)) == pytest.approx(wanted, abs=1e-9)


@given(drives, speeds, speeds, speeds)
def test_saturating_keeps_the_curvature_and_the_limit(drive: Drive, forward: float, turn: float, left: float) -> None:
    wheels = drive.wheel_speeds(Twist2(forward, turn, left))
    kept = drive.saturate(wheels)
    assert np.abs(kept).max() <= drive.max_wheel_speed * (1 + 1e-12)
    before, after = drive.twist(wheels), drive.twist(kept)
    assert after.forward * before.turn == pytest.approx(before.forward * after.turn, abs=1e-9)
    if np.abs(wheels).max() <= drive.max_wheel_speed:
        np.testing.assert_array_equal(kept, wheels)
    else:
        assert np.abs(kept).max() == pytest.approx(drive.max_wheel_speed)


@given(drives, st.lists(speeds, min_size=8, max_size=8), st.floats(1e-3, 2.0))
def test_approaching_keeps_both_limits_and_the_kinematics(drive: Drive, q: list[float], period: float) -> None:
    n = drive.twist_from_q.shape[1]
    now = drive.saturate(drive.wheels_from_q @ np.array(q[:n]))
    wanted = drive.wheels_from_q @ np.array(q[4 : 4 + n])
    then = drive.approach(now, wanted, period)
    assert np.abs(then).max() <= drive.max_wheel_speed * (1 + 1e-12)
    assert np.abs(then - now).max() <= drive.max_wheel_acceleration * period * (1 + 1e-12)
    np.testing.assert_allclose(drive.wheels_from_q @ drive.coordinates(then), then, atol=1e-9)


def test_a_left_turn_runs_the_right_wheels_forward() -> None:
    differential, skid, mecanum = (make_drive(kind, **NUMBERS[kind]) for kind in ("differential", "skid", "mecanum"))
    assert differential.wheel_speeds(Twist2(0.0, turn=2.0)) == pytest.approx([-0.33, 0.33])
    assert skid.wheel_speeds(Twist2(0.0, turn=2.0)) == pytest.approx([-1.0, 1.0, -1.0, 1.0])
    assert mecanum.wheel_speeds(Twist2(0.0, turn=2.0)) == pytest.approx([-0.84, 0.84, -0.84, 0.84])


@given(st.floats(-0.2, 0.2), speeds, speeds)
def test_about_its_pivot_a_skid_drive_turns_and_what_is_asked_for_is_made(
    icr_offset: float, forward: float, turn: float
) -> None:
    drive = skid_drive(effective_wheel_separation=1.0, icr_offset=icr_offset, **LIMITS)
    made = drive.twist(drive.wheel_speeds(Twist2(forward, turn)))
    assert made.forward == pytest.approx(forward, abs=1e-9)
    assert made.turn == pytest.approx(turn, abs=1e-9)
    assert made.left + icr_offset * made.turn == pytest.approx(0.0, abs=1e-9)  # at the ICR


def test_a_mecanum_drive_goes_left_on_crossed_wheels() -> None:
    mecanum = mecanum_drive(half_length=0.22, half_width=0.2, **LIMITS)
    assert mecanum.wheel_speeds(Twist2(0.0, left=0.5)) == pytest.approx([-0.5, 0.5, 0.5, -0.5])


def test_limits_of_the_body_follow_from_those_of_the_wheels() -> None:
    drive = differential_drive(wheel_separation=0.4, **LIMITS)
    assert drive.speed_limit == pytest.approx(1.2)
    assert drive.turn_limit == pytest.approx(6.0)
    assert drive.arm == pytest.approx(0.2)


def test_an_unknown_kind_lists_what_exists() -> None:
    with pytest.raises(UnknownName, match="mecanum") as caught:
        make_drive("mecanun", wheel_separation=0.3)
    assert "differential" in str(caught.value)
    assert "skid" in str(caught.value)


def test_wrong_numbers_are_named() -> None:
    with pytest.raises(InputError, match=r"takes wheel_separation, .*found effective_wheel_separation"):
        make_drive("differential", effective_wheel_separation=0.3, **LIMITS)
    with pytest.raises(InputError, match=r"takes wheel_separation, .*found .*icr_offset"):
        make_drive("differential", wheel_separation=0.3, icr_offset=0.1, **LIMITS)
    with pytest.raises(InputError, match="icr_offset of a 'skid' drive must be a number, found inf"):
        skid_drive(effective_wheel_separation=1.0, icr_offset=float("inf"), **LIMITS)
    with pytest.raises(
        InputError, match="wheel_separation of a 'differential' drive must be a positive number, found 0"
    ):
        differential_drive(wheel_separation=0.0, **LIMITS)
    with pytest.raises(InputError, match="max_wheel_speed"):
        skid_drive(effective_wheel_separation=1.0, max_wheel_speed=float("nan"), max_wheel_acceleration=1.0)


def test_matrices_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match=r"shapes \(3, 2\) and \(1, 2\)"):
        Drive("odd", ("only",), np.zeros((3, 2)), np.eye(2), 1.0, 1.0)
    with pytest.raises(InputError, match="are not determined by its wheel speeds"):
        Drive("odd", ("a", "b"), np.zeros((3, 2)), np.ones((2, 2)), 1.0, 1.0)
