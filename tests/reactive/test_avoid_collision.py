"""rules/avoid_collision.toml on ranges by hand."""

from pathlib import Path

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS as SHIPPED_ACTIONS
from rocs_bt.catalog import Catalog
from rocs_bt.check import fitted_rules
from rocs_bt.expression import Environment
from rocs_bt.monitor.encounter import PASSED
from rocs_bt.reactive import Override, RuleModel, check_rules, load_rules
from rocs_bt.signal import Signal
from rocs_bt.units import LENGTH, SPEED

ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 3, (LENGTH,)) for name in ("front", "left_gap", "right_gap", "rear")),
        Signal("speed", 1, (SPEED,)),
        Signal("goal_distance", 1, (LENGTH,)),
    ]
)

OTHERWISE = {"goal_distance": 3.0, "speed": 0.3}
SHIPPED = Path(__file__).parents[2] / "rules" / "avoid_collision.toml"


class TestShipped:
    """rules/avoid_collision.toml on ranges by hand."""

    def wanted(self, *, after=1.0, before=None, **changes):
        """What is wanted when some values have stood for a while [s], and others before them; a text is a threshold."""
        given = {"turning": "0.16 m"} | {
            name: changes.pop(name) for name, v in [*changes.items()] if isinstance(v, str)
        }
        fitted = {name: Override(value) for name, value in given.items()}
        rules = load_rules(SHIPPED, ENVIRONMENT, SHIPPED_ACTIONS, overrides=fitted)
        model, told = RuleModel(rules), []
        for t, values in ((0.0, before or changes), (0.05, changes), (after - 0.2, changes), (after, changes)):
            values = dict.fromkeys(("front", "left_gap", "right_gap", "rear"), 1.0) | OTHERWISE | values
            x = np.array([v for n, s in ENVIRONMENT.signals.items() for v in [values.get(n, 0.0)] * s.size])
            told = model.react(x, t)
        return {r.rule.rpartition("/")[2]: r.parameters for r in told if r.latched}

    def test_it_wants_nothing_when_there_is_room(self):
        assert check_rules(SHIPPED, ENVIRONMENT, SHIPPED_ACTIONS) == []
        assert self.wanted() == {}
        assert self.wanted(front=np.inf, left_gap=np.inf, right_gap=np.inf, rear=np.inf, goal_distance=np.inf) == {}

    def test_it_turns_to_the_side_with_more_room(self):
        assert self.wanted(front=0.39, right_gap=0.8)["AvoidCollision"]["turn"] == pytest.approx(np.pi / 3)
        assert self.wanted(front=0.39, left_gap=0.8)["AvoidCollision"]["turn"] == pytest.approx(-np.pi / 3)
        both_free = self.wanted(front=0.39, left_gap=np.inf, right_gap=np.inf)
        assert both_free["AvoidCollision"]["turn"] == pytest.approx(np.pi / 3)

    def test_the_goal_gate(self):
        assert "AvoidCollision" in self.wanted(front=0.25, goal_distance=0.4)
        assert self.wanted(front=0.25, goal_distance=0.3) == {}
        assert "AvoidCollision" in self.wanted(front=0.04, goal_distance=0.0)

    def test_it_flinches_away_from_what_is_close(self):
        assert self.wanted(front=0.19)["Flinch"]["speed"] == -0.4
        assert self.wanted(rear=0.19)["Flinch"]["speed"] == 0.4
        assert self.wanted(front=0.4, left_gap=0.19)["Flinch"]["speed"] == -0.4
        assert "Flinch" not in self.wanted(left_gap=0.21)
        assert self.wanted(front=0.19)["Flinch"]["distance"] >= 0.26  # it goes on until the rule is released

    def test_what_a_monitor_says_has_been_passed_releases_it(self):
        close = {"front": 0.19, "left_gap": 0.5}
        passed = {"front": 1.0, "rear": PASSED, "left_gap": PASSED, "right_gap": PASSED}
        assert "Flinch" in self.wanted(before=close, **close)
        assert "Flinch" not in self.wanted(before=close, **passed)

    def test_from_what_comes_from_the_side_it_goes_on_as_it_is_driving(self):
        beside = {"front": 0.8, "rear": 0.7, "left_gap": 0.19}  # whichever is less far off does not matter
        assert self.wanted(**beside)["Flinch"]["speed"] == 0.4
        assert self.wanted(**beside | {"front": np.inf, "speed": 0.0})["Flinch"]["speed"] == 0.4
        assert self.wanted(**beside | {"speed": -0.03})["Flinch"]["speed"] == 0.4  # it stands, or all but
        assert self.wanted(**beside | {"speed": -0.3})["Flinch"]["speed"] == -0.4
        assert self.wanted(**beside | {"front": 0.5, "speed": 0.3})["Flinch"]["speed"] == -0.4
        assert self.wanted(**beside | {"rear": 0.5, "speed": -0.3})["Flinch"]["speed"] == 0.4
        assert self.wanted(**beside | {"speed": np.nan})["Flinch"]["speed"] == 0.0

    def test_between_two_things_it_stands_still(self):
        assert self.wanted(front=0.19, rear=0.24)["Flinch"]["speed"] == 0.0
        assert self.wanted(front=0.19, rear=0.26)["Flinch"]["speed"] == -0.4

    def test_wedged_it_turns_out_once_driving_straight_has_not_helped(self):
        slot = {"front": 0.22, "rear": 0.19, "left_gap": 0.3, "speed": 0.0}
        assert set(self.wanted(**slot)) == {"Flinch"}
        wedged = self.wanted(after=2.1, **slot)
        assert set(wedged) == {"AvoidCollision"}
        assert wedged["AvoidCollision"]["turn"] == pytest.approx(-np.pi / 3)
        beside = {"front": 0.6, "rear": 0.6, "left_gap": 0.22, "speed": -0.1}  # which no driving straight takes it from
        came = beside | {"left_gap": 0.18}
        assert set(self.wanted(after=2.1, before=came, **beside)) == {"AvoidCollision"}
        assert set(self.wanted(after=2.1, before=came, **beside | {"speed": 0.2})) == {"Flinch"}  # it drives
        assert self.wanted(after=2.1, **beside) == {}  # it may have been put there
        assert set(self.wanted(after=2.1, **slot | {"left_gap": 0.155})) == {"Flinch"}  # its corners would touch
        assert set(self.wanted(after=2.1, **slot | {"goal_distance": 0.15})) == set()
        assert set(self.wanted(after=2.1, turning="1 m", **slot)) == {"Flinch"}  # as the file has it
        passed = beside | {"speed": 0.0}
        assert self.wanted(after=13.0, before=passed | {"left_gap": 0.3}, **passed) == {}  # it parks there

    def test_wedged_beside_something_it_turns_towards_it_and_swings_its_stern_from_it(self):
        slot = {"front": 0.25, "rear": 0.24, "left_gap": 0.13, "speed": 0.0}
        assert set(self.wanted(after=2.1, **slot)) == {"Flinch"}
        turn = self.wanted(after=2.1, lean="0.05 m", **slot)["AvoidCollision"]["turn"]
        assert turn == pytest.approx(np.pi / 3)  # though there is more room at its right
        mirrored = slot | {"left_gap": 1.0, "right_gap": 0.13}
        assert self.wanted(after=2.1, lean="0.05 m", **mirrored)["AvoidCollision"]["turn"] == pytest.approx(-np.pi / 3)
        assert set(self.wanted(after=2.1, lean="0.05 m", **slot | {"right_gap": 0.15})) == {"Flinch"}

    def test_between_two_things_it_makes_for_the_middle_once_flinching_was_in_vain(self):
        slot = {"front": 0.22, "rear": 0.12, "left_gap": 0.3, "speed": 0.0}
        assert self.wanted(creep="0.1 m/s", **slot)["Flinch"]["speed"] == 0.0
        assert self.wanted(after=2.1, creep="0.1 m/s", **slot)["Flinch"]["speed"] == pytest.approx(0.1)
        turned = slot | {"front": 0.12, "rear": 0.22}
        assert self.wanted(after=2.1, creep="0.1 m/s", **turned)["Flinch"]["speed"] == pytest.approx(-0.1)
        middle = slot | {"front": 0.15, "rear": 0.14}
        assert self.wanted(after=2.1, creep="0.1 m/s", **middle)["Flinch"]["speed"] == 0.0
        assert self.wanted(after=2.1, creep="0.1 m/s", **slot | {"left_gap": 0.14})["Flinch"]["speed"] == 0.0
        assert self.wanted(after=2.1, **slot)["Flinch"]["speed"] == 0.0  # as the file has it

    def test_it_resists_only_between_two_things_that_it_hears(self):
        def resist(**changes):
            return self.wanted(after=0.25, resist="0.3 m/s", **changes)["Flinch"]["resist"]

        assert resist(front=0.15, rear=0.22) == pytest.approx(0.3)
        assert resist(front=0.15, rear=0.26) == 0.0
        assert resist(before={"front": 0.15, "rear": 0.22}, front=np.nan, rear=0.22) == 0.0  # until Blind takes over
        assert self.wanted(front=0.15, rear=0.22)["Flinch"]["resist"] == 0.0  # as the file has it

    def test_wedged_without_a_speed_it_stands_still(self):
        assert "Blind" in self.wanted(after=2.3, front=0.22, rear=0.19, speed=np.nan)
        for after in (2.05, 2.1, 2.15):  # and meanwhile it goes on to flinch
            assert set(self.wanted(after=after, front=0.22, rear=0.19, speed=np.nan)) & {"Flinch", "Blind"}
        assert "Blind" not in self.wanted(after=2.3, front=0.6, rear=0.6, speed=np.nan)

    def test_blind_it_stands_still(self):
        for signal in ("front", "left_gap", "right_gap", "rear", "goal_distance"):
            assert self.wanted(**{signal: np.nan})["Blind"] == {"below": 0.0, "patience": 3600.0}

    def test_who_leans_hears_what_it_leans_to(self):
        catalog, leaning = Catalog(), []
        for robot, rules in fitted_rules(catalog.find("rules", "avoid_collision"), catalog):
            least = rules.thresholds["turning"] - rules.thresholds["lean"]
            if rules.thresholds["lean"] > 0.0:
                leaning.append(robot)
                assert least > 0.10, robot  # a sonar says so much of anything that is nearer
        assert "pioneer_p3dx" in leaning

    def test_only_a_robot_that_is_heard_all_round_is_turned_out(self):
        catalog = Catalog()
        fitted = dict(fitted_rules(catalog.find("rules", "avoid_collision"), catalog))
        turning = {robot: rules.thresholds["turning"] for robot, rules in fitted.items()}
        assert "summit_xl" in turning
        for robot, gap in turning.items():  # closer than 0.26 m is what it may be wedged in
            assert (gap < 0.26) is robot.startswith("pioneer"), robot
