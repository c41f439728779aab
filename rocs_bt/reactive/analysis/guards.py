"""What can be wrong with one rule: guards that never change, that contradict each other or chatter, parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ...action import Action, Parameter, parameters_of
from ...expression import TRUTH, Expression, Kind, Node
from ...units import NONE
from ..rule import OnInvalid, Rule
from .case import Case, placed, short
from .holding import check_holding
from .sample import Array
from .translate import conjunction, negation

_JUMPS = ("==", "!=")


def check_guards(case: Case, rule: Rule, action: type[Action] | None) -> None:
    """A rule's `when` and `until`, and whether its action, if it is known, can change what holds it."""
    never = _never(case, rule)  # which is no fault of a rule that is there for what is invalid
    always = _always(case, rule)
    if not never and not always:
        _parts(case, rule, "when", rule.when.node)
        _chatter(case, rule)
    if rule.until is not None and not never:
        _release(case, rule, rule.until.node)
    if action is not None and not never and not always:
        check_holding(case, rule, action)


def _never(case: Case, rule: Rule) -> bool:
    node = rule.when.node
    answer = case.prover.ask(node)
    if answer.unknown:
        case.undecided(rule, "when", f"whether the guard of {short(rule)} ever holds", answer.unknown)
    if answer.never and rule.on_invalid is OnInvalid.CLEAR:
        example = _also(case, negation(node), "it does not hold")
        case.tell(
            rule, "when",
            f"the guard of {short(rule)} never holds{_since(case, node)}{example}.",
            "Correct its numbers or its signs, or take the rule out.",
            node,
        )  # fmt: skip
    return answer.never


def _always(case: Case, rule: Rule) -> bool:
    node = rule.when.node
    answer = case.prover.ask(negation(node))
    if answer.unknown:
        case.undecided(rule, "when", f"whether the guard of {short(rule)} holds always", answer.unknown)
    if answer.never:
        example = _also(case, node, "it holds")
        case.tell(
            rule, "when",
            f"the guard of {short(rule)} holds whatever is sensed{_since(case, node)}{example}.",
            "Correct its numbers or its signs; what is to be done always belongs into the mission.",
            node,
        )  # fmt: skip
    return answer.never


def _parts(case: Case, rule: Rule, key: str, guard: Node) -> None:
    """Comparisons inside of a guard that never change: thresholds beyond the bounds."""
    for node, column in placed(guard):
        if node is guard or node.kind != TRUTH or node.op not in ("compare", "any", "all") or node.constant:
            continue
        for asked, words in ((node, "never holds"), (negation(node), "holds always")):
            if case.prover.ask(asked).never:
                example = _also(case, negation(asked), "it does not" if asked is node else "it does")
                case.tell(
                    rule, key,
                    f"in the {key} of {short(rule)} '{node.text}' {words}{_since(case, node)}{example}.",
                    "Compare with a value within the bounds, or take the comparison out.",
                    node, column,
                )  # fmt: skip


def _release(case: Case, rule: Rule, until: Node) -> None:
    """`until` must be able to hold, but never together with `when`."""
    answer = case.prover.ask(until)
    if answer.unknown:
        case.undecided(rule, "until", f"whether {short(rule)} is ever released", answer.unknown)
    if answer.never:
        example = _also(case, negation(until), "it does not")
        case.tell(
            rule, "until",
            f"the until of {short(rule)} never holds{_since(case, until)}{example}: once latched the rule stays so.",
            "Correct its numbers or its signs.",
            until,
        )  # fmt: skip
        return
    both = conjunction([rule.when.node, until])
    answer = case.prover.ask(both)
    if answer.unknown:
        case.undecided(rule, "until", f"whether when and until of {short(rule)} can hold at once", answer.unknown)
    if answer.example is not None:
        case.tell(
            rule, "until",
            f"when and until of {short(rule)} hold at once, so that it latches and releases in turns: for example with "
            f"{case.shown(case.prover.example(both), [rule.when.node, until])}.",
            "Hysteresis is upside down: until must hold only where when does not, such as "
            "when = \"a < 0.4 m\" and until = \"a > 0.5 m\".",
            until,
        )  # fmt: skip
        return
    _parts(case, rule, "until", until)


def _chatter(case: Case, rule: Rule) -> None:
    """A level rule that lets go where it fires goes on and off with every bit of noise."""
    guard = rule.when.node
    if not rule.level or rule.until is not None or rule.hold or rule.cooldown or guard.temporal:
        return
    if not any(n.op == "compare" and not set(n.signs) & set(_JUMPS) and _measured(n) for n in guard.walk()):
        return
    if any(case.prover.ask(node).example is None for node in (guard, negation(guard))):
        return
    on, off = (case.prover.example(node) for node in (guard, negation(guard)))
    on, off, at = _edge(lambda x: case.prover.confirmed(guard, x), on, off, sorted(guard.reads()))
    case.tell(
        rule, "when",
        f"{short(rule)} goes on and off with every bit of noise, since it is released as soon as its guard does not "
        f"hold: with {case.shown(on, [guard])} it is on, with {case.value_at(off, at)} off.",
        "Add an until with some distance to when, a for or a cooldown; or an until that says that this is meant.",
        guard,
    )  # fmt: skip


def _measured(comparison: Node) -> bool:
    return any(arg.kind.dimension not in (None, NONE) and not arg.constant for arg in comparison.args)


def _edge(holds: Callable[[Array], bool], on: Array, off: Array, read: Sequence[int]) -> tuple[Array, Array, int]:
    """Two snapshots that differ little, in one value alone, and truth changes between them; and which value."""
    off = np.where(np.isin(np.arange(len(on)), read), off, on)
    for at in read:
        step = on.copy()
        step[at] = off[at]
        if not holds(step):
            break
        on = step
    low, high = np.nan_to_num([on[at], off[at]], posinf=1e3, neginf=-1e3)
    while abs(high - low) > 1e-3 * max(1.0, abs(low)):
        middle = (low + high) / 2.0
        low, high = (middle, high) if holds(_with(on, at, middle)) else (low, middle)
    return _with(on, at, low), _with(on, at, high), at


def _with(x: Array, at: int, value: float) -> Array:
    x = x.copy()
    x[at] = value
    return x


def check_parameters(case: Case, rule: Rule, action: type[Action]) -> None:
    """What the action's parameters can be while the rule is latched, against what the action can do."""
    guard = rule.when.node
    while_latched = guard if rule.until is None else _either(guard, negation(rule.until.node))
    declared = parameters_of(action)
    for name, argument in rule.arguments.items():
        parts = argument.value if isinstance(argument.value, tuple) else (argument.value,)
        for part in parts:
            if name not in declared or not isinstance(part, Expression):
                continue
            for wrong in _outside(part.node, declared[name]):
                both = conjunction([while_latched, wrong])
                answer = case.prover.ask(both)
                key = f"action.{name}" if f"action.{name}" in rule.places else "action"
                if answer.unknown:
                    question = f"whether {name} of {rule.action} is always {declared[name].bounds} in {short(rule)}"
                    case.undecided(rule, key, question, answer.unknown)
                elif answer.example is not None:
                    shown = case.shown(case.prover.example(both), [while_latched, part.node])
                    case.tell(
                        rule, key,
                        f"{name} of {rule.action} must be {declared[name].bounds}, but in {short(rule)} it can be "
                        f"otherwise: '{part.text}' is so with {shown}.",
                        "Hold it within the bounds with clip, min or max.",
                    )  # fmt: skip
                else:
                    continue
                break


def _outside(node: Node, parameter: Parameter) -> Iterator[Node]:
    """That a parameter's expression is out of the parameter's bounds."""
    if not math.isinf(parameter.bounds.low):
        yield _compared(node, "<=" if parameter.bounds.above else "<", parameter.bounds.low)
    if not parameter.bounds.infinite:
        yield _compared(node, ">=", math.inf)
        yield _compared(node, "<=", -math.inf)


def _compared(node: Node, sign: str, value: float) -> Node:
    number = Node("number", Kind(node.kind.dimension), value=value, text=f"{value:g}")
    return Node("compare", TRUTH, (node, number), signs=(sign,), text=f"{node.text} {sign} {value:g}")


def _either(a: Node, b: Node) -> Node:
    return Node("or", TRUTH, (a, b), text=f"({a.text}) or ({b.text})")


def _since(case: Case, node: Node) -> str:
    bounds = case.bounds([node])
    return f", where {bounds}" if bounds else ""


def _also(case: Case, node: Node, words: str) -> str:
    if case.prover.ask(node).example is None or not node.reads():
        return ""
    return f"; with {case.shown(case.prover.example(node), [node])}, for example, {words}"
