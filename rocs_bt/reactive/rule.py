"""Reflex rules, rule sets and rule tests as frozen values."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import islice
from pathlib import Path
from typing import Any

from ..base.units import Dimension
from ..declare import Location
from ..expression import Expression, Node


@dataclass(frozen=True)
class Expected:
    """State of a rule that a test expects after one of its samples.

    Attributes:
        sample: Index of the sample in `RuleTest.samples`.
        fires: Whether the rule must be latched; None for either.
        parameters: Expected parameters of the action, numbers in SI units; others are not checked.
        position: Position of the expectation in its file.
    """

    sample: int
    fires: bool | None
    parameters: Mapping[str, Any]
    position: Location


@dataclass(frozen=True)
class RuleTest:
    """Test of a rule: a sequence of signal snapshots, and the expected state of the rule after some of them.

    Attributes:
        name: Name of the test, used in messages.
        samples: Time [s] and signal values (SI units, NaN if invalid) of each snapshot.
        expected: Expected states of the rule.
        mode: Mode of the agent during the test.
        position: Position of the test in its file.
    """

    name: str
    samples: tuple[tuple[float, tuple[float, ...]], ...]
    expected: tuple[Expected, ...]
    mode: str
    position: Location


class OnInvalid(Enum):
    """Behaviour of a rule while its guard is invalid because a signal is stale or broken."""

    TRIP = "trip"  # assume danger: the rule latches and stays latched
    HOLD = "hold"  # keep the latch for at most max_hold, then trip
    CLEAR = "clear"  # assume no danger: the rule does not latch, and releases


@dataclass(frozen=True)
class Argument:
    """Value of one parameter of a rule's action.

    Attributes:
        value: Expression, or tuple of expressions and numbers for a list with expressions, or constant.
        fallback: Constant that replaces an invalid value; None if the value cannot be invalid.
        blind: Whether the fallback is also used while the rule's guard is invalid. True if the rule file declares the
            fallback; False if the fallback is the parameter's default.
    """

    value: Expression | tuple[Expression | float, ...] | Any
    fallback: Any = None
    blind: bool = False


@dataclass(frozen=True)
class Rule:
    """Reflex rule: a guard on signals, and the action that the robot executes while or when the guard holds.

    Attributes:
        name: Name, as `file/Rule`.
        doc: Description in one sentence.
        when: Guard; the rule latches once it has held for `hold`.
        until: Release condition of a latched rule; None to release the rule as soon as its guard does not hold.
        hold: Time for which the guard must hold, by the snapshots' time stamps [s].
        cooldown: Minimum time from latching (edge) or release (level) to the next latching [s].
        level: Whether the action is cancelled on release; otherwise (edge) it runs to its own end.
        priority: Priority; a strictly higher one pre-empts.
        on_invalid: Behaviour while the guard is invalid.
        max_hold: Maximum duration of `OnInvalid.HOLD` [s].
        action: Name of the action.
        arguments: Parameters of the action, keyed by name.
        keep: Names of parameters that are fixed when the rule latches, or when its guard is first valid after that,
            until the rule is released.
        tags: Tags such as `safety`.
        modes: Modes of the agent in which the rule is active; empty for all.
        require: Names of the signals without which the rule is inactive.
        waits_for: Condition outside of the robot that releases the rule, such as `a person`; empty for none.
        tests: Tests of the rule.
        positions: Positions of the rule's keys in its file, such as `when`; the empty key is the rule itself.
    """

    name: str
    when: Expression
    priority: int
    action: str
    until: Expression | None = None
    hold: float = 0.0
    cooldown: float = 0.0
    level: bool = False
    on_invalid: OnInvalid = OnInvalid.CLEAR
    max_hold: float = 0.0
    arguments: Mapping[str, Argument] = field(default_factory=dict)
    keep: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    require: tuple[str, ...] = ()
    waits_for: str = ""
    doc: str = ""
    tests: tuple[RuleTest, ...] = field(default=(), compare=False)
    positions: Mapping[str, Location] = field(default_factory=dict, compare=False)

    def nodes(self) -> Iterator[Node]:
        """Typed trees of all expressions of the rule: `when`, `until`, then the action's parameters."""
        yield self.when.node
        if self.until is not None:
            yield self.until.node
        for argument in self.arguments.values():
            for part in argument.value if isinstance(argument.value, tuple) else (argument.value,):
                if isinstance(part, Expression):
                    yield part.node

    def prepare(self) -> None:
        """Compile the expressions of the action's parameters now, so that the first firing is not delayed."""
        for argument in self.arguments.values():
            for part in argument.value if isinstance(argument.value, tuple) else (argument.value,):
                if isinstance(part, Expression):
                    part.prepare()

    def parameters(self, x: Sequence[float], blind: bool) -> dict[str, Any]:
        """Values of the action's parameters for a snapshot, SI units.

        Args:
            x: Values of the snapshot, SI units.
            blind: Whether the guard is invalid, so that the fallbacks that the rule file declares are used.
        """
        return {name: _value(argument, x, blind) for name, argument in self.arguments.items()}


@dataclass(frozen=True)
class InactiveRule:
    """Rule that is not evaluated, because the robot lacks signals that the rule requires.

    Attributes:
        name: Name, as `file/Rule`.
        missing: Names of the required signals that the robot lacks.
        position: Position of the rule's `require` in its file.
    """

    name: str
    missing: tuple[str, ...]
    position: Location


@dataclass(frozen=True)
class RuleSet:
    """Rules of one file.

    Attributes:
        name: Name of the file without suffix.
        doc: Documentation text of the file.
        rules: Rules in the order of the file, those of included files first; without the inactive ones.
        inactive: Rules that are inactive, because the robot lacks signals that they require.
        files: Files from which the rules were read; the including file is last.
        thresholds: Values of the robot and of the named thresholds, after overrides by the robot, SI units.
        dimensions: Dimension of each threshold.
    """

    name: str
    rules: tuple[Rule, ...]
    inactive: tuple[InactiveRule, ...] = ()
    doc: str = ""
    files: tuple[Path, ...] = ()
    thresholds: Mapping[str, float] = field(default_factory=dict)
    dimensions: Mapping[str, Dimension] = field(default_factory=dict)


MOST_TIES = 4  # maximum number of reported ties per rule


def ties(rules: Sequence[Rule]) -> Iterator[tuple[int, list[int]]]:
    """Find ties: rules with equal priority, different actions and a common mode. Which one acts would be arbitrary.

    Yields the index of a rule, and those of at most MOST_TIES earlier ones.
    """
    ranks: dict[int, dict[Hashable, list[int]]] = {}
    for k, rule in enumerate(rules):
        rank, own = ranks.setdefault(rule.priority, {}), _effect(rule)
        others = (i for effect, same in rank.items() if effect != own for i in same)
        tied = islice((i for i in others if not _exclusive(rules[i], rule)), MOST_TIES)
        if found := sorted(tied):
            yield k, found
        rank.setdefault(own, []).append(k)


def tie(rule: Rule, others: Sequence[Rule]) -> str:
    """Text of the message about a tie."""
    names = [other.name.rpartition("/")[2] for other in others[: MOST_TIES - 1]]
    names += ["others"] * (len(others) >= MOST_TIES)
    listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    return f"{rule.name.rpartition('/')[2]} has the same priority {rule.priority} as {listed}, but another action."


def _exclusive(a: Rule, b: Rule) -> bool:
    """Whether two rules have no common mode."""
    return bool(a.modes and b.modes) and set(a.modes).isdisjoint(b.modes)


def _effect(rule: Rule) -> Hashable:
    """Hashable key of a rule's action and parameters; rules with equal keys act alike."""
    values = [(name, _fixed(a.value), _fixed(a.fallback), a.blind) for name, a in rule.arguments.items()]
    return rule.action, frozenset(values), frozenset(rule.keep)


def _fixed(value: Any) -> Hashable:
    return tuple(value) if isinstance(value, list) else value


def _value(argument: Argument, x: Sequence[float], blind: bool) -> Any:
    if blind and argument.blind:
        return argument.fallback
    if isinstance(argument.value, Expression):
        value = argument.value(x)
        return argument.fallback if value is None else value
    if isinstance(argument.value, tuple):
        values = [part(x) if isinstance(part, Expression) else part for part in argument.value]
        return argument.fallback if None in values else values
    return argument.value
