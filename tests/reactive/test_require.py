"""`require` of rules: rules that are inactive on robots without a signal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.actions import ACTIONS
from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import OPTIONAL_SIGNALS, Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.expression import Environment
from rocs_bt.reactive import RuleModel, add_test_files, choose_backend, load_rules, required_signals, run_tests
from rocs_bt.reactive.analysis import examine_rules

from .. import needs

WHEELS = [Signal("front", 2, (LENGTH,), (0.0, 10.0)), Signal("speed", 1, (SPEED,), (-2.0, 2.0))]
PLANAR = Environment.packed(WHEELS)
HOLONOMIC = Environment.packed([*WHEELS, OPTIONAL_SIGNALS["lateral_speed"], OPTIONAL_SIGNALS["course_range"]])

FILE = """format = "reflex/1"
[alias]
beside = "min(course_range, 1 m)"
[rule.Ahead]
when = "min(front) < 0.4 m"
until = "min(front) > 0.5 m"
priority = 10
action = { name = "TurnAngle", angle = "60 deg" }
[rule.Sideways]
require = ["lateral_speed", "course_range"]
when = "beside < 0.4 m and abs(lateral_speed) > 0.05 m/s"
until = "beside > 0.5 m"
priority = 20
action = { name = "Stop" }
[[rule.Sideways.test]]
given = { course_range = "0.3 m", lateral_speed = "0.3 m/s" }
at = [{ t = "0 s" }]
expect = [{ t = "0 s", fires = true }]
"""


@pytest.fixture
def load(tmp_path):
    """Load rules from their text, for a robot with wheels or another one."""

    def loaded(text=FILE, environment=PLANAR):
        file = tmp_path / "both.toml"
        file.write_text(text)
        return load_rules(file, environment, ACTIONS)

    return loaded


def faults_of(load, text, environment=PLANAR):
    with pytest.raises(InputError) as error:
        load(text, environment)
    return error.value.faults


def test_a_rule_is_active_only_on_robots_that_have_what_it_requires(load):
    rules = load(environment=HOLONOMIC)
    assert [rule.name for rule in rules.rules] == ["both/Ahead", "both/Sideways"]
    assert rules.inactive == ()
    assert [result.passed for result in run_tests(rules)] == [True]
    rules = load()
    assert [rule.name for rule in rules.rules] == ["both/Ahead"]
    (inactive,) = rules.inactive
    assert (inactive.name, inactive.missing) == ("both/Sideways", ("lateral_speed", "course_range"))
    assert (inactive.position.line, inactive.position.column) == (10, 1)
    assert run_tests(rules) == []
    one = Environment.packed([*WHEELS, OPTIONAL_SIGNALS["lateral_speed"]])
    assert load(environment=one).inactive[0].missing == ("course_range",)


def test_a_robot_with_the_signals_does_not_feel_the_difference(load):
    """A required signal that the robot has changes neither the rule nor its analysis."""
    plain = FILE.replace('require = ["lateral_speed", "course_range"]\n', "")
    required, free = load(environment=HOLONOMIC).rules, load(plain, HOLONOMIC).rules
    assert [list(rule.nodes()) for rule in required] == [list(rule.nodes()) for rule in free]
    assert examine_rules(free[0].positions[""].file, HOLONOMIC, ACTIONS).faults == []


def test_who_does_not_require_a_missing_signal_is_told_how(load):
    text = FILE[: FILE.index("[[")].replace('require = ["lateral_speed", "course_range"]\n', "")
    alias, direct = faults_of(load, text)  # one for each signal
    assert (alias.line, alias.column) == (10, 9)
    assert alias.message == "the robot has no signal 'course_range', which the alias 'beside' reads."
    assert alias.hint == 'With require = ["course_range"], a rule is inactive on robots that lack it.'
    assert (direct.line, direct.column) == (10, 32)
    assert direct.message == "the robot has no signal 'lateral_speed'."
    (fault,) = faults_of(load, FILE.replace("min(front) < 0.4 m", "beside < 0.4 m"))
    assert (fault.line, fault.column) == (5, 9)
    assert fault.message == "the robot has no signal 'course_range', which the alias 'beside' reads."
    assert fault.hint == 'With require = ["course_range"], a rule is inactive on robots that lack it.'
    (fault,) = faults_of(load, FILE.replace("min(front) < 0.4 m", "frnt < 0.4 m"))
    assert fault.hint.startswith("Did you mean 'front'?")


@pytest.mark.parametrize(
    ("written", "instead", "message"),
    [
        ('name = "Stop"', 'name = "Stpo"', "no action is named 'Stpo'"),
        ("lateral_speed", "lateral speed", "'lateral speed' is not a valid name of a signal"),
    ],
)
def test_faults_of_an_inactive_rule_that_need_no_signal_are_found(load, written, instead, message):
    text = FILE[: FILE.index("[[")].replace(written, instead)
    assert message in " ".join(fault.message for fault in faults_of(load, text))


def test_an_inactive_rule_ties_with_none_and_is_not_analysed(load):
    text = FILE.replace("priority = 20", "priority = 10").replace("beside < 0.4 m and", "beside < -4 m and")
    rules = load(text)
    assert [rule.name for rule in rules.rules] == ["both/Ahead"]
    file = rules.files[-1]
    assert examine_rules(file, PLANAR, ACTIONS).faults == []
    found = " ".join(fault.message for fault in examine_rules(file, HOLONOMIC, ACTIONS).faults)
    assert "same priority 10" in found
    assert "never holds" in found


def test_included_rules_and_their_aliases(load, tmp_path):
    (tmp_path / "common.toml").write_text(FILE[: FILE.index("[rule.Ahead]")])
    text = FILE.replace('[alias]\nbeside = "min(course_range, 1 m)"', 'include = ["common.toml"]')
    rules = load(text)
    assert [rule.name for rule in rules.inactive] == ["both/Sideways"]
    assert required_signals(rules.files[-1]) == {"lateral_speed", "course_range"}
    (tmp_path / "common.toml").write_text(FILE)
    again = 'format = "reflex/1"\ninclude = ["common.toml"]\n' + FILE[FILE.index("[rule.Sideways]") :]
    assert "already has a rule named 'Sideways'" in faults_of(load, again)[0].message
    assert required_signals(tmp_path / "nosuch.toml") == set()


def test_tests_in_a_file_of_their_own_are_skipped_too(load, tmp_path):
    (tmp_path / "tests").mkdir()
    apart = 'format = "reflex-tests/1"\n' + FILE[FILE.index("[[") :]
    (tmp_path / "tests/both.toml").write_text(apart)
    text = FILE[: FILE.index("[[")]
    rules, faults = add_test_files(load(text), PLANAR, ACTIONS)
    assert (run_tests(rules), faults) == ([], [])
    rules, faults = add_test_files(load(text, HOLONOMIC), HOLONOMIC, ACTIONS)
    assert ([result.passed for result in run_tests(rules)], faults) == ([True], [])
    (tmp_path / "tests/both.toml").write_text(apart.replace("Sideways", "Sidewise"))
    assert "Did you mean 'Sideways'" in " ".join(map(str, add_test_files(load(text), PLANAR, ACTIONS)[1]))


@pytest.mark.parametrize("backend", ["numpy", pytest.param("kernel", marks=needs.kernel)])
def test_a_file_without_an_active_rule_does_nothing(load, backend):
    rules = load(FILE[: FILE.index("[rule.Ahead]")] + FILE[FILE.index("[rule.Sideways]") :])
    assert (rules.rules, len(rules.inactive)) == ((), 1)
    model = RuleModel(rules, choose_backend(backend))
    model.enter("drive")
    for k in range(3):
        assert list(model.react(np.array([0.1, 0.1, 0.5]), 0.05 * k)) == []
    model.reset()
    x = np.zeros((3, 3))
    steps = choose_backend(backend).batch_time(model.table, x, np.array([0.0, 0.1, 0.2]), model.table.start())
    assert steps.winner.tolist() == [-1, -1, -1]


def test_an_active_set_can_replace_an_inactive_one_and_back(load):
    text = FILE[: FILE.index("[rule.Ahead]")] + FILE[FILE.index("[rule.Sideways]") :]
    model = RuleModel(load(text))
    near, far = np.array([0.1, 0.1, 0.5]), np.array([2.0, 2.0, 0.5])
    model.replace(load())
    assert [reflex.rule for reflex in model.react(near, 0.0)] == ["both/Ahead"]
    model.replace(load(text))
    assert list(model.react(near, 0.1)) == []
    model.replace(load())
    assert list(model.react(far, 0.2)) == []


RULE = """[rule.R{i}]
{require}when = "min(front) < {near} m"
until = "min(front) > {clear} m"
trigger = "{trigger}"
priority = {i}
[rule.R{i}.action]
name = "TurnAngle"
angle = "{i} deg"
"""


@given(
    st.lists(
        st.tuples(st.sampled_from(["", "lateral_speed", "climb"]), st.integers(1, 8), st.booleans()),
        min_size=1,
        max_size=6,
    ),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20),
)
def test_inactive_rules_are_as_if_they_were_not_written(tmp_path_factory, written, ranges):
    texts = [
        RULE.format(
            i=i,
            require=f'require = ["{name}"]\n' if name else "",
            near=f"0.{near}",
            clear=f"0.{near + 1}",
            trigger="level" if level else "edge",
        )
        for i, (name, near, level) in enumerate(written)
    ]
    has = Environment.packed([*WHEELS, OPTIONAL_SIGNALS["lateral_speed"]])
    kept = [text for text, (name, _, _) in zip(texts, written, strict=True) if name != "climb"]
    folder = tmp_path_factory.mktemp("rules")
    models = []
    for some in (texts, kept):
        file = folder / "r.toml"
        file.write_text('format = "reflex/1"\n' + "".join(some))
        if some:
            models.append(RuleModel(load_rules(read_toml(file), has, ACTIONS)))
    for k, near in enumerate(ranges):
        x = np.array([near, 1.0, 0.0, 0.0])
        found = [[(r.rule, r.parameters, r.latched) for r in model.react(x, 0.05 * k)] for model in models]
        assert found[0] == (found[1] if kept else [])
