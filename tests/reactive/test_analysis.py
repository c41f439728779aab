"""Static checks of rules: for each a file with the fault and one without; tests/messages has the faults of reading."""

import re

import pytest

from rocs_bt.actions import ACTIONS as SHIPPED_ACTIONS
from rocs_bt.agent.build import thresholds
from rocs_bt.catalog import Catalog
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.expression import Environment
from rocs_bt.reactive import load_rules, read_rules
from rocs_bt.reactive.analysis import analyse_fit, analyse_rules, examine_rules, prover

from .examined import ACTIONS, ENVIRONMENT, FAR, NEAR, A, at, faults_of, file_of

# What it is about; the file with the fault; where; what the message says; the file without.
CASES = [
    (
        "never",
        file_of((A, 'when = "speed > 2 m/s"')),
        "3:9",
        r"guard of A never holds, where speed is between -1 m/s and 1.5 m/s; with speed = \S+ m/s, for ex",
        file_of((A, 'when = "speed > 1.4 m/s"')),
    ),
    (
        "never, of several signals",
        file_of((A, 'when = "max(front) < min(front)"')),
        "3:9",
        r"guard of A never holds",
        file_of((A, 'when = "max(front) < 2 * min(rear)"')),
    ),
    (
        "never, for what is invalid",
        file_of((A, 'when = "min(front) < 0 m"', 'on_invalid = "clear"')),
        "3:9",
        r"guard of A never holds",
        file_of((A, 'when = "min(front) < 0 m"', 'on_invalid = "trip"')),
    ),
    (
        "always",
        file_of((A, 'when = "speed < 2 m/s or min(front) < 0.4 m"')),
        "3:9",
        r"guard of A always holds",
        file_of((A, 'when = "speed < 1 m/s or min(front) < 0.4 m"')),
    ),
    (
        "threshold beyond the bounds",
        file_of((A, 'when = "min(front) < 0.4 m and speed < 1.6 m/s"')),
        "3:32",
        r"in the when of A 'speed < 1.6 m/s' always holds, where speed is between -1 m/s and 1.5 m/s",
        file_of((A, 'when = "min(front) < 0.4 m and speed < 1.4 m/s"')),
    ),
    (
        "threshold beyond the bounds, in an alias",
        file_of((A, 'when = "min(front) < 0.4 m and fast"'), head='[alias]\nfast = "tags > 9 or speed > 1 m/s"\n'),
        "5:32",
        r"in the when of A 'tags > 9' never holds",
        file_of((A, 'when = "min(front) < 0.4 m and fast"'), head='[alias]\nfast = "tags > 7 or speed > 1 m/s"\n'),
    ),
    (
        "hysteresis upside down",
        file_of((A, NEAR, 'until = "min(front) > 0.3 m"')),
        "4:10",
        r"when and until of A hold at once.*with front\[0\] = 0.3\d* m, each other front = \d",
        file_of((A, NEAR, FAR)),
    ),
    (
        "hysteresis upside down, of two signals",
        file_of(
            (
                A,
                'when = "min(front) < min(0.4 m, goal_distance)"',
                'until = "min(front) > min(0.5 m, goal_distance - 0.1 m)"',
            )
        ),
        "4:10",
        r"when and until of A hold at once",
        file_of(
            (
                A,
                'when = "min(front) < min(0.4 m, goal_distance)"',
                'until = "min(front) > min(0.5 m, goal_distance + 0.1 m)"',
            )
        ),
    ),
    (
        "never released",
        file_of((A, NEAR, 'until = "speed > 1.5 m/s"')),
        "4:10",
        r"until of A never holds",
        file_of((A, NEAR, 'until = "speed > 1 m/s and min(front) > 0.5 m"')),
    ),
    (
        "shadowed",
        file_of((A, 'when = "min(front) < 0.3 m and speed > 0 m/s"', "priority = 4"), ("B", NEAR, "priority = 9")),
        "3:9",
        r"A never acts: .* so is B, .*priority of 9, .*with front\[0\] = 0.1 m, each other front = 1 m, speed = 1",
        file_of((A, 'when = "min(front) < 0.3 m and speed > 0 m/s"', "priority = 9"), ("B", NEAR, "priority = 4")),
    ),
    (
        "shadowed by what fires at once",
        file_of((A, 'when = "min(front) < 0.3 m"', "priority = 4"), ("B", NEAR, "priority = 9")),
        "3:9",
        "A never acts",
        file_of((A, 'when = "min(front) < 0.3 m"', "priority = 4"), ("B", NEAR, "priority = 9", 'for = "1 s"')),
    ),
    (
        "shadowed in all of its modes",
        file_of(
            (A, NEAR, "priority = 4", 'modes = ["dock"]'), ("B", NEAR, "priority = 9", 'modes = ["dock", "drive"]')
        ),
        "3:9",
        "A never acts",
        file_of((A, NEAR, "priority = 4"), ("B", NEAR, "priority = 9", 'modes = ["dock", "drive"]')),
    ),
    (
        "shadowed until the end",
        file_of((A, NEAR, FAR, "priority = 4"), ("B", NEAR, 'until = "min(front) > 0.6 m"', "priority = 9")),
        "3:9",
        "A never acts",
        file_of((A, NEAR, FAR, "priority = 4"), ("B", NEAR, 'until = "min(front) > 0.45 m"', "priority = 9")),
    ),
    (
        "tied",
        file_of((A, NEAR), ("B", 'when = "speed > 1 m/s"', 'action: name = "Go"')),
        "9:1",
        r"B has the same priority 5 as A, but .* A and B both hold, .* each other front = 1 m, speed = 1.4 m/s",
        file_of((A, NEAR), ("B", 'when = "speed > 1 m/s"', 'action: name = "Go"', "priority = 6")),
    ),
    (
        "cooldown shorter than for",
        file_of((A, NEAR, 'for = "0.5 s"', 'cooldown = "0.2 s"')),
        "5:1",
        r"cooldown of A, 0.2 s, has no effect.*cannot fire before 0.5 s",
        file_of((A, NEAR, 'for = "0.5 s"', 'cooldown = "0.7 s"')),
    ),
    (
        "trips at every start",
        file_of((A, 'when = "speed > 1.2 m/s or rate(speed, 0.5 s) < -3 m/s2"', 'on_invalid = "trip"')),
        "3:28",
        r"'rate\(speed, 0.5 s\)' in the when of A is invalid for the first 0.5 s .* latches the rule at 0 s",
        file_of((A, 'when = "speed > 1.2 m/s or rate(speed, 0.5 s) < -3 m/s2"', 'on_invalid = "clear"')),
    ),
    (
        "chatter",
        file_of((A, NEAR, 'trigger = "level"')),
        "3:9",
        r"A chatters .*front\[0\] = 0.39\d+ m, each other front = 1 m it is on, with front\[0\] = 0.4\d* m off",
        file_of((A, NEAR, FAR, 'trigger = "level"')),
    ),
    (
        "parameter out of bounds",
        file_of((A, NEAR, 'action: patience = "(speed + 0.5 m/s) * 1 s2/m"')),
        "7:13",
        r"patience of Turn must be positive and finite, but in A '.*' can be out of these bounds.*speed = -1 m/s",
        file_of((A, NEAR, 'action: patience = "max(speed + 0.5 m/s, 0.1 m/s) * 1 s2/m"')),
    ),
    (
        "parameter out of bounds while latched",
        file_of(
            (
                A,
                'when = "speed > 0 m/s"',
                'until = "speed < -0.1 m/s"',
                'action: patience = "(speed + 0.05 m/s) * 1 s2/m"',
            )
        ),
        "8:13",
        r"patience of Turn must be positive",
        file_of(
            (
                A,
                'when = "speed > 0 m/s"',
                'until = "speed < -0.1 m/s"',
                'action: patience = "(speed + 0.2 m/s) * 1 s2/m"',
            )
        ),
    ),
    (
        "infinite parameter",
        file_of((A, 'when = "min(rear) < 1 m"', 'action: speeds = ["front[0] / 1 s", "0 m/s"]')),
        "7:1",
        r"speeds of Turn must be finite, but .* 'front\[0\] / 1 s' can be out of .* with front\[0\] = inf m",
        file_of((A, 'when = "min(rear) < 1 m"', 'action: speeds = ["min(front[0], 1 m) / 1 s", "0 m/s"]')),
    ),
]

FIT_CASES = [
    (
        "max_age below the period",
        file_of((A, 'when = "min(front) < 0.4 m and turn_rate > 1 rad/s"')),
        "3:32",
        r"A reads turn_rate with a max_age of 0.01 s, less than the control period of 0.05 s",
        file_of((A, NEAR)),
    ),
    (
        "window below the period",
        file_of((A, 'when = "speed > 1 m/s and held(min(front) < 0.4 m, 0.02 s)"')),
        "3:27",
        r"the window of 'held\(min\(front\) < 0.4 m, 0.02 s\)' is 0.02 s, shorter than the control period of 0.05 s",
        file_of((A, 'when = "held(min(front) < 0.4 m, 0.2 s)"')),
    ),
    (
        "dead mode",
        file_of((A, NEAR, 'modes = ["dokc"]')),
        "4:1",
        r"A is active in the mode 'dokc', which the mission never sets, so it never acts",
        file_of((A, NEAR, 'modes = ["dock"]')),
    ),
]


@pytest.mark.parametrize(("wrong", "place", "words", "right"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_each_fault_is_told_at_its_place(tmp_path, wrong, place, words, right):
    faults = faults_of(tmp_path, wrong)
    assert [at(fault) for fault in faults] == [place], faults
    assert re.search(words, str(faults[0]))
    assert faults[0].hint or faults[0].file
    assert faults_of(tmp_path, right) == []


@pytest.mark.parametrize(
    ("wrong", "place", "words", "right"), [c[1:] for c in FIT_CASES], ids=[c[0] for c in FIT_CASES]
)
def test_each_misfit_is_told_at_its_place(tmp_path, wrong, place, words, right):
    (fault,) = faults_of(tmp_path, wrong, 0.05, {"dock", "drive"})
    assert at(fault) == place
    assert re.search(words, str(fault))
    assert fault.warning
    assert fault.hint
    assert faults_of(tmp_path, right, 0.05, {"dock", "drive"}) == []


def test_all_faults_of_a_file_are_told_at_once(tmp_path):
    text = file_of(
        (A, 'when = "min(frnt) < 0.4 m"'),
        ("B", 'when = "speed > 2 m/s"', "priority = 6", 'for = "1 s"', 'cooldown = "0.5 s"'),
        ("C", NEAR, 'until = "min(front) > 0.3 m"', "priority = 7", 'action: name = "Trun"'),
        head='[alias]\nnear = "min(front)"\n',
    )
    found = [(at(fault), fault.warning) for fault in faults_of(tmp_path, text)]
    assert sorted(found) == [
        ("10:9", True),
        ("13:1", True),
        ("18:10", True),
        ("21:1", False),
        ("3:1", True),
        ("5:13", False),
    ]


def test_rules_that_are_wrong_themselves_are_not_examined(tmp_path):
    (fault,) = faults_of(tmp_path, file_of((A, NEAR, 'until = "min(frnt) > 0.3 m"', 'trigger = "level"')))
    assert not fault.warning


def test_included_rules_are_told_in_their_own_file(tmp_path):
    (tmp_path / "common.toml").write_text(file_of(("B", 'when = "speed > 2 m/s"')), encoding="utf-8")
    (fault,) = faults_of(tmp_path, file_of((A, NEAR, "priority = 6"), head='include = ["common.toml"]\n'))
    assert (fault.file.name, at(fault)) == ("common.toml", "3:9")


def test_a_file_that_cannot_be_read_is_told():
    (fault,) = examine_rules(Catalog().shipped / "none.toml", ENVIRONMENT, ACTIONS).faults
    assert not fault.warning


# Of these, z3 knows only the range.
UNDECIDABLE = [
    ('when = "once(speed > 1 m/s, 2 s) and speed < 0.5 m/s"', "once(speed > 1 m/s, 2 s)"),
    ('when = "atan2(front[0], front[1]) < 0 rad"', "atan2(front[0], front[1])"),
]


@pytest.mark.parametrize(("guard", "named"), UNDECIDABLE)
def test_what_cannot_be_decided_is_said_as_a_note(tmp_path, guard, named):
    (fault,) = faults_of(tmp_path, file_of((A, guard)))
    assert fault.note
    assert fault.warning
    assert at(fault) == "3:9"
    assert str(fault).partition("3:9: ")[2].startswith("note: cannot decide whether the guard of A ever holds: ")
    assert named in fault.message


PARTS = " + ".join(
    f"max(front[{i % 4}] * 1.{i}, rear[{i % 2}] * 2.{i}, min(goal_distance * 1.{i}, 3.{i} m))" for i in range(9)
)
MANY_CASES = f'when = "{PARTS} < 1 m and goal_distance > 0.7 m"', f'until = "{PARTS} > 1.5 m and front[0] > 0.8 m"'


def test_sums_of_many_parts_with_cases_are_decided(tmp_path):
    (fault,) = faults_of(tmp_path, file_of((A, *MANY_CASES)))
    assert fault.message.startswith("the guard of A never holds, ")


def test_too_many_steps_are_said_with_their_number(tmp_path, monkeypatch):
    monkeypatch.setattr(prover, "STEPS", 100)
    notes = faults_of(tmp_path, file_of((A, *MANY_CASES)))
    assert notes
    assert all(note.note and "it takes more than 100 steps" in note.message for note in notes)


def test_a_tie_with_a_rule_that_is_tied_itself_is_shown_where_both_hold(tmp_path):
    """A never holds with C, so an example has to be of B and C."""
    faults = faults_of(
        tmp_path,
        file_of(
            (A, 'when = "speed > 1 m/s"'),
            ("B", 'when = "min(front) < 1 m"', 'action: name = "Go"'),
            ("C", 'when = "speed < 0 m/s"', 'action: angle = "2 rad"'),
        ),
    )
    assert [at(fault) for fault in faults] == ["9:1", "14:1"]
    assert re.search("B has the same priority 5 as A, but .* A and B both hold", faults[0].message)
    assert re.search("C has the same priority 5 as A and B, but .* B and C both hold", faults[1].message)


LACKS = re.compile(
    r"^no signal or alias is named |, so there is no \w+\[\d+\]\.$| is empty or beyond the \d+ values of "
)
"""The robot has no such sensor, or one with fewer beams: the rules are not for it."""


def robots_and_rules():
    catalog = Catalog()
    return [(robot.name, rules.name) for robot in catalog.list("robot") for rules in catalog.list("rules")]


@pytest.mark.parametrize(("robot", "rules"), robots_and_rules())
def test_shipped_rules_are_clean_for_every_shipped_robot(robot, rules):
    catalog = Catalog()
    spec = catalog.load_robot(robot)
    environment = Environment.of(stub_agent(spec, catalog.load_class).knowledge.signals, spec.constants)
    file = catalog.find("rules", rules).path
    own = thresholds(spec, file)
    if unfit := [
        fault for fault in read_rules(file, environment, SHIPPED_ACTIONS, overrides=own)[1] if not fault.warning
    ]:
        assert all(LACKS.search(fault.message) for fault in unfit)
        return
    assert examine_rules(file, environment, SHIPPED_ACTIONS, own).faults == []
    loaded = load_rules(file, environment, SHIPPED_ACTIONS, overrides=own).rules
    assert analyse_fit(loaded, environment, 0.05) == []


def test_no_rules_are_no_fault():
    assert analyse_rules([], ENVIRONMENT, ACTIONS) == []
