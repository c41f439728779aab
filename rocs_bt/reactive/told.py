"""What a rule tells besides wanting its action: the action's parameters, and a reading for people.

Both are evaluated outside of the table, and only when they are wanted. Temporal operations in them are not: the table
keeps those up to date, and their values stand behind the snapshot's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..expression import TRUTH, Expression, Kind, Node, compile_node, reading
from .rule import Argument, Rule


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
