"""Rules that can hold the robot for ever: the action does not move it, and rest alone does not release the rule."""

from __future__ import annotations

from dataclasses import replace

from ...action import Action
from ...errors import interrupts
from ...expression import Expression, Node
from ...raised import describe
from ...units import NONE, TIME
from ..rule import Rule
from .case import Case, short
from .translate import conjunction, negation

_PASSING = frozenset({"since", "time_since", "rate", "delay"})  # change while all signals stay as they are
_OF_MOTION = ("stop_distance",)  # signals that depend on the speed although their unit does not show it
_TIME = TIME.exponents.index(1)


def check_holding(case: Case, rule: Rule, action: type[Action]) -> None:
    """A rule whose action cannot change what holds it.

    An action that does not move the robot changes only its motion. The finding is proved: if the guard holds, the
    release does not hold after the speeds have become 0 and everything else has stayed as it was.

    Args:
        case: The rule set.
        rule: One of its rules, whose guard can hold while all signals are valid.
        action: Its action.
    """
    if any(argument.value is None for argument in rule.arguments.values()):
        return  # a parameter that is wrong is reported by itself
    known = {name: value for name, a in rule.arguments.items() if not _sensed(value := a.value)}
    try:
        moves = action.can_move(known)
    except BaseException as error:  # a user's class may raise anything
        if interrupts(error):
            raise
        case.tell(rule, "action", f"can_move of {rule.action} raised {describe(error)}.", "Repair it.")
        return
    if moves or (rule.until is not None and case.prover.ask(rule.until.node).never):
        return  # an until that never holds is reported by itself
    released = _at_rest(case, negation(rule.when.node) if rule.until is None else rule.until.node)
    if released is None or not case.prover.ask(conjunction([rule.when.node, released])).never:
        return
    example = case.shown(case.prover.example(rule.when.node), [rule.when.node])
    case.tell(
        rule, "action",
        f"{short(rule)} can hold the robot for ever: {rule.action} does not move it, and standing still does not "
        f"release the rule. It latches, for example, with {example}.",
        "Choose an action that moves the robot, or an until that holds at rest. A robot that a reflex holds for 15 s "
        "without progress is stuck.",
    )  # fmt: skip


def _sensed(value: object) -> bool:
    """Whether a parameter follows what is sensed."""
    parts = value if isinstance(value, tuple) else (value,)
    return any(isinstance(part, Expression) for part in parts)


def _at_rest(case: Case, node: Node) -> Node | None:
    """An expression with the speeds and rates that it reads at 0; None if more of it changes while the robot rests."""
    if node.op in _PASSING:
        return None
    if node.op == "read":
        (name,) = case.signals_of(node)
        passed = (node.kind.dimension or NONE).exponents[_TIME]
        if passed > 0 or name in _OF_MOTION:
            return None
        return _zero(node) if passed < 0 else node
    args = [_at_rest(case, arg) for arg in node.args]
    return replace(node, args=tuple(arg for arg in args if arg is not None)) if None not in args else None


def _zero(node: Node) -> Node:
    zero = Node("number", replace(node.kind, size=0), text="0")
    return Node("vector", node.kind, (zero,) * node.kind.size, text="0") if node.kind.size else zero
