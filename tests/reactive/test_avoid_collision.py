"""rules/avoid_collision.toml on ranges given by hand; its other tests are in rules/tests/avoid_collision.toml."""

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.python_content import load_module
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.catalog import Catalog
from rocs_bt.check import fitted_rules
from rocs_bt.expression import Environment
from rocs_bt.reactive import Override, RuleModel, load_rules, read_rules

GROUPS = ("front", "left_gap", "right_gap", "rear")
ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 3, (LENGTH,)) for name in GROUPS),
        Signal("speed", 1, (SPEED,)),
        Signal("goal_distance", 1, (LENGTH,)),
    ]
)
OTHERWISE = dict.fromkeys(GROUPS, 1.0) | {"goal_distance": 3.0, "speed": 0.3}
SHIPPED = Catalog().find("rules", "avoid_collision").path
PASSED = load_module(Catalog().find("robot", "summit_xl").path.with_name("encounter.py")).PASSED


def wanted(*, before=None, robot=None, **changes):
    """Parameters of each latched rule after some values were held for 1 s, and others before them."""
    overrides = {name: Override(value) for name, value in (robot or {}).items()}
    model, told = RuleModel(load_rules(SHIPPED, ENVIRONMENT, ACTIONS, overrides=overrides)), []
    for t, values in ((0.0, before or changes), (0.05, changes), (0.8, changes), (1.0, changes)):
        x = np.array([v for name, s in ENVIRONMENT.signals.items() for v in [(OTHERWISE | values)[name]] * s.size])
        told = model.react(x, t)
    return {r.rule.rpartition("/")[2]: r.parameters for r in told if r.latched}


def test_it_is_short_and_has_three_active_rules_on_robots_that_cannot_move_sideways():
    lines = [
        line for line in SHIPPED.read_text("utf-8").splitlines() if line.strip() and not line.lstrip().startswith("#")
    ]
    assert len(lines) <= 87
    assert read_rules(SHIPPED, ENVIRONMENT, ACTIONS)[1] == []
    catalog = Catalog()
    for robot in ("jackal", "pioneer_p3dx", "pioneer_p3dx_localised", "summit_xl"):
        ((_, rules),) = fitted_rules(catalog.find("rules", "avoid_collision"), catalog, robot)
        assert [rule.name.rpartition("/")[2] for rule in rules.rules] == ["AvoidCollision", "Flinch", "Blind"]
        assert [rule.name.rpartition("/")[2] for rule in rules.inactive] == ["AvoidCourse"]
        own = {name for values in catalog.load_robot(robot).thresholds.values() for name in values}
        assert own <= {"room", "unknown_ground"}, "no robot needs values of its own, except one with three beams"


def test_a_long_slow_robot_sets_how_it_backs_off_and_turns():
    slow = {"flinch_near": "0.35 m", "flinch_clear": "0.45 m", "flinch_speed": "0.2 m/s", "flinch_distance": "0.6 m"}
    assert "Flinch" not in wanted(front=0.3)
    flinch = wanted(front=0.3, robot=slow)["Flinch"]
    assert (flinch["speed"], flinch["distance"]) == pytest.approx((-0.2, 0.6))
    assert "Flinch" in wanted(before={"front": 0.3}, front=0.44, robot=slow)
    assert "Flinch" not in wanted(before={"front": 0.3}, front=0.46, robot=slow)
    turn = {"near": "0.9 m", "clear": "1.1 m", "avoid_turn_rate": "0.7 rad/s", "avoid_speed": "0.25 m/s"}
    avoid = wanted(front=0.8, robot=turn)["AvoidCollision"]
    assert (avoid["rate"], avoid["speed"]) == pytest.approx((0.7, 0.25))


@pytest.mark.parametrize("room", [1.0, np.inf])
def test_it_wants_nothing_when_there_is_room(room):
    assert wanted(**dict.fromkeys(GROUPS, room)) == {}


def test_it_turns_left_where_both_sides_are_free():
    assert wanted(front=0.39, left_gap=np.inf, right_gap=np.inf)["AvoidCollision"]["turn"] == pytest.approx(np.pi / 3)


def test_the_goal_caps_every_threshold():
    assert "AvoidCollision" in wanted(front=0.25, goal_distance=0.4)
    assert wanted(front=0.25, goal_distance=0.3) == {}
    assert "AvoidCollision" in wanted(front=0.04, goal_distance=0.0)


def test_what_a_monitor_reports_as_passed_releases_flinch():
    close = {"front": 0.19, "left_gap": 0.5}
    passed = {"front": 1.0, "rear": PASSED, "left_gap": PASSED, "right_gap": PASSED}
    assert "Flinch" in wanted(before=close, **close)
    assert "Flinch" not in wanted(before=close, **passed)


BESIDE = {"front": 0.8, "rear": 0.7, "left_gap": 0.19}


@pytest.mark.parametrize(
    ("changes", "speed"),
    [
        ({}, 0.4),  # which of front and rear is farther does not matter beyond 0.6 m
        ({"front": np.inf, "speed": 0.0}, 0.4),
        ({"speed": -0.03}, 0.4),  # stationary, or nearly so
        ({"speed": -0.3}, -0.4),
        ({"front": 0.5}, -0.4),
        ({"rear": 0.5, "speed": -0.3}, 0.4),
        ({"speed": np.nan}, 0.0),
    ],
)
def test_flinch_drives_on_from_what_is_beside_the_robot(changes, speed):
    assert wanted(**BESIDE | changes)["Flinch"]["speed"] == speed


@pytest.mark.parametrize("signal", [*GROUPS, "goal_distance"])
def test_it_stops_when_blind(signal):
    assert wanted(**{signal: np.nan})["Blind"] == {"below": 0.0, "patience": 3600.0}
