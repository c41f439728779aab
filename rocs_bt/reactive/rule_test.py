"""Running the tests that stand in rule files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .reactive_model import Reflex
from .rule import Expected, Place, Rule, RuleSet, RuleTest
from .rule_model import RuleModel
from .told import describe

_SAME = 1e-6  # parameters are as expected when they differ by no more than this share


@dataclass(frozen=True)
class RuleTestResult:
    """What became of a rule's test.

    Attributes:
        rule: The rule's name.
        test: The test's name.
        message: What was not as expected; empty where it passed.
        place: Where the test, or what it expects, stands.
    """

    rule: str
    test: str
    message: str
    place: Place

    @property
    def passed(self) -> bool:
        """Whether all was as expected."""
        return not self.message


def run_tests(rules: RuleSet) -> list[RuleTestResult]:
    """Run every test of a rule set; each on its rule alone, from the beginning of its life."""
    return [_run(rule, test) for rule in rules.rules for test in rule.tests]


def _run(rule: Rule, test: RuleTest) -> RuleTestResult:
    model = RuleModel(RuleSet(rule.name, (rule,)))
    model.enter(test.mode)
    for k, (t, x) in enumerate(test.samples):
        told = [reflex for reflex in model.react(np.array(x), t) if reflex.latched]
        for expected in test.expected:
            if expected.sample == k and (message := _difference(rule, expected, told, x)):
                message = f"at t = {t:g} s {message}{_mode_hint(rule, test)}"
                return RuleTestResult(rule.name, test.name, message, expected.place)
    return RuleTestResult(rule.name, test.name, "", test.place)


def _difference(rule: Rule, expected: Expected, told: Sequence[Reflex], x: Sequence[float]) -> str:
    """How what the rule told differs from what is expected; empty where it does not."""
    fires = bool(told)
    if expected.fires is not None and fires is not expected.fires:
        words = {True: "it fires", False: "it does not fire"}
        saw = told[0].describe() if told else describe(rule, True, x)()
        return (
            f"{words[fires]}, but '{'fires = true' if expected.fires else 'fires = false'}' is expected; it saw {saw}."
        )
    for name, value in expected.parameters.items():
        if not told:
            return f"{name} = {value!r} is expected, but it does not fire."
        if not _same(found := told[0].parameters.get(name), value):
            return f"{name} is {found!r}, but {value!r} is expected (SI units)."
    return ""


def _same(found: Any, expected: Any) -> bool:
    if isinstance(found, (list, tuple)) and isinstance(expected, list):
        return len(found) == len(expected) and all(map(_same, found, expected))
    if isinstance(found, float) and isinstance(expected, float):
        return math.isclose(found, expected, rel_tol=_SAME, abs_tol=1e-9)
    return bool(found == expected)


def _mode_hint(rule: Rule, test: RuleTest) -> str:
    if not rule.modes or test.mode in rule.modes:
        return ""
    return f" The test's mode is '{test.mode}', but the rule lives in {', '.join(rule.modes)} alone."
