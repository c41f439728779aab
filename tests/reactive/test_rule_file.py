"""Rule files: what loads, and what each kind of mistake is told as, with its place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.actions import ACTIONS as SHIPPED_ACTIONS
from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED, MetresPerSecond, Radians, Seconds
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import check_rules, load_rules

ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 3, (LENGTH,)) for name in ("front", "left_gap", "right_gap", "rear")),
        Signal("speed", 1, (SPEED,)),
        Signal("goal_distance", 1, (LENGTH,)),
    ]
)


@dataclass(kw_only=True, eq=False)
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


@dataclass(kw_only=True, eq=False)
class AvoidCollision(AtomicAction):
    """As the shipped one."""

    turn: Radians
    speed: MetresPerSecond = 0.25
    duration: Seconds = 2.0

    def act(self, body):
        return Progress.SUCCEEDED


@dataclass(kw_only=True, eq=False)
class Flinch(AtomicAction):
    """As the shipped one."""

    speed: MetresPerSecond
    distance: Annotated[float, LENGTH] = 0.08
    timeout: Seconds = 1.5

    def act(self, body):
        return Progress.SUCCEEDED


@dataclass(kw_only=True, eq=False)
class Stop(AtomicAction):
    """As the shipped one."""

    below: MetresPerSecond = 0.02
    patience: Seconds = 1.0

    def act(self, body):
        return Progress.SUCCEEDED


ACTIONS = {"Turn": Turn, "AvoidCollision": AvoidCollision, "Flinch": Flinch, "Stop": Stop}

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
    assert check_rules(write(tmp_path, GOOD), ENVIRONMENT, ACTIONS) == []


MISTAKES = [
    # what to replace, by what, line, column, a piece of the message
    ('"reflex/1"', '"reflex/9"', 1, 1, "invalid value 'reflex/9' for 'format'. Did you mean 'reflex/1'?"),
    ('format = "reflex/1"\n', "", 0, 0, "the file has no 'format'"),
    ("min(left_gap)", "min(left_gab)", 5, 12, "no signal or alias is named 'left_gab'. Did you mean 'left_gap'?"),
    ("gap = ", "front = ", 5, 1, "'front' cannot be an alias"),
    ("gap = ", "deg = ", 5, 1, "'deg' cannot be an alias"),
    ("min(front) < 0.4 m", "min(frnt) < 0.4 m", 10, 13, "no signal or alias is named 'frnt'. Did you mean 'front'?"),
    ("0.4 m and", "0.4 m/s and", 10, 9, "min(front) is in m and 0.4 m/s is in m/s"),
    ("0.4 m and", "0.4 and", 10, 9, "Write the number with its unit"),
    ("gap < 1 m", "gap", 10, 9, "'and' needs true or false, but gap is in m"),
    ('"min(front) > 0.5 m"', '"min(front)"', 11, 10, "'until' must be true or false, but min(front) is in m"),
    ('"min(front) > 0.5 m"', '"front > 0.5 m"', 11, 10, "'until' must be true or false, but front > 0.5 m is 3 values"),
    ('"min(front) > 0.5 m"', "3", 11, 1, "until must be a text, found 3"),
    ('when = "min', 'whem = "min', 7, 1, "rule.Turn has no 'when'"),
    ('when = "min', 'whem = "min', 10, 1, "unknown key 'whem' in rule.Turn. Did you mean 'when'?"),
    ('for = "0.05 s"', 'for = "0.05 m"', 12, 1, "for must be in s, found '0.05 m' which is in m"),
    ('for = "0.05 s"', "for = 0.05", 12, 1, "for needs a unit, found the bare number 0.05"),
    ('"0.5 s"', '"-1 s"', 13, 1, "cooldown must be at least 0 s, found '-1 s'"),
    ('"edge"', '"egde"', 14, 1, "invalid value 'egde' for 'trigger'. Did you mean 'edge'?"),
    ("priority = 5", 'priority = "high"', 15, 1, "priority must be a whole number, found 'high'"),
    ("priority = 5\n", "", 7, 1, "rule.Turn has no 'priority'"),
    ('on_invalid = "trip"\n', "", 7, 1, "Turn has the tag safety, so it must declare 'on_invalid'"),
    ('"trip"', '"tripp"', 16, 1, "invalid value 'tripp' for 'on_invalid'. Did you mean 'trip'?"),
    ('"trip"', '"hold"', 16, 1, "Turn holds while its guard is invalid, but has no 'max_hold'"),
    ('"trip"', '"trip"\nmax_hold = "1 s"', 17, 1, "max_hold of Turn has no effect"),
    ('"trip"', '"trip"\nkeep = ["angel"]', 17, 1, "no parameter of the action is named 'angel'. Did you mean 'angle'?"),
    ('"trip"', '"trip"\nkeep = "angle"', 17, 1, "keep must be a list of texts"),
    ('name = "Turn"', 'name = "Trun"', 19, 1, "no action is named 'Trun'. Did you mean 'Turn'?"),
    ('name = "Turn"\n', "", 18, 1, "rule.Turn.action has no 'name'"),
    ("angle = \"60 deg *", "angel = \"60 deg *", 20, 1, "no parameter of Turn is named 'angel'. Did you mean 'angle'?"),
    ("angle = \"60 deg *", "angel = \"60 deg *", 19, 1, "Turn needs angle. It takes: angle, wheels"),
    ("60 deg * side", "0.6 m * side", 20, 10, "'angle' must be one number in rad, but 0.6 m * side"),
    ("60 deg * side(gap", "60 deg * site(gap", 20, 19, "no function is named 'site'"),
    ('["speed", "0.1 m/s"]', '["speed", "0.1 m"]', 21, 21, "'wheels' must be one number in m/s, but 0.1 m is in m"),
    ('["speed", "0.1 m/s"]', '"speed"', 21, 1, "'wheels' must be a list of numbers in m/s, found 'speed'"),
    ('["speed", "0.1 m/s"]', "[0.1]", 21, 1, "'wheels' needs a unit, found the bare number 0.1"),
    ('"hello"', "5", 22, 1, "'label' must be a text, found 5"),
    ("times = 2", "times = true", 23, 1, "'times' must be a whole number, found True"),
    ("fast = true", 'until = "true"', 24, 1, "'until' cannot be given in a rule file"),
    ("fast = true", 'speed = "1 m/s / 0"', 24, 1, "'speed' has no value"),
    ('on_invalid]\nangle = "60 deg"', 'on_invalid]\nangle = "60 m"', 27, 1, "'angle' must be in rad, found '60 m'"),
    ('on_invalid]\nangle = "60 deg"', 'on_invalid]\nangel = "60 deg"', 27, 1, "no parameter of Turn is named 'angel'"),
    ('on_invalid]\nangle = "60 deg"', "on_invalid]", 20, 1, "'angle' reads signals, so it can be invalid"),
    ("[rule.Turn]", "[rule.Turn]\nmode = 'x'", 8, 1, "unknown key 'mode' in rule.Turn. Did you mean 'modes'?"),
    ("[rule.Turn]", "[rule.Turn]\nmodes = []", 8, 1, "modes is empty, so the rule would never be active"),
    ("[rule.Turn]", "[rule.Turn]\nmodes = ['a b']", 8, 1, "'a b' cannot be the name of a mode"),
    ("priority = 5", "priority = 999999999999999999", 15, 1, "priority must be between -1000000 and 1000000"),
    ("[rule.Turn]", "[rule.'Turn it']\n[rule.Turn]", 7, 1, "'Turn it' cannot be a rule's name"),
    ("gap = ", "not = ", 5, 1, "'not' cannot be an alias"),
    ("[alias]", "[alias", 4, 7, "not valid TOML"),
    ("[rule.Turn]", "[rule.Turn]\n[rule.Turn]", 8, 11, "not valid TOML"),
]  # fmt: skip  # a table


@pytest.mark.parametrize(("old", "new", "line", "column", "message"), MISTAKES)
def test_mistakes(tmp_path, old, new, line, column, message):
    assert GOOD.count(old) >= 1
    file = write(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_rules(file, ENVIRONMENT, ACTIONS)
    told = [str(f) for f in caught.value.faults]
    place = f"{file}:{line}:{column}: " if line else f"{file}: "
    assert any(t.startswith(place) and message in t for t in told), told
    assert [str(f) for f in check_rules(file, ENVIRONMENT, ACTIONS)] == told


SANE = """format = "reflex/1"
[rule.Back]
when = "speed > 1 m/s"
priority = 1
[rule.Back.action]
name = "Flinch"
speed = "-0.35 m/s"
distance = "0.08 m"
timeout = "1.5 s"
[rule.Back.action.on_invalid]
distance = "0.02 m"
[rule.Turn]
when = "speed > 2 m/s"
priority = 2
[rule.Turn.action]
name = "AvoidCollision"
turn = "60 deg"
duration = "1.5 s"
rate = "2.5 rad/s"
[rule.Wheels]
when = "speed > 3 m/s"
priority = 3
[rule.Wheels.action]
name = "SetWheelSpeed"
speeds = ["0.1 m/s", "0.1 m/s * speed / 1 m/s"]
[rule.Wheels.action.on_invalid]
speeds = ["0 m/s", "0.1 m/s"]
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ('"2.5 rad/s"', '"-2.5 rad/s"', 19, "rate of AvoidCollision must be positive and finite, found -2.5 rad/s."),
        ('"2.5 rad/s"', '"1 rad/s - 1 rad/s"', 19, "rate of AvoidCollision must be positive and finite, found 0 "),
        ('duration = "1.5 s"', 'duration = "-1.5 s"', 18, "duration of AvoidCollision must be positive and finite"),
        ('timeout = "1.5 s"', 'timeout = "0 s"', 9, "timeout of Flinch must be positive and finite, found 0 s."),
        ('"0.08 m"', '"inf m"', 8, "distance of Flinch must be positive and finite, found inf m."),
        ('"0.02 m"', '"-1 m"', 11, "distance of Flinch must be positive and finite, found -1 m."),
        ('"-0.35 m/s"', '"inf m/s"', 7, "speed of Flinch must be finite, found inf m/s."),
        ('["0.1 m/s", "0.1 m/s *', '["inf m/s", "0.1 m/s *', 25, "speeds of SetWheelSpeed must be finite, found inf"),
        ('["0 m/s", "0.1', '["0 m/s", "-inf', 27, "speeds of SetWheelSpeed must be finite, found -inf m/s."),
    ],
)
def test_what_an_action_cannot_do_is_refused_where_it_stands(tmp_path, old, new, line, message):
    assert load_rules(write(tmp_path, SANE), ENVIRONMENT, SHIPPED_ACTIONS).rules
    assert SANE.count(old) == 1
    file = write(tmp_path, SANE.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_rules(file, ENVIRONMENT, SHIPPED_ACTIONS)
    (fault,) = caught.value.faults
    assert str(fault).startswith(f"{file}:{line}:1: {message}")


def test_a_wrong_unit_is_told_once(tmp_path):
    with pytest.raises(InputError) as caught:
        load_rules(write(tmp_path, SANE.replace('"0.02 m"', '"0.02 s"')), ENVIRONMENT, SHIPPED_ACTIONS)
    assert len(caught.value.faults) == 1


def test_all_faults_are_told_at_once(tmp_path):
    broken = GOOD.replace("min(front)", "min(frnt)").replace('"0.05 s"', '"0.05 m"').replace('"edge"', '"egde"')
    with pytest.raises(InputError) as caught:
        load_rules(write(tmp_path, broken), ENVIRONMENT, ACTIONS)
    assert [f.line for f in caught.value.faults] == [10, 12, 14]  # one fault for each signal


def test_a_tie_is_refused_unless_the_actions_are_equal(tmp_path):
    def rule(name, angle):
        return f'[rule.{name}]\nwhen = "speed > 1 m/s"\npriority = 5\naction = {{ name = "Turn", angle = "{angle}" }}\n'

    head = 'format = "reflex/1"\n'
    load_rules(write(tmp_path, head + rule("A", "1 rad") + rule("B", "1 rad")), ENVIRONMENT, ACTIONS)
    file = write(tmp_path, head + rule("A", "1 rad") + rule("B", "2 rad"))
    with pytest.raises(InputError, match=r"turn.toml:8:1: B has the same priority 5 as A, but another action\."):
        load_rules(file, ENVIRONMENT, ACTIONS)


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


def test_an_action_is_a_table(tmp_path):
    text = 'format = "reflex/1"\n[rule.A]\nwhen = "True"\npriority = 1\naction = "Turn"\n'
    with pytest.raises(InputError, match=r"turn.toml:5:1: action must be a table, found 'Turn'"):
        load_rules(write(tmp_path, text), ENVIRONMENT, ACTIONS)
    with pytest.raises(InputError, match=r"turn.toml:2:1: rule.A has no 'action'"):
        load_rules(write(tmp_path, text.replace('action = "Turn"', "")), ENVIRONMENT, ACTIONS)


def test_a_file_without_rules_and_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="the file has no rule"):
        load_rules(write(tmp_path, 'format = "reflex/1"\n'), ENVIRONMENT, ACTIONS)
    (fault,) = check_rules(tmp_path / "none.toml", ENVIRONMENT, ACTIONS)
    assert "cannot read the file" in fault.message


def test_a_table_that_was_read_already_loads_too():
    table = read_toml(Path("given.toml"), GOOD)
    assert load_rules(table, ENVIRONMENT, ACTIONS).rules[0].name == "given/Turn"


def test_the_column_points_into_an_inline_table(tmp_path):
    text = """format = "reflex/1"
[rule.A]
when = "speed > 1 m/s"
priority = 1
action = { name = "Turn", angle = "1 rad * sied(speed)" }
"""
    with pytest.raises(InputError, match=r"turn.toml:5:44: no function is named 'sied'"):
        load_rules(write(tmp_path, text), ENVIRONMENT, ACTIONS)


junk = st.sampled_from(
    ["", "0", '"', "[", "]", "=", "nan", "true", "{}", '"x"', "\n", "min(", "m/s", "\\", "é", "..", "-"]
)


@settings(max_examples=300, deadline=None)
@given(st.integers(0, len(GOOD)), st.integers(0, 12), st.one_of(junk, st.text(max_size=8)))
def test_a_mutilated_file_is_loaded_or_refused(at, cut, put):
    text = GOOD[:at] + put + GOOD[at + cut :]
    try:
        load_rules(read_toml(Path("fuzz.toml"), text), ENVIRONMENT, ACTIONS)
    except InputError as error:
        assert error.faults


words = st.sampled_from(["", "front", "min(front) < 1 m", "1 m", "Turn", "trip"])
values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-5, 5), st.floats(), words),
    lambda inner: st.one_of(
        st.lists(inner, max_size=2), st.dictionaries(st.sampled_from(["name", "angle", "x"]), inner, max_size=2)
    ),
    max_leaves=4,
)
KEYS = [
    "when",
    "until",
    "for",
    "cooldown",
    "trigger",
    "priority",
    "on_invalid",
    "max_hold",
    "keep",
    "action",
    "tags",
    "doc",
    "x",
]


@settings(max_examples=200, deadline=None)
@given(st.dictionaries(st.sampled_from(KEYS), values, max_size=8))
def test_any_value_at_any_key_is_loaded_or_refused(rule):
    def toml(value):
        if value is None:
            return '"None"'
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, list):
            return f"[{', '.join(map(toml, value))}]"
        if isinstance(value, dict):
            return "{" + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + "}"
        return f'"{value}"' if isinstance(value, str) else repr(value)

    text = 'format = "reflex/1"\n[rule.A]\n' + "".join(f"{k} = {toml(v)}\n" for k, v in rule.items())
    try:
        load_rules(read_toml(Path("fuzz.toml"), text), ENVIRONMENT, ACTIONS)
    except InputError as error:
        assert error.faults
