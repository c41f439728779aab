from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.control.path import Path
from rocs_bt.control.profile import CRAWL, speed_profile


def drive(acceleration: float = 1.5) -> Locomotion:
    limits = {"max_wheel_speed": 1.2, "max_wheel_acceleration": acceleration}
    return make_locomotion("differential", wheel_separation=0.33, **limits)


DRIVE = drive()
polylines = st.lists(st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)), min_size=1, max_size=6)


@given(polylines, st.floats(0.05, 2.0), st.floats(0.1, 3.0), st.floats(0.1, 1.5))
@settings(max_examples=80)
def test_every_limit_holds_everywhere(
    corners: list[tuple[float, float]], cruise: float, lateral: float, along: float
) -> None:
    path = Path(corners)
    profile = speed_profile(path, drive(along), cruise=cruise, lateral_acceleration=lateral)
    v, bend = profile.speeds, np.abs(path.samples[:, 3])
    assert (v >= 0.0).all()
    assert v[-1] == pytest.approx(0.0, abs=1e-6)
    assert (v <= cruise + 1e-9).all()
    assert (v * (1.0 + bend * DRIVE.arm) <= 1.2 + 1e-9).all()
    assert (v * v * bend <= lateral + 1e-9).all()
    if path.length > 0.0:
        assert (np.abs(np.diff(v * v)) <= 2.0 * along * path.spacing + 1e-9).all()
    assert np.isfinite(profile.times).all()


def test_a_long_line_is_ramp_cruise_ramp() -> None:
    path = Path.line((0, 0), (4, 0))
    standing = np.where(np.arange(len(path.samples)) == 0, 0.0, 9.0)
    profile = speed_profile(path, drive(0.5), cruise=0.5, limit=standing)
    # v^2 / 2a = 0.25 m on either side, 1 s each; 3.5 m at 0.5 m/s between.
    assert profile.times[-1] == pytest.approx(9.0, abs=1e-6)
    assert profile.speed(0.125) == pytest.approx(np.sqrt(2 * 0.5 * 0.125), rel=1e-6)
    assert profile.speed(2.0) == pytest.approx(0.5)
    assert profile.station(1.0) == pytest.approx(0.25, abs=1e-3)
    assert profile.time(3.75) == pytest.approx(8.0, abs=1e-3)


def test_a_robot_may_enter_fast() -> None:
    path = Path.line((0, 0), (4, 0))
    assert speed_profile(path, DRIVE, cruise=0.5).speeds[0] == pytest.approx(0.5)
    assert speed_profile(path, DRIVE, cruise=0.5, end_speed=0.3).speeds[-1] == pytest.approx(0.3)


def test_a_corner_slows_before_it_and_lets_go_after_it() -> None:
    path = Path.through([(0, 0), (2, 0), (2, 2)])
    profile = speed_profile(path, DRIVE, cruise=0.7)
    corner = int(np.abs(path.samples[:, 3]).argmax())
    assert profile.speeds[corner] < 0.4
    assert profile.speeds[corner - 50] == pytest.approx(0.7)
    assert profile.speeds[corner + 50] == pytest.approx(0.7)


def test_a_path_of_one_place_takes_no_time() -> None:
    profile = speed_profile(Path([(1, 1)]), DRIVE, cruise=0.5)
    assert profile.times[-1] == 0.0
    assert profile.station(3.0) == 0.0


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"cruise": 0.0}, "cruise"),
        ({"cruise": float("nan")}, "cruise"),
        ({"cruise": 0.5, "lateral_acceleration": 0.0}, "lateral_acceleration"),
        ({"cruise": 0.5, "end_speed": -0.1}, "end_speed"),
    ],
)
def test_numbers_out_of_range_are_refused(wrong: dict[str, float], name: str) -> None:
    with pytest.raises(InputError, match=name):
        speed_profile(Path.line((0, 0), (1, 0)), DRIVE, **wrong)


@given(st.floats(1e-300, 1e-3), st.floats(0.01, 20.0))
@settings(max_examples=40)
def test_a_speed_that_is_hardly_one_takes_long_and_not_for_ever(cruise: float, length: float) -> None:
    profile = speed_profile(Path.line((0.0, 0.0), (length, 0.0)), DRIVE, cruise=cruise)  # warnings are errors
    assert np.isfinite(profile.times).all()
    assert (np.diff(profile.times) > 0.0).all()
    assert (profile.speeds <= cruise + CRAWL).all()


def test_a_single_step_between_two_rests_takes_a_time() -> None:
    path = Path.line((0.0, 0.0), (0.01, 0.0))
    profile = speed_profile(path, DRIVE, cruise=0.5, limit=np.zeros(len(path.samples)))
    assert np.isfinite(profile.times).all()


def test_what_else_limits_the_speed_is_kept_and_braked_for():
    path = Path.line((0.0, 0.0), (4.0, 0.0))
    stations = np.arange(len(path.samples)) * path.spacing
    limit = np.where(np.abs(stations - 2.0) < 0.5, 0.3, 5.0)
    profile = speed_profile(path, DRIVE, cruise=1.0, limit=limit)
    free = speed_profile(path, DRIVE, cruise=1.0)
    assert (profile.speeds <= np.minimum(limit, free.speeds) + 1e-12).all()
    assert profile.speed(2.0) == pytest.approx(0.3)
    assert 0.3 < profile.speed(1.4) < free.speed(1.4)  # it brakes before, and not earlier than it must
    assert profile.speed(0.8) == pytest.approx(free.speed(0.8))
