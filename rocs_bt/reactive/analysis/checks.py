"""Checks of rules: guards, action parameters, pairs of rules, and the fit to the agent's period and modes."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...base.errors import interrupts
from ...base.raised import describe
from ...base.units import NONE, TIME, Bounds
from ...expression import TRUTH, Expression, Kind, Node
from ...expression.node import TEMPORAL_OPS
from ...interfaces.action import Action, parameters_of
from ..rule import OnInvalid, Rule
from .case import Case, nodes_with_columns, short
from .prover import conjunction, negation, with_values
from .sample import Array

_SLACK = 1e-9  # [s]


def check_times(case: Case, rule: Rule) -> None:
    """Report a cooldown without effect: it is not longer than the time for which the guard must hold."""
    if 0.0 < rule.cooldown <= rule.hold + _SLACK:
        case.warn(
            rule,
            "cooldown",
            f"the cooldown of {short(rule)}, {rule.cooldown:g} s, has no effect, because the guard must hold for "
            f"{rule.hold:g} s anyway: released at 0 s, the rule cannot fire before {rule.hold:g} s.",
            "Make the cooldown longer than for, or omit it.",
        )


def check_first_window(case: Case, rule: Rule) -> None:
    """Report a rule that an invalid guard trips, and with a guard that is invalid at every start.

    `rate` has no value until its window has passed: after the start of a run, and after the rule file was reloaded.
    """
    if rule.on_invalid is not OnInvalid.TRIP:
        return
    rates = [(node, column) for node, column in nodes_with_columns(rule.when.node) if node.op == "rate"]
    for node, column in rates[:1]:
        case.warn(
            rule,
            "when",
            f"'{node.text}' in the when of {short(rule)} is invalid for the first {node.value:g} s of a run and after "
            "each reload of the file, so on_invalid = 'trip' latches the rule at 0 s.",
            "Use on_invalid = 'hold' or 'clear' here, and another rule with 'trip' on the signals themselves.",
            node,
            column,
        )


def check_period(case: Case, rule: Rule, period: float) -> None:
    """Report signals with a maximum age, and time windows with a length, below one control period.

    Args:
        case: Rule set.
        rule: Rule of the set.
        period: Control period [s].
    """
    reported = set()
    for key, guard in (("when", rule.when), ("until", rule.until)):
        for node, column in nodes_with_columns(guard.node) if guard is not None else ():
            if node.op in TEMPORAL_OPS and 0.0 < node.value < period - _SLACK:
                case.warn(
                    rule,
                    key,
                    f"in the {key} of {short(rule)} the window of '{node.text}' is {node.value:g} s, shorter than the "
                    f"control period of {period:g} s: at 1 s it contains only the sample of 1 s.",
                    f"Make it several periods long, such as {3 * period:g} s.",
                    node,
                    column,
                )
            for name in case.signals_of(node) if node.op == "read" else ():
                age = case.environment.signals[name].max_age
                if age < period - _SLACK and name not in reported:
                    reported.add(name)
                    case.warn(
                        rule,
                        key,
                        f"{short(rule)} reads {name} with a max_age of {age:g} s, less than the control period of "
                        f"{period:g} s: written at 0 s it is invalid at {period:g} s.",
                        f"Give its sensor a max_age of several periods, such as {3 * period:g} s, in robot.toml.",
                        node,
                        column,
                    )


def check_modes(case: Case, rule: Rule, modes: Collection[str]) -> None:
    """Report modes of a rule that the mission never sets."""
    for mode in rule.modes:
        if mode not in modes:
            rest = [other for other in rule.modes if other in modes]
            case.warn(
                rule,
                "modes",
                f"{short(rule)} is active in the mode '{mode}', which the mission never sets"
                + (f"; of its modes, the mission sets only {', '.join(rest)}." if rest else ", so it never acts."),
                "Let the mission set the mode, or name a mode that it sets.",
            )


_PASSING = frozenset({"since", "time_since", "rate", "delay"})  # can change while all signals are constant
_OF_MOTION = ("stop_distance", "course_range", "tilt")  # their units do not show that they depend on the motion
_TIME = TIME.exponents.index(1)


def check_holding(case: Case, rule: Rule, action: type[Action]) -> None:
    """Report a rule that can hold the robot for ever, because its action cannot cause its release; see `waits_for`.

    An action that does not move the robot changes only the speed signals, which become 0. The rule is reported if it is
    proved that its release condition is then false whenever its guard was true. The guard must be known to be
    satisfiable while all signals are valid.
    """
    if rule.waits_for or any(argument.value is None for argument in rule.arguments.values()):
        return  # planned; or an invalid parameter, which is reported separately
    known = {name: value for name, a in rule.arguments.items() if not _sensed(value := a.value)}
    try:
        moves = action.can_move(known)
    except BaseException as error:  # a user's class may raise anything
        if interrupts(error):
            raise
        case.warn(rule, "action", f"can_move of {rule.action} raised {describe(error)}.", "Correct can_move.")
        return
    if moves or (rule.until is not None and case.prover.decide(rule.until.node).never):
        return  # an until that never holds is reported separately
    released = _at_rest(case, negation(rule.when.node) if rule.until is None else rule.until.node)
    if released is None or not case.prover.decide(conjunction([rule.when.node, released])).never:
        return
    example = case.shown(case.prover.example(rule.when.node), [rule.when.node])
    case.warn(
        rule,
        "action",
        f"{short(rule)} can hold the robot for ever: {rule.action} does not move it, and a standstill does not "
        f"release the rule. It latches, for example, with {example}.",
        "Choose an action that moves the robot, or an until that holds at standstill. A robot that a reflex holds for "
        '15 s without progress is stuck, unless the rule says what it waits for, such as waits_for = "a person".',
    )


def _sensed(value: object) -> bool:
    """Whether the value of an action's parameter is computed from signals."""
    parts = value if isinstance(value, tuple) else (value,)
    return any(isinstance(part, Expression) for part in parts)


def _at_rest(case: Case, node: Node) -> Node | None:
    """Expression with 0 for each speed and rate, as at standstill; None if it can still change at standstill."""
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


_JUMPS = ("==", "!=")


def check_guards(case: Case, rule: Rule, action: type[Action] | None) -> None:
    """Check a rule's `when` and `until`, and whether the rule's action, if known, can cause the release."""
    never = _never(case, rule)  # may be intended: a rule that fires only on invalid signals
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
    answer = case.prover.decide(node)
    if answer.unknown:
        case.undecided(rule, "when", f"whether the guard of {short(rule)} ever holds", answer.unknown)
    if answer.never and rule.on_invalid is OnInvalid.CLEAR:
        example = _also(case, negation(node), "it does not hold")
        case.warn(
            rule,
            "when",
            f"the guard of {short(rule)} never holds{_since(case, node)}{example}.",
            "Correct its numbers or its signs, or remove the rule.",
            node,
        )
    return answer.never


def _always(case: Case, rule: Rule) -> bool:
    node = rule.when.node
    answer = case.prover.decide(negation(node))
    if answer.unknown:
        case.undecided(rule, "when", f"whether the guard of {short(rule)} always holds", answer.unknown)
    if answer.never:
        example = _also(case, node, "it holds")
        case.warn(
            rule,
            "when",
            f"the guard of {short(rule)} always holds{_since(case, node)}{example}.",
            "Correct its numbers or its signs. A permanent activity belongs in the mission.",
            node,
        )
    return answer.never


def _parts(case: Case, rule: Rule, key: str, guard: Node) -> None:
    """Report comparisons in a guard that are always true or always false, such as with a threshold out of bounds."""
    for node, column in nodes_with_columns(guard):
        if node is guard or node.kind != TRUTH or node.op not in ("compare", "any", "all") or node.constant:
            continue
        for claim, words in ((node, "never holds"), (negation(node), "always holds")):
            if case.prover.decide(claim).never:
                example = _also(case, negation(claim), "it does not" if claim is node else "it does")
                case.warn(
                    rule,
                    key,
                    f"in the {key} of {short(rule)} '{node.text}' {words}{_since(case, node)}{example}.",
                    "Compare with a value within the bounds, or remove the comparison.",
                    node,
                    column,
                )


def _release(case: Case, rule: Rule, until: Node) -> None:
    """Report an `until` that never holds, or that can hold together with `when`."""
    answer = case.prover.decide(until)
    if answer.unknown:
        case.undecided(rule, "until", f"whether {short(rule)} is ever released", answer.unknown)
    if answer.never:
        example = _also(case, negation(until), "it does not")
        case.warn(
            rule,
            "until",
            f"the until of {short(rule)} never holds{_since(case, until)}{example}: a latched rule is never released.",
            "Correct its numbers or its signs.",
            until,
        )
        return
    both = conjunction([rule.when.node, until])
    answer = case.prover.decide(both)
    if answer.unknown:
        case.undecided(rule, "until", f"whether when and until of {short(rule)} can hold at once", answer.unknown)
    if answer.example is not None:
        case.warn(
            rule,
            "until",
            f"when and until of {short(rule)} hold at once, so it latches and releases alternately: for example with "
            f"{case.shown(case.prover.example(both), [rule.when.node, until])}.",
            "The hysteresis is inverted: until must hold only where when does not, such as "
            'when = "a < 0.4 m" and until = "a > 0.5 m".',
            until,
        )
        return
    _parts(case, rule, "until", until)


def _chatter(case: Case, rule: Rule) -> None:
    """Report a level rule without hysteresis: sensor noise makes it latch and release in quick succession."""
    guard = rule.when.node
    if not rule.level or rule.until is not None or rule.hold or rule.cooldown or guard.temporal:
        return
    if not any(n.op == "compare" and not set(n.signs) & set(_JUMPS) and _measured(n) for n in guard.walk()):
        return
    if any(case.prover.decide(node).example is None for node in (guard, negation(guard))):
        return
    on, off = (case.prover.example(node) for node in (guard, negation(guard)))
    holds = Expression(guard)
    on, off, at = _edge(lambda x: holds(x) is True, on, off, sorted(guard.reads()))
    case.warn(
        rule,
        "when",
        f"{short(rule)} chatters with noise, because it is released as soon as its guard does not hold: with "
        f"{case.shown(on, [guard])} it is on, with {case.value_at(off, at)} off.",
        "Add an until at some distance from when, a for or a cooldown; if this is intended, write it as an until.",
        guard,
    )


def _measured(comparison: Node) -> bool:
    return any(arg.kind.dimension not in (None, NONE) and not arg.constant for arg in comparison.args)


def _edge(holds: Callable[[Array], bool], on: Array, off: Array, read: Sequence[int]) -> tuple[Array, Array, int]:
    """Find two snapshots that differ slightly in one value, with the guard true on the first and false on the second.

    Returns both, and the index of the value in which they differ.

    Args:
        holds: Function that evaluates the guard on a snapshot.
        on: Snapshot on which the guard is true, shape (size,).
        off: Snapshot on which the guard is false, shape (size,).
        read: Indices of the values that the guard reads.
    """
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
        low, high = (middle, high) if holds(with_values(on, [at], middle)) else (low, middle)
    return with_values(on, [at], low), with_values(on, [at], high), at


def check_parameters(case: Case, rule: Rule, action: type[Action]) -> None:
    """Report parameters of the action that can be out of bounds while the rule is latched."""
    guard = rule.when.node
    while_latched = guard if rule.until is None else _either(guard, negation(rule.until.node))
    declared = parameters_of(action)
    for name, argument in rule.arguments.items():
        parts = argument.value if isinstance(argument.value, tuple) else (argument.value,)
        for part in parts:
            if name not in declared or not isinstance(part, Expression):
                continue
            for wrong in _outside(part.node, declared[name].bounds):
                both = conjunction([while_latched, wrong])
                answer = case.prover.decide(both)
                key = f"action.{name}" if f"action.{name}" in rule.positions else "action"
                if answer.unknown:
                    question = f"whether {name} of {rule.action} is always {declared[name].bounds} in {short(rule)}"
                    case.undecided(rule, key, question, answer.unknown)
                elif answer.example is not None:
                    shown = case.shown(case.prover.example(both), [while_latched, part.node])
                    case.warn(
                        rule,
                        key,
                        f"{name} of {rule.action} must be {declared[name].bounds}, but in {short(rule)} "
                        f"'{part.text}' can be out of these bounds, for example with {shown}.",
                        "Limit it with clip, min or max.",
                    )
                else:
                    continue
                break


def _outside(node: Node, bounds: Bounds) -> Iterator[Node]:
    """Conditions, as expressions, under which an action parameter is out of its declared bounds."""
    if not math.isinf(bounds.low):
        yield _compared(node, "<=" if bounds.above else "<", bounds.low)
    if not bounds.infinite:
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
    if case.prover.decide(node).example is None or not node.reads():
        return ""
    return f"; with {case.shown(case.prover.example(node), [node])}, for example, {words}"
