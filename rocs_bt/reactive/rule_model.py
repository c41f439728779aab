"""RuleModel: a rule file as a ReactiveModel.

A rule's life. *Open*: when its guard has held for `for`, and no cooldown runs, it latches, which is when it wants its
action. *Latched*: `until` decides alone (hysteresis), and releases it. All rules advance on every snapshot, whichever
of them acts. The parameters that a rule keeps stay as they were when it latched. Time is the snapshots' own; where it
goes backwards everything begins anew.

The action's parameters and the reading for people are evaluated outside of the table, and only when they are wanted.
Temporal operations in them are not: the table keeps those up to date, and their values follow the snapshot's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..expression import TRUTH, Expression, Kind, Node, compile_node, reading
from .backend import Backend, Machine
from .choose_backend import choose_backend
from .reactive_model import ReactiveModel, Reflex
from .rule import Argument, Rule, RuleSet
from .rule_table import RuleTable, carry, lower_rules


def without_time(rule: Rule, places: Mapping[Node, int]) -> Rule:
    """The rule with its temporal operations read from where their values stand.

    Args:
        rule: The rule.
        places: The index of each temporal operation's value in the snapshot that has them.
    """
    if not any(node.temporal for node in rule.nodes()):
        return rule

    def of(expression: Expression) -> Expression:
        return compile_node(_read(expression.node, places))

    def part(value: Any) -> Any:
        return of(value) if isinstance(value, Expression) else value

    def argument(given: Argument) -> Argument:
        value = tuple(map(part, given.value)) if isinstance(given.value, tuple) else part(given.value)
        return replace(given, value=value)

    return replace(
        rule,
        when=of(rule.when),
        until=None if rule.until is None else of(rule.until),
        arguments={name: argument(given) for name, given in rule.arguments.items()},
    )


def _read(node: Node, places: Mapping[Node, int]) -> Node:
    if not node.temporal:
        return node
    if node not in places:
        return replace(node, args=tuple(_read(arg, places) for arg in node.args))
    start = places[node]
    kind = Kind() if node.kind.boolean else node.kind
    read = Node("read", kind, start=start, stop=start + 1, text=node.text)
    half = Node("number", Kind(), value=0.5, text="0.5")
    return Node("compare", TRUTH, (read, half), signs=(">",), text=node.text) if node.kind.boolean else read


def describe(rule: Rule, latched: bool, values: Sequence[float]) -> Callable[[], str]:
    """What a rule saw, to be built when it is asked for."""
    node = rule.when.node if latched or rule.until is None else rule.until.node
    return lambda: reading(node, values)


@dataclass(frozen=True)
class _Prepared:
    """A rule set that is ready to be put in force.

    Attributes:
        rules: The rule set.
        table: Its table.
        machine: The machine that runs the table.
        told: The rules with temporal values read from behind the first `size` values of a snapshot.
        size: Number of values of a snapshot that the rules read.
    """

    rules: RuleSet
    table: RuleTable
    machine: Machine
    told: Sequence[Rule]
    size: int


class RuleModel(ReactiveModel):
    """The reflexes of one rule file.

    Args:
        rules: From `load_rules`.
        backend: What runs them; the fastest there is by default.
    """

    def __init__(self, rules: RuleSet, backend: Backend | None = None) -> None:
        self._backend = backend or choose_backend()
        self._mode = self._entered = ""
        self._next: _Prepared | None = None
        self._was: list[bool] = []
        self._kept: dict[str, Mapping[str, Any]] = {}
        self._time = -math.inf
        self._take(self._prepared(rules))

    @property
    def name(self) -> str:
        return self.rules.name

    @property
    def mode(self) -> str:
        """The agent's mode; rules that list modes live in those alone."""
        return self._mode

    @property
    def latched(self) -> tuple[str, ...]:
        """The rules that are latched."""
        return tuple(rule.name for rule, on in zip(self.rules.rules, self._machine.mask, strict=True) if on)

    def reset(self) -> None:
        """Forget everything but the mode, as at the beginning of an episode."""
        self._kept.clear()
        self._take(self._prepared(self.rules))

    def enter(self, mode: str) -> None:
        """The agent is in another mode from the next snapshot on; safe to call from any thread."""
        self._mode = mode

    def replace(self, rules: RuleSet) -> None:
        """Put other rules in force from the next snapshot on; safe to call from any thread.

        Rules of the same name stay latched, and keep their timers; windows begin anew.
        """
        self._next = self._prepared(rules)  # here, so that no reflex waits for it

    def react(self, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        if (prepared := self._next) is not None:
            self._next = None
            self._go_on_with(prepared)
        if self._mode != self._entered:
            self._enable()
        if t < self._time:
            self._was = [False] * len(self._was)
            self._kept.clear()
        self._time = t
        machine = self._machine
        if machine.step(x, t) < 0 and True not in self._was:
            return ()
        was, self._was = self._was, [bool(on) for on in machine.mask]
        values = x[: self._size].tolist()
        values += [machine.register(register) for register in self._temporal]
        wanted = zip(self._told, was, self._was, machine.blind, strict=True)
        return [self._reflex(rule, now, values, bool(blind)) for rule, before, now, blind in wanted if before or now]

    def _reflex(self, rule: Rule, latched: bool, values: Sequence[float], blind: bool) -> Reflex:
        parameters = rule.parameters(values, blind) if latched else {}
        if not latched:
            self._kept.pop(rule.name, None)
        elif rule.keep and not blind:  # while it is blind the fallbacks stand in
            parameters |= self._kept.setdefault(rule.name, {name: parameters[name] for name in rule.keep})
        return Reflex(
            rule=rule.name,
            priority=rule.priority,
            action=rule.action,
            parameters=parameters,
            level=rule.level,
            latched=latched,
            reading=describe(rule, latched, values),
        )

    def _enable(self) -> None:
        mode = self._entered = self._mode
        for i, rule in enumerate(self.rules.rules):
            self._machine.enable(i, not rule.modes or mode in rule.modes)

    def _go_on_with(self, prepared: _Prepared) -> None:
        table, values, time = self.table, self._machine.values(), self._time
        was = {rule.name for rule, on in zip(self.rules.rules, self._was, strict=True) if on}
        same = {(rule.name, rule.action, rule.keep) for rule in self.rules.rules}
        still = {rule.name for rule in prepared.rules.rules if (rule.name, rule.action, rule.keep) in same}
        self._kept = {name: kept for name, kept in self._kept.items() if name in still}
        self._take(prepared)
        self._machine.restore(carry(values, table, self.table))
        self._was = [rule.name in was for rule in self.rules.rules]
        self._time = time
        self._enable()

    def _prepared(self, rules: RuleSet) -> _Prepared:
        table = lower_rules(rules.rules)
        size = max((stop for _, stop in table.program.reads), default=0)
        places = {node: size + i for i, node in enumerate(table.program.temporal)}
        told = [without_time(rule, places) for rule in rules.rules]
        for rule in told:
            rule.prepare()
        return _Prepared(rules, table, self._backend.machine(table), told, size)

    def _take(self, prepared: _Prepared) -> None:
        self.rules, self.table, self._machine = prepared.rules, prepared.table, prepared.machine
        self._told, self._size = prepared.told, prepared.size
        self._temporal = list(self.table.program.temporal.values())
        self._was = [False] * len(self.rules.rules)
        self._time = -math.inf
        self._enable()
