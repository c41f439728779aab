"""Tests of rules, in the rule file or in `tests/` beside it; each test runs its rule alone.

[[rule.BackOff.test]]
name = "not while the robot is stationary"
given = { front = "0.3 m", speed = "0 m/s" }        # all other signals are invalid
at = [{ t = "0 s" }, { t = "0.1 s", speed = "0.2 m/s", "front[2]" = "nan" }]
expect = [{ t = "0 s", fires = false }, { t = "0.1 s", fires = true, speed = "-0.35 m/s" }]
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import Fault, InputError, unknown
from ..base.files import confined, is_file
from ..base.signal import Signal
from ..base.toml_table import read_toml
from ..base.units import convert
from ..declare import Location, Open, location_of, read, read_key
from ..expression import Environment
from ..interfaces.action import Action, parameters_of
from .include import project_of
from .reactive_model import Reflex
from .rule import Expected, Rule, RuleSet, RuleTest
from .rule_keys import ExpectationKeys, RuleTestFile, RuleTestKeys
from .rule_model import RuleModel, describe

_KEY = re.compile(r"(\w+)(?:\[(-?\d+)?(:)?(-?\d+)?\])?")


def read_tests(
    tests: Sequence[RuleTestKeys],
    rule: str,
    environment: Environment,
    action: type[Action] | None,
    faults: list[Fault],
) -> tuple[RuleTest, ...]:
    """Make the tests of a rule from their tables.

    Args:
        tests: Tables of the tests.
        rule: Name of the rule, from which default names of its tests are made.
        environment: Signals of the robot.
        action: Class of the rule's action, or None if unknown.
        faults: List to which faults are added.
    """
    made = []
    for i, keys in enumerate(tests):
        row = [math.nan] * environment.size
        _give(keys.given, row, environment, faults)
        samples = []
        for sample in keys.at:
            _give(sample.signals, row, environment, faults)
            samples.append((sample.t, tuple(row)))
        expected = tuple(_expected(keys, each, action, faults) for each in keys.expect)
        name = keys.name or f"{rule}, test {i + 1}"
        made.append(RuleTest(name, tuple(samples), expected, keys.mode, location_of(keys)))
    return tuple(made)


def add_test_files(
    rules: RuleSet, environment: Environment, actions: Mapping[str, type[Action]]
) -> tuple[RuleSet, list[Fault]]:
    """Add the tests in `tests/NAME.toml` beside each file of a rule set; tests of inactive rules are not read.

    Args:
        rules: Rules, as read from their rule files.
        environment: Signals of the robot.
        actions: Actions of the agent, keyed by name.

    Returns:
        The rules with their tests, and the faults of the test files.
    """
    added: dict[str, tuple[RuleTest, ...]] = {}
    skipped = {rule.name.rpartition("/")[2] for rule in rules.inactive}
    faults: list[Fault] = []
    for file in rules.files:
        path = file.parent / "tests" / file.name
        if not is_file(path):
            continue
        try:
            confined(f"tests/{file.name}", file.parent, (project_of(file),))
            table = read_toml(path)
            for name, keys in read(RuleTestFile, table).rule.items():
                rule = next((r for r in rules.rules if r.name == f"{rules.name}/{name}"), None)
                if name in skipped:
                    continue
                if rule is None:
                    names = [*(r.name.rpartition("/")[2] for r in rules.rules), *skipped]
                    error = InputError(unknown("rule", name, names, rules.files[-1].name))
                    table.faults.extend(error.at(*location_of(keys)).faults)
                action = actions.get(rule.action) if rule else None
                tests = read_tests(keys.test, name, environment, action, table.faults)
                if rule is not None:
                    added[rule.name] = added.get(rule.name, ()) + tests
            with contextlib.suppress(InputError):  # the table keeps its faults
                table.done()
            faults += table.faults
        except InputError as error:
            faults += error.at(file).faults
    tested = tuple(replace(rule, tests=rule.tests + added.get(rule.name, ())) for rule in rules.rules)
    return replace(rules, rules=tested), faults


def tested_file(path: Path) -> Path:
    """Rule file of a test file: `rules/NAME.toml` for `rules/tests/NAME.toml`; other paths are unchanged."""
    folder = path.absolute().parent
    if path.suffix == ".toml" and (folder.name, folder.parent.name) == ("tests", "rules"):
        return folder.parent / path.name
    return path


def _expected(test: RuleTestKeys, keys: ExpectationKeys, action: type[Action] | None, faults: list[Fault]) -> Expected:
    declared, table = parameters_of(action) if action else {}, keys.parameters.opened()
    table.faults = faults
    parameters = {}
    for key in keys.parameters:
        if key in declared:
            parameters[key] = read_key(declared[key], table)
        elif action:
            table.adopt(key, InputError(unknown(f"parameter of {action.__name__}", key, declared, action.__name__)))
    return Expected(test.sample(keys), keys.fires, parameters, location_of(keys))


def _give(values: Open, row: list[float], environment: Environment, faults: list[Fault]) -> None:
    """Write the values of signals into a snapshot.

    Args:
        values: Values, keyed by signal or by indexed signal, such as `front[2]`.
        row: Values of the snapshot, SI units; changed in place.
        environment: Signals of the robot.
        faults: List to which faults are added.
    """
    for key, value in values.items():
        try:
            indices, signal = _indices(key, environment)
            parts = value if isinstance(value, list) else [value] * len(indices)
            if len(parts) != len(indices):
                raise InputError(f"{key} has {len(indices)} values, found {len(parts)}.")
            for at, part in zip(indices, parts, strict=True):
                row[environment.offsets[signal.name] + at] = _number(key, part, signal, at)
        except InputError as error:
            faults.extend(error.at(*location_of(values, key)).faults)


def _indices(key: str, environment: Environment) -> tuple[range, Signal]:
    """Indices and signal of a key such as `front[1:3]`; the indices count within the signal."""
    match = _KEY.fullmatch(key)
    if match is None or match[1] not in environment.signals:
        raise InputError(unknown("signal", key if match is None else match[1], environment.signals))
    signal = environment.signals[match[1]]
    every = range(signal.size)
    if match[3]:
        indices = every[slice(*(int(n) if n else None for n in (match[2], match[4])))]
    elif match[2]:
        at = int(match[2])
        indices = every[at : at + 1] if at >= 0 else every[signal.size + at :][:1]
    else:
        indices = every
    if not indices or (match[2] is None and match[3] is None and "[" in key):
        raise InputError(Fault(f"'{key}' is empty or beyond the {signal.size} values of {signal.name}."))
    return indices, signal


def _number(key: str, value: Any, signal: Signal, at: int) -> float:
    if isinstance(value, str) and value.strip() == "nan":
        return math.nan
    if isinstance(value, float) and math.isnan(value):
        return value
    dimensions = signal.dimensions
    return convert(value, dimensions[0 if len(dimensions) == 1 else at], f"'{key}'")


_SAME = 1e-6  # relative tolerance of expected parameters


@dataclass(frozen=True)
class RuleTestResult:
    """Result of one test of a rule.

    Attributes:
        rule: Name of the rule.
        test: Name of the test.
        message: Description of the first difference from an expectation; empty if the test passed.
        position: Position of the test, or of the expectation that failed.
    """

    rule: str
    test: str
    message: str
    position: Location

    @property
    def passed(self) -> bool:
        """Whether the test passed."""
        return not self.message


def run_tests(rules: RuleSet) -> list[RuleTestResult]:
    """Run all tests of a rule set. Each test runs its rule alone, from the initial state."""
    return [_run(rule, test) for rule in rules.rules for test in rule.tests]


def _run(rule: Rule, test: RuleTest) -> RuleTestResult:
    model = RuleModel(RuleSet(rule.name, (rule,)))
    model.enter(test.mode)
    for k, (t, x) in enumerate(test.samples):
        reflexes = [reflex for reflex in model.react(np.array(x), t) if reflex.latched]
        for expected in test.expected:
            if expected.sample == k and (message := _difference(rule, expected, reflexes, x)):
                message = f"at t = {t:g} s {message}{_mode_hint(rule, test)}"
                return RuleTestResult(rule.name, test.name, message, expected.position)
    return RuleTestResult(rule.name, test.name, "", test.position)


def _difference(rule: Rule, expected: Expected, reflexes: Sequence[Reflex], x: Sequence[float]) -> str:
    """Describe the difference between the reflexes of a rule and an expectation; empty if there is none."""
    fires = bool(reflexes)
    if expected.fires is not None and fires is not expected.fires:
        words = {True: "the rule fires", False: "the rule does not fire"}
        values = reflexes[0].describe() if reflexes else describe(rule, True, x)()
        wanted = "fires = true" if expected.fires else "fires = false"
        return f"{words[fires]}, but '{wanted}' is expected; guard values: {values}."
    for name, value in expected.parameters.items():
        if not reflexes:
            return f"{name} = {value!r} is expected, but the rule does not fire."
        if not _same(found := reflexes[0].parameters.get(name), value):
            return f"{name} is {found!r}, but {value!r} is expected (SI units)."
    return ""


def _same(found: Any, expected: Any) -> bool:
    if isinstance(found, (list, tuple)) and isinstance(expected, (list, tuple)):
        return len(found) == len(expected) and all(map(_same, found, expected))
    if isinstance(found, float) and isinstance(expected, float):
        return math.isclose(found, expected, rel_tol=_SAME, abs_tol=1e-9)
    return bool(found == expected)


def _mode_hint(rule: Rule, test: RuleTest) -> str:
    if not rule.modes or test.mode in rule.modes:
        return ""
    return f" The test's mode is '{test.mode}', but the rule is active only in {', '.join(rule.modes)}."
