"""Rule files: what loads, and what is refused; the messages are in tests/messages."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED, MetresPerSecond, Radians
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import load_rules, read_rules

ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 3, (LENGTH,)) for name in ("front", "left_gap", "right_gap", "rear")),
        Signal("speed", 1, (SPEED,)),
        Signal("goal_distance", 1, (LENGTH,)),
    ]
)


class Turn(AtomicAction):
    """Turns."""

    angle: Radians
    wheels: Annotated[Sequence[float], SPEED] = (0.0, 0.0)
    speed: MetresPerSecond = 0.5
    label: str = ""
    times: int = 1
    fast: bool = False
    until: Callable[[], bool] | None = None

    def act(self, body):
        return Progress.SUCCEEDED


ACTIONS = {"Turn": Turn}

GOOD = """format = "reflex/1"
doc = "Turns."

[alias]
gap = "min(left_gap)"

[rule.Turn]
doc = "Turns away."
tags = ["safety"]
when = "min(front) < 0.4 m and gap < 1 m"
until = "min(front) > 0.5 m"
for = "0.05 s"
cooldown = "0.5 s"
trigger = "edge"
priority = 5
on_invalid = "trip"

[rule.Turn.action]
name = "Turn"
angle = "60 deg * side(gap - min(right_gap))"
wheels = ["speed", "0.1 m/s"]
label = "hello"
times = 2
fast = true

[rule.Turn.action.on_invalid]
angle = "60 deg"
"""


def write(tmp_path, text):
    file = tmp_path / "turn.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_good_file_loads_with_all_its_parts(tmp_path):
    rules = load_rules(write(tmp_path, GOOD), ENVIRONMENT, ACTIONS)
    (rule,) = rules.rules
    assert (rules.name, rules.doc, rule.name, rule.doc) == ("turn", "Turns.", "turn/Turn", "Turns away.")
    assert (rule.hold, rule.cooldown, rule.level, rule.priority, rule.tags) == (0.05, 0.5, False, 5, ("safety",))
    x = [0.3] * 3 + [0.2] * 3 + [0.9] * 3 + [1.0] * 3 + [0.7, 5.0]
    parameters = rule.parameters(x, blind=False)
    assert parameters.pop("angle") == pytest.approx(-np.pi / 3)
    assert parameters == {"wheels": [0.7, 0.1], "label": "hello", "times": 2, "fast": True}
    assert read_rules(write(tmp_path, GOOD), ENVIRONMENT, ACTIONS)[1] == []


def test_all_ties_are_told_at_once(tmp_path):
    def rule(name, angle):
        return f'[rule.{name}]\nwhen = "speed > 1 m/s"\npriority = 5\naction = {{ name = "Turn", angle = "{angle}" }}\n'

    angles = {"A": "1 rad", "B": "2 rad", "C": "1 rad", "D": "3 rad", "E": "2 rad", "F": "4 rad"}
    file = write(tmp_path, 'format = "reflex/1"\n' + "".join(rule(*each) for each in angles.items()))
    with pytest.raises(InputError) as caught:
        load_rules(file, ENVIRONMENT, ACTIONS)
    told = [(fault.line, fault.message.partition(" has the same priority 5 as ")) for fault in caught.value.faults]
    assert [(line, rule, rest) for line, (rule, _, rest) in told] == [
        (8, "B", "A, but another action."),
        (12, "C", "B, but another action."),  # and does what A does
        (16, "D", "A, B and C, but another action."),
        (20, "E", "A, C and D, but another action."),
        (24, "F", "A, B, C and others, but another action."),
    ]


def test_there_is_no_tie_between_modes(tmp_path):
    def rule(name, angle, modes):
        guard, action = 'when = "speed > 1 m/s"\npriority = 5', f'action = {{ name = "Turn", angle = "{angle}" }}'
        return f"[rule.{name}]\n{guard}\n{modes}\n{action}\n"

    drive, dock = rule("A", "1 rad", 'modes = ["drive"]'), rule("B", "2 rad", 'modes = ["dock", "park"]')
    head = 'format = "reflex/1"\n' + drive + dock
    assert len(load_rules(write(tmp_path, head), ENVIRONMENT, ACTIONS).rules) == 2
    for modes, others in (("", "A and B"), ('modes = ["park"]', "B"), ('modes = ["haul", "drive"]', "A")):
        with pytest.raises(InputError, match=f"C has the same priority 5 as {others}, but") as caught:
            load_rules(write(tmp_path, head + rule("C", "3 rad", modes)), ENVIRONMENT, ACTIONS)
        assert len(caught.value.faults) == 1


def test_a_file_without_rules_and_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="the file has no rule"):
        load_rules(write(tmp_path, 'format = "reflex/1"\n'), ENVIRONMENT, ACTIONS)
    with pytest.raises(InputError, match="cannot read the file"):
        load_rules(tmp_path / "none.toml", ENVIRONMENT, ACTIONS)


def test_a_table_that_was_read_already_loads_too():
    table = read_toml(Path("given.toml"), GOOD)
    assert load_rules(table, ENVIRONMENT, ACTIONS).rules[0].name == "given/Turn"
