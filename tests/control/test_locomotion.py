from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.base.geometry import Twist2, Twist3
from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import LOCOMOTIONS, Axis, TurnAxis, make_locomotion

LIMITS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
NUMBERS = {
    "differential": {"wheel_separation": 0.33, **LIMITS},
    "skid": {"effective_wheel_separation": 1.0, **LIMITS},
    "tracked": {"effective_wheel_separation": 0.55, **LIMITS},
    "mecanum": {"half_length": 0.22, "half_width": 0.2, **LIMITS},
    "omni3": {"base_radius": 0.2, **LIMITS},
}
FORWARD, SIDEWAYS, UP, TURN = (
    Axis(max_speed=0.8, max_acceleration=1.0),
    Axis(max_speed=0.5, max_acceleration=0.7),
    Axis(max_speed=0.4, max_acceleration=0.5),
    TurnAxis(max_speed=1.5, max_acceleration=3.0),
)
NUMBERS |= {
    "twist": {"vx": FORWARD, "wz": TURN},
    "legged": {"vx": FORWARD, "vy": SIDEWAYS, "wz": TURN},
    "flying": {"vx": FORWARD, "vy": SIDEWAYS, "vz": UP, "wz": TURN},
}
drives = st.sampled_from(sorted(NUMBERS)).map(lambda kind: make_locomotion(kind, **NUMBERS[kind]))
speeds = st.floats(-3.0, 3.0)


def test_every_kind_in_the_table_is_exercised_here() -> None:
    assert set(NUMBERS) == set(LOCOMOTIONS)


@given(drives, speeds, speeds, speeds)
def test_wheel_speeds_and_twist_are_inverse(drive: Locomotion, forward: float, turn: float, left: float) -> None:
    wanted = Twist2(forward, turn, left if "vy" in drive.axes else 0.0)
    assert drive.twist(drive.command(wanted)) == pytest.approx(wanted, abs=1e-9)


@given(drives, speeds, speeds, speeds)
def test_saturating_keeps_the_curvature_and_the_limit(
    drive: Locomotion, forward: float, turn: float, left: float
) -> None:
    wheels = drive.command(Twist2(forward, turn, left))
    kept = drive.saturate(wheels)
    assert (np.abs(kept) <= drive.max_speed * (1 + 1e-12)).all()
    before, after = drive.twist(wheels), drive.twist(kept)
    assert after.forward * before.turn == pytest.approx(before.forward * after.turn, abs=1e-9)
    if (np.abs(wheels) <= drive.max_speed).all():
        np.testing.assert_array_equal(kept, wheels)
    else:
        assert (np.abs(kept) / drive.max_speed).max() == pytest.approx(1.0)


@given(drives, st.lists(speeds, min_size=8, max_size=8), st.floats(1e-3, 2.0))
def test_approaching_keeps_both_limits_and_the_kinematics(drive: Locomotion, q: list[float], period: float) -> None:
    n = drive.twist_from_q.shape[1]
    now = drive.saturate(drive.values_from_q @ np.array(q[:n]))
    wanted = drive.values_from_q @ np.array(q[4 : 4 + n])
    then = drive.approach(now, wanted, period)
    assert (np.abs(then) <= drive.max_speed * (1 + 1e-12)).all()
    assert (np.abs(then - now) <= drive.max_acceleration * period * (1 + 1e-12)).all()
    np.testing.assert_allclose(drive.values_from_q @ drive.coordinates(then), then, atol=1e-9)


@pytest.mark.parametrize("unknown", ["vx", "vy", "vz", "wz"])
def test_the_unknown_speed_of_one_axis_leaves_the_others_known(unknown: str) -> None:
    flyer = make_locomotion("flying", **NUMBERS["flying"])
    speeds = {"vx": 0.4, "vy": -0.2, "vz": 0.1, "wz": 0.7, unknown: np.nan}
    twist = flyer.twist3(list(speeds.values()))
    assert twist == pytest.approx((speeds["vx"], speeds["vy"], speeds["vz"], speeds["wz"]), nan_ok=True)


def test_a_left_turn_runs_the_right_wheels_forward() -> None:
    differential, skid, mecanum = (
        make_locomotion(kind, **NUMBERS[kind]) for kind in ("differential", "skid", "mecanum")
    )
    assert differential.command(Twist2(0.0, turn=2.0)) == pytest.approx([-0.33, 0.33])
    assert skid.command(Twist2(0.0, turn=2.0)) == pytest.approx([-1.0, 1.0, -1.0, 1.0])
    assert mecanum.command(Twist2(0.0, turn=2.0)) == pytest.approx([-0.84, 0.84, -0.84, 0.84])


@given(st.floats(-0.2, 0.2), speeds, speeds)
def test_about_its_pivot_a_skid_drive_turns_and_what_is_asked_for_is_made(
    icr_offset: float, forward: float, turn: float
) -> None:
    drive = make_locomotion("skid", effective_wheel_separation=1.0, icr_offset=icr_offset, **LIMITS)
    made = drive.twist(drive.command(Twist2(forward, turn)))
    assert made.forward == pytest.approx(forward, abs=1e-9)
    assert made.turn == pytest.approx(turn, abs=1e-9)
    assert made.left + icr_offset * made.turn == pytest.approx(0.0, abs=1e-9)  # at the ICR


def test_a_mecanum_drive_goes_left_on_crossed_wheels() -> None:
    mecanum = make_locomotion("mecanum", half_length=0.22, half_width=0.2, **LIMITS)
    assert mecanum.command(Twist2(0.0, left=0.5)) == pytest.approx([-0.5, 0.5, 0.5, -0.5])


def test_three_wheels_drive_forward_on_the_front_ones_and_left_on_all() -> None:
    omni = make_locomotion("omni3", **NUMBERS["omni3"])
    side = np.sin(np.radians(60.0))
    assert omni.axes == ("vx", "vy", "wz")
    assert omni.command(Twist2(0.5)) == pytest.approx([-0.5 * side, 0.0, 0.5 * side])
    assert omni.command(Twist2(0.0, left=0.5)) == pytest.approx([0.25, -0.5, 0.25])
    assert omni.command(Twist2(0.0, turn=2.0)) == pytest.approx([0.4, 0.4, 0.4])
    assert omni.speed_limit == pytest.approx(1.2 / side)
    assert omni.turn_limit == pytest.approx(6.0)


@given(st.floats(-np.pi, np.pi), st.floats(0.1, 1.0))
def test_three_wheels_roll_as_fast_as_their_places_move_along_them(direction: float, base_radius: float) -> None:
    omni = make_locomotion("omni3", base_radius=base_radius, **LIMITS)
    twist = Twist2(np.cos(direction), 0.7, np.sin(direction))
    for degrees, speed in zip((60.0, 180.0, 300.0), omni.command(twist).tolist(), strict=True):
        at = np.radians(degrees)
        x, y = base_radius * np.cos(at), base_radius * np.sin(at)
        velocity = twist.forward - twist.turn * y, twist.left + twist.turn * x
        assert speed == pytest.approx(-np.sin(at) * velocity[0] + np.cos(at) * velocity[1])


def test_limits_of_the_body_follow_from_those_of_the_wheels() -> None:
    drive = make_locomotion("differential", wheel_separation=0.4, **LIMITS)
    assert drive.speed_limit == pytest.approx(1.2)
    assert drive.turn_limit == pytest.approx(6.0)
    assert drive.arm == pytest.approx(0.2)


def test_an_unknown_kind_lists_what_exists() -> None:
    with pytest.raises(UnknownName, match="mecanum") as caught:
        make_locomotion("mecanun", wheel_separation=0.3)
    assert "differential" in str(caught.value)
    assert "skid" in str(caught.value)


def test_wrong_numbers_are_named() -> None:
    with pytest.raises(
        InputError, match=r"no parameter of .* 'effective_wheel_separation'(.|\n)*needs wheel_separation"
    ):
        make_locomotion("differential", effective_wheel_separation=0.3, **LIMITS)
    with pytest.raises(InputError, match=r"is named 'icr_offset'"):
        make_locomotion("differential", wheel_separation=0.3, icr_offset=0.1, **LIMITS)
    with pytest.raises(InputError, match="icr_offset of the locomotion 'skid' must be finite, found inf"):
        make_locomotion("skid", effective_wheel_separation=1.0, icr_offset=float("inf"), **LIMITS)
    with pytest.raises(InputError, match=r"wheel_separation of .* must be positive, found 0"):
        make_locomotion("differential", wheel_separation=0.0, **LIMITS)
    with pytest.raises(InputError, match="max_wheel_speed"):
        make_locomotion(
            "skid", effective_wheel_separation=1.0, max_wheel_speed=float("nan"), max_wheel_acceleration=1.0
        )


def test_matrices_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match=r"shapes \(3, 2\) and \(1, 2\)"):
        Locomotion("odd", ("only",), np.zeros((3, 2)), np.eye(2), 1.0, 1.0)
    with pytest.raises(InputError, match="are not determined by its values"):
        Locomotion("odd", ("a", "b"), np.zeros((3, 2)), np.ones((2, 2)), 1.0, 1.0)


DIRECTIONS = [math.radians(45.0 * k) for k in range(8)]


@pytest.mark.parametrize("kind", ["differential", "mecanum", "omni3", "legged", "flying"])
@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_stop_distance_by_the_limits_is_not_too_short(kind: str, direction: float) -> None:
    """A ramp within the limits of all values, from a motion in this direction to rest, as the oracle."""
    made = make_locomotion(kind, **NUMBERS[kind])
    left = 0.3 * math.sin(direction) if "vy" in made.axes else 0.0
    twist = Twist2(0.3 * math.cos(direction), 0.0, left)
    values, moved, period = made.command(twist), 0.0, 1e-3
    while np.abs(values).max() > 1e-9:
        values = made.approach(values, np.zeros(len(values)), period)
        moved += period * math.hypot(made.twist(values).forward, made.twist(values).left)
    late = made.response.latency * math.hypot(twist.forward, twist.left)
    assert late + moved <= made.stop_distance(twist) + 1e-3
    assert made.stop_distance(twist) <= late + 1.6 * moved + 1e-3


def test_a_body_that_climbs_stops_by_its_own_limit() -> None:
    made = make_locomotion("flying", **NUMBERS["flying"])
    assert made.stop_distance(Twist3(0.0, up=0.4)) == pytest.approx(0.4 * 0.1 + 0.4**2 / (2.0 * UP.max_acceleration))


def test_curves_need_speed_and_acceleration_of_the_turn() -> None:
    made = make_locomotion(
        "legged", vx=Axis(max_speed=0.6, max_acceleration=1.0), wz=TurnAxis(max_speed=2.0, max_acceleration=1.0)
    )
    speed, acceleration = made.curve_factors(np.array([0.0, 2.0]))
    assert speed.tolist() == [1.0, 1.0]
    assert acceleration.tolist() == [1.0, 2.0]  # 1 m/s2 along a curve of 0.5 m turns at 2 rad/s2
