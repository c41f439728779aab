"""Rules as frozen values."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import islice
from pathlib import Path
from typing import Any

from ..expression import Expression, Node


@dataclass(frozen=True)
class Place:
    """Where something stands that a person wrote.

    Attributes:
        file: The file.
        line: 1-based; 0 where unknown.
        column: 1-based, of the first character of an expression's text where it is one; 0 where unknown.
    """

    file: Path
    line: int = 0
    column: int = 0


@dataclass(frozen=True)
class Expected:
    """What a test expects after one of its samples.

    Attributes:
        sample: The index of the sample.
        fires: Whether the rule is latched; None: either.
        parameters: Some of the action's parameters, as they were written: quantities, texts, numbers, truth values.
        place: Where it stands.
    """

    sample: int
    fires: bool | None
    parameters: Mapping[str, Any]
    place: Place


@dataclass(frozen=True)
class RuleTest:
    """A test that a rule file has for a rule.

    Attributes:
        name: What messages call it.
        samples: The snapshots and their times [s].
        expected: What is expected after them.
        mode: The agent's mode.
        place: Where it stands.
    """

    name: str
    samples: tuple[tuple[float, tuple[float, ...]], ...]
    expected: tuple[Expected, ...]
    mode: str
    place: Place


class OnInvalid(Enum):
    """What a rule does while its guard has no value, since a signal that it reads is stale or broken."""

    TRIP = "trip"  # as if there were danger: it latches, and stays latched
    HOLD = "hold"  # it stays as it is, for max_hold at most; then it trips
    CLEAR = "clear"  # as if there were none: it does not latch, and releases


@dataclass(frozen=True)
class Argument:
    """A parameter of a rule's action.

    Attributes:
        value: An expression, several of them for a list, or a plain value.
        fallback: What stands in while the value is invalid; None where it cannot be.
        blind: Whether the fallback stands in while the guard is invalid, too; so it is where the file gives it.
    """

    value: Expression | tuple[Expression | float, ...] | Any
    fallback: Any = None
    blind: bool = False


@dataclass(frozen=True)
class Rule:
    """A reflex rule.

    Attributes:
        name: `file/Rule`.
        doc: One sentence for people.
        when: The guard: once it has held for `hold`, the rule latches.
        until: While latched, what releases it; None: as soon as the guard does not hold.
        hold: How long the guard must hold [s], on the snapshots' time.
        cooldown: How long after it fired (edge) or released (level) it cannot latch anew [s].
        level: True: the action is cancelled on release. False (edge): it runs to its own end.
        priority: A strictly higher one pre-empts.
        on_invalid: What an invalid guard means.
        max_hold: How long HOLD may last [s].
        action: The action's name.
        arguments: The action's parameters.
        keep: Those of them that stay, while it is latched, as they were when it latched, or its guard was first valid.
        tags: Such as `safety`.
        modes: The modes of the agent in which it lives; all of them where empty.
        tests: Its tests.
        places: Where its keys stand, such as `when`; the rule itself at the empty key.
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
    doc: str = ""
    tests: tuple[RuleTest, ...] = field(default=(), compare=False)
    places: Mapping[str, Place] = field(default_factory=dict, compare=False)

    def nodes(self) -> Iterator[Node]:
        """The typed trees of all its expressions: the guards, then the action's parameters."""
        yield self.when.node
        if self.until is not None:
            yield self.until.node
        for argument in self.arguments.values():
            for part in argument.value if isinstance(argument.value, tuple) else (argument.value,):
                if isinstance(part, Expression):
                    yield part.node

    def prepare(self) -> None:
        """Compile the action's parameters, so that the control period in which the rule fires need not."""
        for argument in self.arguments.values():
            for part in argument.value if isinstance(argument.value, tuple) else (argument.value,):
                if isinstance(part, Expression):
                    part.prepare()

    def parameters(self, x: Sequence[float], blind: bool) -> dict[str, Any]:
        """The action's parameters for a snapshot, SI units.

        Args:
            x: The snapshot.
            blind: Whether the guard is invalid, so that the fallbacks of the file stand in.
        """
        return {name: _value(argument, x, blind) for name, argument in self.arguments.items()}


@dataclass(frozen=True)
class RuleSet:
    """The rules of one file.

    Attributes:
        name: The file's name without its ending.
        doc: What the file says of itself.
        rules: In the order of the file, those of included files first.
        files: The files that it was read from, the including one last.
        thresholds: Its named thresholds, in SI units, as they are in force.
    """

    name: str
    rules: tuple[Rule, ...]
    doc: str = ""
    files: tuple[Path, ...] = ()
    thresholds: Mapping[str, float] = field(default_factory=dict)


MOST_TIES = 4  # with which one rule is told to be tied


def ties(rules: Sequence[Rule]) -> Iterator[tuple[int, list[int]]]:
    """Where it would be chance which rule acts: one priority, different actions, a mode that both live in.

    Args:
        rules: The rules.

    Yields:
        For each rule that is tied with earlier ones its index and theirs, MOST_TIES of them at most.
    """
    ranks: dict[int, dict[Hashable, list[int]]] = {}
    for k, rule in enumerate(rules):
        rank, own = ranks.setdefault(rule.priority, {}), _deed(rule)
        others = (i for deed, same in rank.items() if deed != own for i in same)
        tied = islice((i for i in others if not _apart(rules[i], rule)), MOST_TIES)
        if found := sorted(tied):
            yield k, found
        rank.setdefault(own, []).append(k)


def tie(rule: Rule, others: Sequence[Rule]) -> str:
    """A sentence about a rule and those that it is tied with."""
    names = [other.name.rpartition("/")[2] for other in others[: MOST_TIES - 1]]
    names += ["others"] * (len(others) >= MOST_TIES)
    listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    return f"{rule.name.rpartition('/')[2]} has the same priority {rule.priority} as {listed}, but another action."


def _apart(a: Rule, b: Rule) -> bool:
    """Whether no mode has both rules."""
    return bool(a.modes and b.modes) and set(a.modes).isdisjoint(b.modes)


def _deed(rule: Rule) -> Hashable:
    """What a rule does: equal for rules that do the same."""
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
