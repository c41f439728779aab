"""Requirement: condition on a whole run, such as `always (near implies within 0.2 s slow)`.

Whether `within` holds at time t depends on later samples, so it is known only after a delay. `look_back` converts a
requirement to an expression over past samples; the value of the expression at t + delay is that of the requirement at
t (O. Maler, D. Nickovic, "Monitoring Temporal Properties of Continuous Signals", 2004).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..base.errors import Fault, InputError
from .environment import Environment
from .node import TRUTH, Node
from .parser import parse


@dataclass(frozen=True)
class Requirement:
    """Condition on a whole run, such as `always min(front) > 0.05 m`.

    Attributes:
        text: Text of the requirement.
        node: Expression over past samples. Its value at time t is that of the requirement at t - delay; it is invalid
            if that value is not known.
        always: Whether the requirement must be true at all times (`always`) instead of at the end of the run.
        delay: Time after a sample at which it is known whether the requirement holds at this sample [s].
    """

    text: str
    node: Node
    always: bool
    delay: float


def parse_requirement(text: str, environment: Environment) -> Requirement:
    """Parse a requirement such as `always min(front) > 0.05 m`.

    Raises:
        InputError: The text cannot be parsed (see `parse`), or its value is not a single truth value.
    """
    node = parse(text, environment, ahead=True)
    if node.kind != TRUTH:
        hint = "Compare it, such as min(front) > 0.05 m."
        raise InputError(
            Fault(f"a requirement must be true or false, but {node.text} is {node.kind.words}.", hint=hint)
        )
    delay = horizon(node)
    return Requirement(text.strip(), look_back(node, delay), text.split()[0] == "always", delay)


def horizon(node: Node) -> float:
    """Time by which an expression depends on later samples [s]: the sum of nested `within` windows."""
    own = float(node.value) if node.op == "within" else 0.0
    return own + max(map(horizon, node.args), default=0.0)


def look_back(node: Node, delay: float) -> Node:
    """Convert an expression to its delayed form, which has at time t the value of `node` at t - delay.

    Args:
        node: Expression, which may contain `within`.
        delay: Delay [s], at least the horizon of the expression.

    Raises:
        InputError: A group of values is combined with `within`.
    """
    if node.op == "within":
        (arg,) = node.args
        return replace(node, op="once", args=(look_back(arg, delay - float(node.value)),))
    if node.future:
        return replace(node, args=tuple(look_back(arg, delay) for arg in node.args))
    if node.constant or delay <= 0.0:
        return node
    if node.kind.size:
        message = f"{node.text} has {node.kind.size} values, which cannot be combined with 'within'."
        raise InputError(Fault(message, column=node.column, hint="Use min, max, any or all."))
    return Node("delay", node.kind, (node,), value=delay, text=node.text, column=node.column)
