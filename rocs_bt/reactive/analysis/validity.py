"""Validity of expressions: which signals must be valid for a result, and whether valid signals give a valid result."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

from ...expression import Node
from ...expression.node import TEMPORAL_OPS
from ...expression.operators import ROWS, SIGNS

_ALWAYS = ("read", "number", "truth", "vector", "compare")  # beside the operators of the table


def monotone(node: Node) -> bool:
    """Whether a result that is valid while a signal is invalid is the result for every valid value of the signal."""
    return all(part.op not in TEMPORAL_OPS and part.op != "min_valid" for part in node.walk())


def decided(node: Node, valid: set[int]) -> bool:
    """Whether an expression is certainly valid on all snapshots in which the given indices are valid."""
    return node.reads() <= valid and _total(node)


def needed(node: Node, truth: bool) -> set[int]:
    """Indices of the snapshot that are certainly valid where an expression has the given truth value."""
    match node.op:
        case "not":
            return needed(node.args[0], not truth)
        case "and" | "or":
            parts = [needed(arg, truth) for arg in node.args]
            return set().union(*parts) if truth is (node.op == "and") else set.intersection(*parts)
        case "any" | "all":
            (arg,) = node.args
            return needed(arg, truth) if truth is (node.op == "all") else set()
        case "compare":
            operands = [_read_by(arg) for arg in node.args]
            pairs = [a | b for a, b in pairwise(operands)]
            return set().union(*pairs) if truth else set.intersection(*pairs)
        case "if":
            return needed(node.args[1], truth) & needed(node.args[2], truth)
        case "read":
            return node.reads()
        case _:
            return set()


def _read_by(node: Node) -> set[int]:
    """Indices that are certainly valid where a number is valid."""
    if node.kind.boolean:
        return needed(node, True) & needed(node, False)
    if node.op == "if":
        return _read_by(node.args[1]) & _read_by(node.args[2])
    if node.op == "min_valid" or node.op in TEMPORAL_OPS:
        return set()
    return node.reads() if node.op == "read" else set().union(*(_read_by(arg) for arg in node.args))


def _total(node: Node) -> bool:
    if node.op == "/" and not (_constant(node.args[1]) and node.args[1].value):
        return False
    if node.op == "clip" and not all(_constant(limit) for limit in node.args[1:]):
        return False
    valid = "all" if node.op in _ALWAYS else ROWS[SIGNS.get(node.op, node.op)].valid
    if not valid or (valid == "finite" and not _finite(node.args)):
        return False
    return all(_total(arg) for arg in node.args)


def _finite(args: Iterable[Node]) -> bool:
    leaves = [leaf for arg in args for leaf in arg.walk() if leaf.op in ("read", "number")]
    return all(math.isfinite(leaf.span if leaf.op == "read" else float(leaf.value)) for leaf in leaves)


def _constant(node: Node) -> bool:
    return node.op == "number" and math.isfinite(node.value)
