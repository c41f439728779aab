"""docs/rules.md: its examples give what they say, its rule files pass their own tests, its requirements load."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.signal import OPTIONAL_SIGNALS, Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED, TURN_RATE, Quantity
from rocs_bt.base.words import inactive_rule
from rocs_bt.catalog import Catalog
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.expression import (
    FUNCTIONS,
    MAX_DEPTH,
    MAX_LENGTH,
    MAX_SIZE,
    Environment,
    compile_expression,
    parse_requirement,
)
from rocs_bt.reactive import load_rules, run_tests
from rocs_bt.reactive.analysis import examine_rules
from rocs_bt.record import TRUTH

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "rules.md").read_text("utf-8")
COURSE = PAGE[PAGE.index("## A course of six") : PAGE.index("## Test, replay, tune and watch rules")]
FILES = re.findall(r"### \d\. ([^\n]+)\n.*?```toml\n(.*?)```", COURSE, re.DOTALL)
SIGNALS = (
    Signal("front", 3, (LENGTH,)),
    Signal("rear", 1, (LENGTH,)),
    Signal("speed", 1, (SPEED,)),
    Signal("turn_rate", 1, (TURN_RATE,)),
    Signal("goal_distance", 1, (LENGTH,)),
    Signal("pose", 3, (LENGTH, LENGTH, ANGLE)),
)
TRACE = [
    (0.1 * k, np.array([round(1.0 - 0.1 * k, 3), 0.8, 2.0, 1.0, 0.4, 0.5, math.inf, 1.0, 2.0, math.pi / 2]))
    for k in range(6)
]


def table(name):
    (found,) = re.findall(rf"<!-- {name} -->\n(.*?)<!-- end -->", PAGE, re.DOTALL)
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in found.splitlines()][2:]


def value(text):
    """What an expression gives at the end of the page's trace, as the page writes it."""
    expression = compile_expression(text, Environment.packed(SIGNALS))
    for t, x in TRACE:
        found = expression(x, t)
    if isinstance(found, (bool, type(None))):
        return {True: "true", False: "false", None: "invalid"}[found]
    return str(Quantity(float(f"{found:.3g}"), expression.node.kind.dimension))


@pytest.mark.parametrize("row", table("examples"), ids=lambda row: row[2])
def test_an_example_gives_the_value_beside_it(row):
    assert row[3] == value(row[2].strip("`"))


def test_every_function_and_every_operator_has_an_example():
    examples = " ".join(row[2] for row in table("examples"))
    written = " ".join(row[0] for row in table("examples"))
    for name in FUNCTIONS:
        assert f"`{name}(" in written
        assert re.search(rf"\b{name}\(", examples), name
    for sign in (
        " + ",
        " - ",
        " * ",
        " / ",
        " < ",
        " > ",
        " and ",
        " or ",
        "not ",
        " implies ",
        " if ",
        "[2]",
        "[0:2]",
    ):
        assert sign in examples, sign


def test_the_limits_are_those_of_the_parser():
    limits = re.search(r"\*\*Limits\*\*: (\d+) characters, (\d+) operations, (\d+) deep", PAGE)
    assert tuple(map(int, limits.groups())) == (MAX_LENGTH, MAX_SIZE, MAX_DEPTH)


@pytest.fixture(scope="module")
def signals():
    catalog = Catalog()
    return stub_agent(catalog.load_robot("pioneer_p3dx"), catalog.load_class).knowledge.signals


def test_the_course_has_six_files():
    assert len(FILES) == 6


@pytest.mark.parametrize(("title", "text"), FILES, ids=lambda part: part[:12])
def test_a_file_of_the_course_is_fine_and_passes_its_own_tests(title, text, signals, tmp_path):
    file = tmp_path / "rules" / "steady.toml"
    file.parent.mkdir()
    file.write_text(text, "utf-8")
    environment = Environment.of(signals)
    doubts = [fault.message for fault in examine_rules(file, environment, ACTIONS).faults if not fault.note]
    words = ("chatters with noise", "can hold the robot for ever") if title == "Stop" else ()
    assert [word in doubt for word, doubt in zip(words, doubts, strict=True)] == [True] * len(words)
    rules = load_rules(file, environment, ACTIONS)
    results = run_tests(rules)
    assert [r.message for r in results if not r.passed] == []
    assert {r.rule for r in results} == {r.name for r in rules.rules}


def test_the_requirements_load_and_ground_truth_is_listed(signals):
    (block,) = re.findall(r"```toml\n(\[\[requirement\]\].*?)```", PAGE, re.DOTALL)
    environment = Environment.packed([*(signals.spec(name) for name in signals.names), *TRUTH])
    for written in tomllib.loads(block)["requirement"]:
        assert parse_requirement(written["require"], environment).text == written["require"]
    assert [(name.strip("`"), unit) for name, _, unit in table("truth")] == [
        (s.name, ", ".join(map(str, s.dimensions))) for s in TRUTH
    ]


def test_the_rule_with_an_optional_signal_is_inactive_on_wheels_and_passes_its_tests_elsewhere(signals, tmp_path):
    (section,) = re.findall(r"^## Rules that need an optional signal\n(.*?)^## ", PAGE, re.DOTALL | re.MULTILINE)
    text, sentence = re.findall(r"```(?:toml)?\n(.*?)```", section, re.DOTALL)
    file = tmp_path / "sideways.toml"
    file.write_text(text, "utf-8")
    (inactive,) = load_rules(file, Environment.of(signals), ACTIONS).inactive
    assert inactive_rule(inactive.name, ["pioneer_p3dx"], inactive.missing) == sentence.strip()
    holonomic = Environment.packed([OPTIONAL_SIGNALS["lateral_speed"]])
    assert [r.message for r in run_tests(load_rules(file, holonomic, ACTIONS))] == [""]
    assert [fault for fault in examine_rules(file, holonomic, ACTIONS).faults if not fault.note] == []


def test_the_optional_signals_are_those_of_the_robots_page():
    page = (Path(__file__).resolve().parents[2] / "robots" / "README.md").read_text("utf-8")
    (found,) = re.findall(r"<!-- optional -->\n(.*?)<!-- end -->", page, re.DOTALL)
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in found.splitlines()[2:]]
    wanted = [(f"`{s.name}`", s.doc[0].lower() + s.doc[1:-1], str(s.dimension)) for s in OPTIONAL_SIGNALS.values()]
    assert [tuple(row) for row in rows] == wanted
