"""Text with the values that decide an expression: `min(front) = 0.21 m, speed = 0.48 m/s`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..base.units import Quantity
from .evaluator import Snapshot, evaluate
from .node import Node

_WORDS: Mapping[float | bool | None, str] = {True: "true", False: "false", None: "invalid"}


def reading(node: Node, x: Snapshot) -> str:
    """Text with the values of the operands of all comparisons; temporal operands are left out.

    Of an `or`, only the alternatives that are true are included; if none is, those that are invalid; if none is, all.

    Args:
        node: Expression.
        x: Values of the snapshot, SI units.
    """
    found: dict[str, str] = {}
    for comparison in _comparisons(node, x):
        if comparison.text == comparison.args[0].text:  # a truth value computed by the rule table
            truth = evaluate(comparison, x)
            found.setdefault(comparison.text, f"{comparison.text} = {_WORDS[truth]}")
            continue
        for side in comparison.args:
            if not side.constant and not side.temporal and not side.kind.size and side.kind.dimension is not None:
                value = evaluate(side, x)
                shown = "invalid" if value is None else str(Quantity(float(f"{value:.3g}"), side.kind.dimension))
                found.setdefault(side.text, f"{side.text} = {shown}")
    return ", ".join(found.values())


def _comparisons(node: Node, x: Snapshot) -> Iterator[Node]:
    if node.op == "compare":
        yield from (part for part in node.walk() if part.op == "compare")
        return
    parts = node.args
    if node.op == "or":
        values = [(part, evaluate(part, x)) for part in parts if not part.temporal]
        parts = tuple(p for p, truth in values if truth) or tuple(p for p, truth in values if truth is None) or parts
    for part in parts:
        yield from _comparisons(part, x)
