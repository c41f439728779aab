"""Declared tables of rule files and of their tests."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal

from ..base.units import TIME, Bounds, Seconds
from ..declare import Key, Open, Rest, TableName, Valid, Value, Wrong, has_key

MAX_PRIORITY = 1_000_000
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def is_name(text: str) -> bool:
    """Whether a text can name a rule, a signal or a mode."""
    return NAME.fullmatch(text) is not None


def _is_written(text: str) -> bool:
    return bool(text.strip())


_LETTERS = "Use letters, digits and '_', beginning with a letter."
_NAME, _SIGNAL, _MODE = (Valid(is_name, f"a valid name of a {what}", _LETTERS) for what in ("rule", "signal", "mode"))
_EXPRESSION = Valid(_is_written, "an expression", "Write for example min(front) < 0.5 m.")
_Time = Annotated[Any, TIME]  # or the name of a threshold, so that it is read with the expressions
_CONDITION = Valid(_is_written, "a condition", 'Name what releases the rule, such as "a person".')


class SampleKeys(Value):
    """Keys of a sample of a test.

    Attributes:
        t: Time [s].
        signals: Values of signals; others keep the value that they have.
    """

    t: Seconds
    signals: Annotated[Open, Rest()]


class ExpectationKeys(Value):
    """Keys of an expectation of a test.

    Attributes:
        t: Time of the sample [s].
        fires: Whether the rule must be latched.
        parameters: Expected parameters of the action.
    """

    t: Seconds
    fires: bool | None = None
    parameters: Annotated[Open, Rest()]


class RuleTestKeys(Value):
    """Keys of a test of a rule.

    Attributes:
        name: Name of the test.
        mode: Mode of the agent.
        given: Values of signals before the first sample; all others are invalid.
        at: Samples, by increasing time.
        expect: Expectations.
    """

    name: str = ""
    mode: str = ""
    given: Open = Open()
    at: tuple[SampleKeys, ...] = ()
    expect: tuple[ExpectationKeys, ...] = ()

    def _check(self) -> Iterator[Wrong]:
        if not has_key(self, "at"):
            yield Wrong(None, "the test has no 'at'.", 'Add at = [{ t = "0 s" }].')
        if not self.expect:
            yield Wrong(None, "the test has no 'expect'.", 'Add expect = [{ t = "0 s", fires = true }].')
        for expected in self.expect:
            if self.sample(expected) < 0 and has_key(expected, "t"):
                yield Wrong("t", f"the test has no sample at {expected.t:g} s.", "Add one to 'at'.", expected)

    def sample(self, expected: ExpectationKeys) -> int:
        """Index of the last sample at the time of an expectation; -1 if there is none."""
        return max((k for k, sample in enumerate(self.at) if abs(sample.t - expected.t) < 1e-9), default=-1)


class ActionKeys(Value):
    """Keys of the action of a rule.

    Attributes:
        name: Name of the action.
        on_invalid: Parameters while signals that they read are invalid.
        parameters: Parameters: constants, or expressions over signals.
    """

    name: str
    on_invalid: Open = Open()
    parameters: Annotated[Open, Rest()]


class RuleKeys(Value):
    """Keys of a rule.

    Attributes:
        name: Name of the rule.
        doc: Description, one sentence.
        when: Guard.
        until: Condition for the release of the latched rule.
        hold: Time for which the guard must hold: a quantity, or the name of a threshold.
        cooldown: Minimum time to the next latching; as `for`.
        trigger: Whether the action runs to its own end, or is cancelled on release.
        priority: Priority; a higher one pre-empts.
        on_invalid: Behaviour while the guard is invalid.
        max_hold: Maximum duration of `on_invalid = "hold"`; as `for`.
        modes: Modes in which the rule is active.
        tags: Tags, such as `safety`.
        require: Signals without which the rule is inactive.
        waits_for: Condition outside of the robot that releases the rule.
        keep: Parameters that are fixed when the rule latches.
        action: Action of the rule; None if it is missing.
        test: Tests of the rule.
    """

    name: Annotated[str, TableName(), _NAME]
    doc: str = ""
    when: Annotated[str, _EXPRESSION]
    until: Annotated[str | None, _EXPRESSION] = None
    hold: Annotated[_Time, Key("for")] = "0 s"
    cooldown: _Time = "0 s"
    trigger: Literal["edge", "level"] = "edge"
    priority: Annotated[int, Bounds(-MAX_PRIORITY, MAX_PRIORITY)]
    on_invalid: Literal["trip", "hold", "clear"] = "clear"
    max_hold: _Time = "0 s"
    modes: tuple[Annotated[str, _MODE], ...] = ()
    tags: tuple[str, ...] = ()
    require: tuple[Annotated[str, _SIGNAL], ...] = ()
    waits_for: Annotated[str, _CONDITION] = ""
    keep: tuple[str, ...] = ()
    action: ActionKeys | None
    test: tuple[RuleTestKeys, ...] = ()

    def misfits(self) -> Iterator[Wrong]:
        """Faults of keys that do not fit each other; also asked if other keys have faults."""
        if self._table is not None and self._table.data.get("modes") == []:
            yield Wrong("modes", "modes is empty, so the rule would never be active.", "Omit it for all modes.")
        if not has_key(self, "on_invalid") and "safety" in self.tags:
            yield Wrong(
                None,
                f"{self.name} has the tag safety, so it must declare 'on_invalid', its behaviour with an "
                "invalid guard.",
                'Add on_invalid = "trip" (act), "hold" (keep the latch for max_hold) or "clear" (do not act).',
            )
        if self.on_invalid == "hold" and not has_key(self, "max_hold"):
            yield Wrong(
                "on_invalid",
                f"{self.name} holds while its guard is invalid, but has no 'max_hold'.",
                'A rule must not hold for ever: add for example max_hold = "0.5 s", after which the rule trips.',
            )
        if self.on_invalid != "hold" and has_key(self, "max_hold"):
            message = f"max_hold of {self.name} has no effect, because on_invalid is '{self.on_invalid}'."
            yield Wrong("max_hold", message)


class RuleFile(Value):
    """A rule file.

    Attributes:
        format: Format of the file.
        doc: Documentation of the file.
        include: Other rule files, relative to this one.
        robot: Values of the robot, which hold without a robot.
        threshold: Named constants.
        alias: Named expressions.
        rule: Rules.
    """

    format: Literal["reflex/1"]
    doc: str = ""
    include: tuple[str, ...] = ()
    robot: Open = Open()
    threshold: Open = Open()
    alias: Open = Open()
    rule: Mapping[str, RuleKeys] = MappingProxyType({})


class TestedRule(Value):
    """Rule with a test in a file of its own: `[[rule.NAME.test]]`."""

    test: tuple[RuleTestKeys, ...] = ()


class RuleTestFile(Value):
    """A file of tests of rules.

    Attributes:
        format: Format of the file.
        doc: Documentation of the file.
        rule: Rules with tests.
    """

    format: Literal["reflex-tests/1"]
    doc: str = ""
    rule: Mapping[str, TestedRule] = MappingProxyType({})
