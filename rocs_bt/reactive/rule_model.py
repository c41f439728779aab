"""RuleModel: a rule file as a ReactiveModel.

States of a rule: an *inactive* rule latches when its guard has held for `for` and no cooldown is running; it then
requests its action. A *latched* rule with `until` is released by `until` alone (hysteresis), a rule without it as soon
as its guard does not hold. All rules are evaluated on every snapshot, also those that do not act. Parameters in `keep`
keep their values from the time of latching. Time is that of the snapshots; if it goes backwards, all rules are reset.

The parameters of actions and the texts of guard values are evaluated outside the rule table, and only when needed.
Temporal operators in them need every snapshot, so the table updates these operators in every step; their values are
appended to those of the snapshot (extended snapshot).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..expression import TRUTH, Expression, Kind, Node, reading
from .backend import Backend, Machine
from .kernel_backend import choose_backend
from .reactive_model import ReactiveModel, Reflex
from .rule import Argument, Rule, RuleSet
from .rule_table import RuleTable, carry, lower_rules


def stateless_rule(rule: Rule, indices: Mapping[Node, int]) -> Rule:
    """Copy of a rule in which reads from an extended snapshot replace the temporal operators."""
    if not any(node.temporal for node in rule.nodes()):
        return rule

    def of(expression: Expression) -> Expression:
        return Expression(_read(expression.node, indices))

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


def _read(node: Node, indices: Mapping[Node, int]) -> Node:
    if not node.temporal:
        return node
    if node not in indices:
        return replace(node, args=tuple(_read(arg, indices) for arg in node.args))
    start = indices[node]
    kind = Kind() if node.kind.boolean else node.kind
    read = Node("read", kind, start=start, stop=start + 1, text=node.text)
    half = Node("number", Kind(), value=0.5, text="0.5")
    return Node("compare", TRUTH, (read, half), signs=(">",), text=node.text) if node.kind.boolean else read


def describe(rule: Rule, latched: bool, values: Sequence[float]) -> Callable[[], str]:
    """Function that builds the text of a rule's guard values, such as `min(front) = 0.21 m`.

    Args:
        rule: Rule.
        latched: Whether the text is about `when`; otherwise about `until`, if the rule has one.
        values: Values of the snapshot.
    """
    node = rule.when.node if latched or rule.until is None else rule.until.node
    return lambda: reading(node, values)


@dataclass(frozen=True)
class _Prepared:
    """A compiled rule set, ready to use."""

    rules: RuleSet
    table: RuleTable
    machine: Machine
    stateless: Sequence[Rule]  # read temporal operators from an extended snapshot, after its first `size` values
    size: int  # number of values of a snapshot that the rules read


class RuleModel(ReactiveModel):
    """Reactive model that evaluates the rules of one file.

    Args:
        rules: Rule set from `load_rules`.
        backend: Back end; by default the fastest available one.
    """

    def __init__(self, rules: RuleSet, backend: Backend | None = None) -> None:
        self._backend = backend or choose_backend()
        self._mode = self._entered = ""
        self._next: _Prepared | None = None
        self._before: list[bool] = []  # latches after the last snapshot
        self._kept: dict[str, Mapping[str, Any]] = {}
        self._time = -math.inf
        self._install(self._prepared(rules))

    @property
    def name(self) -> str:
        return self.rules.name

    @property
    def mode(self) -> str:
        """Present mode of the agent; a rule with `modes` is active only in these modes."""
        return self._mode

    @property
    def latched(self) -> tuple[str, ...]:
        """Names of the latched rules."""
        return tuple(rule.name for rule, on in zip(self.rules.rules, self._machine.mask, strict=True) if on)

    def reset(self) -> None:
        """Reset all state except the mode, as at the start of an episode."""
        self._kept.clear()
        self._install(self._prepared(self.rules))

    def enter(self, mode: str) -> None:
        """Switch to another mode from the next snapshot on; thread-safe."""
        self._mode = mode

    def replace(self, rules: RuleSet) -> None:
        """Replace the rules from the next snapshot on; thread-safe.

        Rules of the same name keep their latch and timers; the time windows of temporal operators are reset.
        """
        self._next = self._prepared(rules)  # compiled here, so that no reflex waits for the compilation

    def react(self, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        if (prepared := self._next) is not None:
            self._next = None
            self._switch_to(prepared)
        if self._mode != self._entered:
            self._enable()
        if t < self._time:
            self._before = [False] * len(self._before)
            self._kept.clear()
        self._time = t
        machine = self._machine
        if machine.step(x, t) < 0 and True not in self._before:
            return ()
        was, self._before = self._before, [bool(on) for on in machine.mask]
        values = x[: self._size].tolist()
        values += [machine.register(register) for register in self._temporal]
        states = zip(self._stateless, was, self._before, machine.blind, strict=True)
        return [self._reflex(rule, now, values, bool(blind)) for rule, before, now, blind in states if before or now]

    def _reflex(self, rule: Rule, latched: bool, values: Sequence[float], blind: bool) -> Reflex:
        parameters = rule.parameters(values, blind) if latched else {}
        if not latched:
            self._kept.pop(rule.name, None)
        elif rule.keep and not blind:  # while the guard is invalid, the fallbacks apply
            parameters |= self._kept.setdefault(rule.name, {name: parameters[name] for name in rule.keep})
        return Reflex(
            rule=rule.name,
            priority=rule.priority,
            action=rule.action,
            parameters=parameters,
            level=rule.level,
            waits_for=rule.waits_for,
            latched=latched,
            reading=describe(rule, latched, values),
        )

    def _enable(self) -> None:
        mode = self._entered = self._mode
        for i, rule in enumerate(self.rules.rules):
            self._machine.enable(i, not rule.modes or mode in rule.modes)

    def _switch_to(self, prepared: _Prepared) -> None:
        table, values, time = self.table, self._machine.values(), self._time
        was = {rule.name for rule, on in zip(self.rules.rules, self._before, strict=True) if on}
        same = {(rule.name, rule.action, rule.keep) for rule in self.rules.rules}
        still = {rule.name for rule in prepared.rules.rules if (rule.name, rule.action, rule.keep) in same}
        self._kept = {name: kept for name, kept in self._kept.items() if name in still}
        self._install(prepared)
        self._machine.restore(carry(values, table, self.table))
        self._before = [rule.name in was for rule in self.rules.rules]
        self._time = time
        self._enable()

    def _prepared(self, rules: RuleSet) -> _Prepared:
        table = lower_rules(rules.rules)
        size = max((stop for _, stop in table.program.reads), default=0)
        indices = {node: size + i for i, node in enumerate(table.program.temporal)}
        stateless = [stateless_rule(rule, indices) for rule in rules.rules]
        for rule in stateless:
            rule.prepare()
        return _Prepared(rules, table, self._backend.machine(table), stateless, size)

    def _install(self, prepared: _Prepared) -> None:
        self.rules, self.table, self._machine = prepared.rules, prepared.table, prepared.machine
        self._stateless, self._size = prepared.stateless, prepared.size
        self._temporal = list(self.table.program.temporal.values())
        self._before = [False] * len(self.rules.rules)
        self._time = -math.inf
        self._enable()
