"""Requirements: what must hold over a whole run, such as `always (near implies within 0.2 s slow)`.

`within` asks for what comes later, so its verdict must wait: `look_back` turns a requirement about a time t into an
expression about the past that has the same value a fixed `delay` after t (O. Maler, D. Nickovic, "Monitoring Temporal
Properties of Continuous Signals", 2004: a bounded future formula can be monitored by its delayed past form).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..errors import Fault, InputError
from .environment import Environment
from .node import TRUTH, Node
from .parser import parse


@dataclass(frozen=True)
class Requirement:
    """A requirement over a run.

    Attributes:
        text: How it was written.
        node: What to evaluate: it looks at the past only. Its value at time t is the verdict about t - delay, invalid
            while that is not known.
        always: Whether it was written with `always`: it must hold at every time, else at the end of the run.
        delay: How long the verdict must wait [s].
    """

    text: str
    node: Node
    always: bool
    delay: float


def parse_requirement(text: str, environment: Environment) -> Requirement:
    """A requirement such as `always min(front) > 0.05 m`.

    Raises:
        InputError: As `parse`; or it is not true or false.
    """
    node = parse(text, environment, ahead=True)
    if node.kind != TRUTH:
        hint = "Compare it, such as min(front) > 0.05 m."
        raise InputError(Fault(f"a requirement is true or false, but {node.text} is {node.kind.words}.", hint=hint))
    delay = horizon(node)
    return Requirement(text.strip(), look_back(node, delay), text.split()[0] == "always", delay)


def horizon(node: Node) -> float:
    """How far ahead an expression looks [s]."""
    own = float(node.value) if node.op == "within" else 0.0
    return own + max(map(horizon, node.args), default=0.0)


def look_back(node: Node, delay: float) -> Node:
    """The expression whose value at time t is that of `node` at t - delay.

    Args:
        node: The expression; it may look ahead.
        delay: [s]; not less than its horizon.

    Raises:
        InputError: A group of values stands beside something that looks ahead.
    """
    if node.op == "within":
        (arg,) = node.args
        return replace(node, op="once", args=(look_back(arg, delay - float(node.value)),))
    if node.future:
        return replace(node, args=tuple(look_back(arg, delay) for arg in node.args))
    if node.constant or delay <= 0.0:
        return node
    if node.kind.size:
        message = f"{node.text} has {node.kind.size} values, which cannot stand beside 'within'."
        raise InputError(Fault(message, column=node.column, hint="Use min, max, any or all."))
    return Node("delay", node.kind, (node,), value=delay, text=node.text, column=node.column)
