"""The quadrotor takes off, holds its position, follows its limits, and lands from any state; its battery drains."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.geometry import Twist3
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.simulation import build_world

SCENARIO = """format = "scenario/2"
world = "plane"
duration = "60 s"
[[agent]]
name = "R"
robot = "quadrotor"
mission = "go_to"
x = "0 m"
y = "0 m"
"""
GROUND, HOVER = 0.1, 0.4  # [m] heights of the base on the ground and after a take-off
REST = Twist3(0.0)
LIMITS = Catalog().load_robot("quadrotor").locomotion


class Flight:
    """The quadrotor on a plane, commanded through its safety gate in each control period."""

    def __init__(self, project: Path) -> None:
        file = project / "scenarios" / "flight.toml"
        file.parent.mkdir()
        file.write_text(SCENARIO, encoding="utf-8")
        catalog = Catalog(project)
        self._simulated = build_world(catalog.load_scenario("flight"), catalog, 1, NullSink())
        self.world, self.gate = self._simulated.world, self._simulated.actuators["R"]["rotors"]

    @property
    def position(self) -> list[float]:
        """x, y, z [m]."""
        return list(self.world.pose3("R")[:3])

    @property
    def charge(self) -> float:
        """Charge of the battery."""
        return self._simulated.sensors["R"]["battery"].read().values[0]

    def fly(self, twist: Twist3, seconds: float) -> list[Twist3]:
        """Command a twist for a time; returns the true twist after each control period."""
        found = []
        for _ in range(round(seconds / 0.05)):
            self.gate.command(LIMITS.command(twist).tolist())
            self.world.advance(10)
            assert self.world.ground_contact("R") == ""
            found.append(self.world.twist3("R"))
        return found

    def take_off(self) -> None:
        self.fly(Twist3(0.0, 0.0, 0.0, 0.1), 1.5)
        self.fly(REST, 1.5)

    def drift(self, seconds: float) -> list[list[float]]:
        """Command nothing for a time; returns the position after each control period."""
        found = []
        for _ in range(round(seconds / 0.05)):
            self.world.advance(10)
            assert self.world.ground_contact("R") == ""
            found.append(self.position)
        return found


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


def test_the_first_motion_takes_off_before_it_moves_in_the_plane(flight: Flight) -> None:
    flight.fly(REST, 0.5)
    assert flight.position == pytest.approx([0.0, 0.0, GROUND], abs=0.002)
    flight.fly(Twist3(0.5, 0.0, 0.0, 0.0), 0.5)
    assert math.hypot(*flight.position[:2]) < 0.02
    flight.fly(Twist3(0.5, 0.0, 0.0, 0.0), 2.0)
    x, y, z = flight.position
    assert x > 0.35
    assert (y, z) == (pytest.approx(0.0, abs=0.02), pytest.approx(HOVER, abs=0.03))


def test_it_holds_its_position_its_height_and_its_yaw(flight: Flight) -> None:
    flight.take_off()
    start, yaw = flight.position, flight.world.pose("R").yaw
    for _ in range(60):
        flight.fly(REST, 0.05)
        assert flight.position == pytest.approx(start, abs=0.005)
        assert flight.world.pose("R").yaw == pytest.approx(yaw, abs=0.01)
    assert start[2] == pytest.approx(HOVER, abs=0.03)


@pytest.mark.parametrize(("axis", "part"), [("vx", "forward"), ("vy", "left"), ("vz", "up"), ("wz", "turn")])
def test_each_axis_reaches_its_limit_without_much_overshoot(flight: Flight, axis: str, part: str) -> None:
    flight.take_off()
    limit = LIMITS.axis_limits(axis)
    found = [getattr(t, part) for t in flight.fly(Twist3(**{"forward": 0.0, part: limit.max_speed}), 2.5)]
    assert found[-1] == pytest.approx(limit.max_speed, rel=0.05)
    assert max(found) < 1.2 * limit.max_speed
    reached = next(i for i, v in enumerate(found) if v > 0.9 * limit.max_speed) * 0.05
    assert reached < limit.max_speed / limit.max_acceleration + 2.0 * LIMITS.response.late
    assert flight.world.tilt("R") < math.radians(20.0)


def climb(flight: Flight) -> None:
    flight.take_off()
    flight.fly(Twist3(0.3, -0.3, 0.6, 0.5), 1.5)


def race(flight: Flight) -> None:
    flight.take_off()
    flight.fly(Twist3(1.0, 0.0, 0.0, 1.5), 1.5)


def begin(flight: Flight) -> None:
    flight.fly(Twist3(0.5, 0.0, 0.0, 0.0), 0.3)


def wait(flight: Flight) -> None:
    flight.fly(REST, 0.3)


@pytest.mark.parametrize("state", [race, climb, begin, wait], ids=lambda state: state.__name__)
def test_neutral_hovers_then_lands_without_a_bounce(flight: Flight, state: Callable[[Flight], None]) -> None:
    state(flight)
    flight.gate.neutral()
    before = flight.position
    hovers = flight.drift(4.0)
    if before[2] > 2.0 * GROUND:
        assert min(z for *_, z in hovers) > before[2] - 0.1
        assert math.dist(hovers[-1], hovers[-20]) < 0.02, "it stopped"
    found = flight.drift(7.0)
    assert found[-1][2] == pytest.approx(GROUND, abs=0.003)
    assert flight.world.data.ctrl[:4].tolist() == [0.0] * 4
    touched = next(i for i, (*_, z) in enumerate(found) if z < GROUND + 0.003)
    assert max(z for *_, z in found[touched:]) < GROUND + 0.005
    assert np.abs(flight.world.data.qvel[:6]).max() < 0.01


def test_it_takes_off_again_after_a_landing(flight: Flight) -> None:
    begin(flight)
    flight.gate.neutral()
    flight.drift(8.0)
    flight.take_off()
    assert flight.position[2] == pytest.approx(HOVER, abs=0.03)


def test_a_kick_does_not_carry_it_away(flight: Flight) -> None:
    flight.take_off()
    start = flight.position
    flight.world.data.qvel[:6] += 0.8, -0.5, -0.5, 1.5, -1.0, 1.0
    flight.fly(REST, 3.0)
    assert math.dist(flight.position[:2], start[:2]) < 1.0, "it holds the place where it stops"
    assert flight.world.tilt("R") < 0.02


def test_a_gust_does_not_carry_it_away(flight: Flight) -> None:
    flight.take_off()
    start = flight.position
    base = flight.world.body("R").root
    flight.world.data.xfrc_applied[base, :3] = 1.0, 1.0, -1.0  # [N] a gust, a tenth of the weight along each axis
    flight.fly(REST, 0.5)
    flight.world.data.xfrc_applied[base, :3] = 0.0
    flight.fly(REST, 2.5)
    assert math.dist(flight.position, start) < 0.05
    assert max(abs(v) for v in flight.world.data.qvel[:6]) < 0.05


def test_the_battery_drains_with_the_power_of_the_rotors(flight: Flight) -> None:
    full = flight.charge
    flight.fly(REST, 1.0)
    waited = flight.charge
    assert full - waited == pytest.approx(10.0 / 160e3, rel=0.01), "the electronics alone"
    flight.take_off()
    before = flight.charge
    for _ in range(20):
        flight.fly(REST, 0.05)
        after = flight.charge
    induced = (1.04 * 9.81) ** 1.5 / math.sqrt(2.0 * 1.225 * 4.0 * math.pi * 0.128**2)
    assert before - after == pytest.approx((10.0 + induced / 0.5) / 160e3, rel=0.05)
