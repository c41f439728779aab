"""rules/avoid_collision.toml on ranges by hand."""

from pathlib import Path

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS as SHIPPED_ACTIONS
from rocs_bt.expression import Environment
from rocs_bt.reactive import RuleModel, check_rules, load_rules
from rocs_bt.signal import Signal
from rocs_bt.units import LENGTH, SPEED

ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 3, (LENGTH,)) for name in ("front", "left_gap", "right_gap", "rear")),
        Signal("speed", 1, (SPEED,)),
        Signal("goal_distance", 1, (LENGTH,)),
    ]
)

SHIPPED = Path(__file__).parents[2] / "rules" / "avoid_collision.toml"


class TestShipped:
    """rules/avoid_collision.toml on ranges by hand."""

    def wanted(self, **changes):
        values = {
            "front": 1.0,
            "left_gap": 1.0,
            "right_gap": 1.0,
            "rear": 1.0,
            "goal_distance": 3.0,
            "speed": 0.3,
        } | changes
        x = np.array([v for n, s in ENVIRONMENT.signals.items() for v in [values.get(n, 0.0)] * s.size])
        model = RuleModel(load_rules(SHIPPED, ENVIRONMENT, SHIPPED_ACTIONS))
        model.react(x, 0.0)
        return {r.rule.rpartition("/")[2]: r.parameters for r in model.react(x, 1.0)}

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
        assert self.wanted(front=0.19)["Flinch"]["speed"] == -0.35
        assert self.wanted(rear=0.19)["Flinch"]["speed"] == 0.35
        assert self.wanted(left_gap=0.14)["Flinch"]["speed"] == -0.35
        assert "Flinch" not in self.wanted(left_gap=0.16)

    def test_between_two_things_it_stands_still(self):
        assert self.wanted(front=0.19, rear=0.24)["Flinch"]["speed"] == 0.0
        assert self.wanted(front=0.19, rear=0.26)["Flinch"]["speed"] == -0.35

    def test_blind_it_stands_still(self):
        for signal in ("front", "left_gap", "right_gap", "rear", "goal_distance"):
            assert self.wanted(**{signal: np.nan})["Blind"] == {"below": 0.0, "patience": 3600.0}
