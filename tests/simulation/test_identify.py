"""Identify finds what the model was made with, and robot.toml holds what it finds."""

from __future__ import annotations

import dataclasses
import json
from functools import cache

import pytest

from rocs_bt.catalog import Catalog, LocomotionSpec, robot_locomotion
from rocs_bt.cli.main import call
from rocs_bt.errors import InputError
from rocs_bt.geometry import Twist2
from rocs_bt.simulation.identify import Identified, identify

CATALOG = Catalog()
SIDED = ("differential", "skid")
ROBOTS = [r.name for r in CATALOG.list("robot") if CATALOG.load_robot(r.name).locomotion.kind in SIDED]


@cache
def found(robot: str) -> Identified:
    return identify(CATALOG.load_robot(robot), CATALOG)


def test_a_differential_drives_track_is_where_its_wheels_are() -> None:
    assert found("pioneer_p3dx").effective_wheel_separation == pytest.approx(2 * 0.1655, rel=0.003)
    assert found("pioneer_p3dx").slowest_turn == pytest.approx(1.0, abs=0.002)


def test_a_skid_drives_effective_wheel_separation_is_far_wider_than_built_and_near_the_vendors() -> None:
    track = found("summit_xl").effective_wheel_separation
    assert track == pytest.approx(0.408 * (1.0 + (0.446 / 0.408) ** 2), rel=0.01)  # Coulomb friction
    assert track == pytest.approx(1.0, rel=0.15)


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_robot_toml_says_is_what_is_found(robot: str) -> None:
    spec, measured = CATALOG.load_robot(robot), found(robot)
    numbers = spec.locomotion.parameters
    track = numbers.get("effective_wheel_separation", numbers.get("wheel_separation"))
    assert track == pytest.approx(measured.effective_wheel_separation, rel=0.005)
    if "icr_offset" in numbers:
        assert numbers["icr_offset"] == pytest.approx(measured.icr_offset, abs=0.002)
    if "lag" in numbers:
        late = numbers.get("delay", 0.0) + numbers["lag"]
        assert late == pytest.approx(measured.wheel_lag, abs=0.002)
    assert measured.top_speed == pytest.approx(numbers["max_wheel_speed"], rel=0.01)


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_stop_distance_of_robot_toml_is_what_braking_takes(robot: str) -> None:
    spec, measured = CATALOG.load_robot(robot), found(robot)
    stop_distance = robot_locomotion(spec.locomotion).stop_distance
    assert len(measured.braking) >= 5
    for b in measured.braking:
        reading = b.distance + b.speed * 0.05  # what was seen may have come just after a reading
        assert stop_distance(Twist2(b.speed)) == pytest.approx(reading, rel=0.05)
    assert measured.misfit < 0.05


def test_a_differential_drive_turns_about_its_axle_and_a_skid_drive_about_a_place_ahead() -> None:
    assert found("pioneer_p3dx").icr_offset == pytest.approx(0.0, abs=0.01)
    assert found("jackal").icr_offset > 0.04


def test_the_same_model_gives_the_same_numbers() -> None:
    assert identify(CATALOG.load_robot("summit_xl"), CATALOG) == found("summit_xl")


def test_a_drive_without_sides_is_refused() -> None:
    spec = CATALOG.load_robot("summit_xl")
    numbers = {"half_length": 0.2, "half_width": 0.2, "max_wheel_speed": 1.0, "max_wheel_acceleration": 1.0}
    mecanum = dataclasses.replace(spec, locomotion=LocomotionSpec("mecanum", "wheels", numbers))
    with pytest.raises(InputError, match="'mecanum' locomotion has no effective wheel separation"):
        identify(mecanum, CATALOG)


def test_the_command_tells_people_and_programs_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["identify", "summit_xl", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads(json.dumps(dataclasses.asdict(found("summit_xl"))))
    assert call(["identify", "summit_xl"]) == 0
    assert f"effective_wheel_separation  {told['effective_wheel_separation']:.3f} m" in (
        text := capsys.readouterr().out
    )
    assert (
        f"latency: one sensor period plus {told['brake_delay']:.3f} s; deceleration: {told['deceleration']:.2f}" in text
    )
    assert call(["identify", "nobody"]) == 2
