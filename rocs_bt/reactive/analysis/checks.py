"""What can be wrong with rules: guards, parameters, pairs of rules, and how they fit their agent."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...action import Action, Parameter, parameters_of
from ...errors import interrupts
from ...expression import TRUTH, Expression, Kind, Node
from ...expression.node import TEMPORAL_OPS
from ...raised import describe
from ...units import NONE, TIME
from ..rule import OnInvalid, Rule, tie, ties
from .case import Case, placed, short
from .sample import Array, Samples
from .translate import conjunction, negation

_SLACK = 1e-9  # [s]


def check_times(case: Case, rule: Rule) -> None:
    """A cooldown that is over before the guard could fire anew."""
    if 0.0 < rule.cooldown <= rule.hold + _SLACK:
        case.tell(
            rule, "cooldown",
            f"the cooldown of {short(rule)}, {rule.cooldown:g} s, has no effect, since the guard must hold for "
            f"{rule.hold:g} s anyway: let go at 0 s, it cannot fire before {rule.hold:g} s.",
            "Make the cooldown longer than for, or leave it out.",
        )  # fmt: skip


def check_period(case: Case, rule: Rule, period: float) -> None:
    """Signals that are too old before the next control period, and windows with a single sample.

    Args:
        case: The rule set.
        rule: One of its rules.
        period: The control period [s].
    """
    told = set()
    for key, guard in (("when", rule.when), ("until", rule.until)):
        for node, column in placed(guard.node) if guard is not None else ():
            if node.op in TEMPORAL_OPS and 0.0 < node.value < period - _SLACK:
                case.tell(
                    rule, key,
                    f"in the {key} of {short(rule)} the window of '{node.text}' is {node.value:g} s, shorter than the "
                    f"control period of {period:g} s: at 1 s it holds the sample of 1 s alone.",
                    f"Make it several periods long, such as {3 * period:g} s.",
                    node, column,
                )  # fmt: skip
            for name in case.signals_of(node) if node.op == "read" else ():
                age = case.environment.signals[name].max_age
                if age < period - _SLACK and name not in told:
                    told.add(name)
                    case.tell(
                        rule, key,
                        f"{short(rule)} reads {name}, whose max_age of {age:g} s is less than the control period of "
                        f"{period:g} s: written at 0 s it is invalid at {period:g} s.",
                        f"Give its sensor a max_age of several periods, such as {3 * period:g} s, in robot.toml.",
                        node, column,
                    )  # fmt: skip


def check_modes(case: Case, rule: Rule, modes: Collection[str]) -> None:
    """A rule that lives in no mode that the agent ever has.

    Args:
        case: The rule set.
        rule: One of its rules.
        modes: The modes that the agent's mission can set.
    """
    for mode in rule.modes:
        if mode not in modes:
            rest = [other for other in rule.modes if other in modes]
            case.tell(
                rule, "modes",
                f"{short(rule)} lives in the mode '{mode}', which the mission never sets"
                + (f"; only {', '.join(rest)} can be." if rest else ", so it never acts."),
                "Let the mission set the mode, or name one that it sets.",
            )  # fmt: skip


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


TRIED = 6  # rules of which it is tried to prove that they cover another one


def check_pairs(case: Case) -> None:
    """Rules that stand in each other's way."""
    rules = case.rules
    if len(rules) < 2:
        return
    examples = [case.prover.ask(rule.when.node).example for rule in rules]
    rows = np.array([case.prover.samples.rows[0] if x is None else x for x in examples])
    own = Samples(rows)
    truths = np.array(
        [np.concatenate([case.prover.samples.truth(r.when.node), own.truth(r.when.node)]) for r in rules], np.float32
    )
    alive = np.array([x is not None for x in examples])
    _ties(case, alive)
    for i, others in _covering(rules, truths, alive):
        _shadowed(case, rules[i], [rules[k] for k in others])


def _covering(
    rules: Sequence[Rule], truths: NDArray[np.float32], alive: NDArray[np.bool_]
) -> Iterator[tuple[int, list[int]]]:
    """For each rule those of higher priority whose guards held wherever its own did, as far as was tried."""
    uncovered = truths @ (1.0 - truths).T  # (R, R): how often the one held and the other did not
    priority = np.array([rule.priority for rule in rules])
    for i, rule in enumerate(rules):
        if alive[i]:
            found = np.flatnonzero((uncovered[i] == 0.0) & (priority > rule.priority) & alive)
            ranked = sorted(found.tolist(), key=lambda k: (-int(truths[k].sum()), k))
            if ranked:
                yield i, [k for k in ranked if _hides(rules[k], rule)][:TRIED]


def _hides(above: Rule, rule: Rule) -> bool:
    """Whether one rule acts from the first moment to the last of another one's guard, if its own guard covers that."""
    everywhere = not above.modes or bool(rule.modes and set(rule.modes) <= set(above.modes))
    at_once = above.hold <= rule.hold and not above.cooldown
    invalid = rule.on_invalid is OnInvalid.CLEAR or (
        above.on_invalid is OnInvalid.TRIP and rule.when.node.reads() <= above.when.node.reads()
    )
    return everywhere and at_once and invalid


def _shadowed(case: Case, rule: Rule, others: Sequence[Rule]) -> None:
    """Tell the first rule that is proved to be latched as long as this one is."""
    guard, why = rule.when.node, ""
    for above in others:
        covered = case.prover.ask(conjunction([guard, negation(above.when.node)]))
        outlived = case.prover.ask(conjunction([_released(above), _kept(rule)]))
        if covered.never and outlived.never:
            example = case.shown(case.prover.example(guard), [guard, above.when.node])
            case.tell(
                rule, "when",
                f"{short(rule)} never acts: as long as it is latched so is {short(above)}, whose priority of "
                f"{above.priority} is higher than {rule.priority}; both hold, for example, with {example}.",
                f"Give {short(rule)} the higher priority, or a guard that does not lie within that of {short(above)}.",
                guard,
            )  # fmt: skip
            return
        if (unknown := covered.unknown or outlived.unknown) and covered.example is None and outlived.example is None:
            why = why or f"whether {short(rule)} ever acts beside {short(above)}|{unknown}"
    if why:
        question, unknown = why.split("|", 1)
        case.undecided(rule, "when", question, unknown)


def _released(rule: Rule) -> Node:
    """Where a latched rule lets go."""
    return negation(rule.when.node) if rule.until is None else rule.until.node


def _kept(rule: Rule) -> Node:
    """Where a latched rule stays latched."""
    return rule.when.node if rule.until is None else negation(rule.until.node)


def _ties(case: Case, alive: NDArray[np.bool_]) -> None:
    """Rules of one priority with different actions, with a snapshot where two of them hold."""
    for k, others in ties(case.rules):
        rule = case.rules[k]
        for first in (case.rules[i] for i in others if alive[i] and alive[k]):
            guards = [first.when.node, rule.when.node]
            both = conjunction(guards)
            if case.prover.ask(both).example is not None:
                case.tell_wrong(
                    rule, "priority",
                    f"{tie(rule, [case.rules[i] for i in others])} {short(first)} and {short(rule)} both hold, for "
                    f"example, with {case.shown(case.prover.example(both), guards)}.",
                    "Give each of them its own priority.",
                )  # fmt: skip
                break
