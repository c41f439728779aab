"""Checks of pairs of rules: ties, and rules that never act because another rule always acts instead."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...expression import Node
from ..rule import OnInvalid, Rule, tie, ties
from .case import Case, short
from .prover import conjunction, negation
from .sample import Samples
from .validity import decided, monotone, needed

TRIED = 6  # maximum number of rules of higher priority that are tested for shadowing one rule


def check_pairs(case: Case) -> None:
    """Report ties, and rules that never act because a rule of higher priority always acts instead (shadowing)."""
    rules = case.rules
    if len(rules) < 2:
        return
    examples = [case.prover.decide(rule.when.node).example for rule in rules]
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
    """Find candidates for shadowing: rules of higher priority that held on all samples on which a rule held.

    Yields the index of a rule, and those of at most TRIED candidates.

    Args:
        rules: The R rules.
        truths: 1 for each rule and sample on which the guard held, else 0; shape (R, samples).
        alive: Whether a snapshot is known on which each guard holds, shape (R,).
    """
    uncovered = truths @ (1.0 - truths).T  # [i, k]: number of samples on which i held and k did not
    priority = np.array([rule.priority for rule in rules])
    for i, rule in enumerate(rules):
        if alive[i]:
            found = np.flatnonzero((uncovered[i] == 0.0) & (priority > rule.priority) & alive)
            ranked = sorted(found.tolist(), key=lambda k: (-int(truths[k].sum()), k))
            if ranked:
                yield i, [k for k in ranked if _hides(rules[k], rule)][:TRIED]


def _hides(above: Rule, rule: Rule) -> bool:
    """Whether `above` always acts instead of `rule`, if it is latched on every snapshot on which `rule` is."""
    everywhere = not above.modes or bool(rule.modes and set(rule.modes) <= set(above.modes))
    return everywhere and above.hold <= rule.hold and not above.cooldown and _hides_invalid(above, rule)


def _hides_invalid(above: Rule, rule: Rule) -> bool:
    """Whether `above` hides `rule` while signals are invalid, if it does so while all signals are valid.

    Without an operator that ignores invalid operands, what holds while a signal is invalid holds for each valid value
    of the signal. So two conditions that exclude each other while all signals are valid cannot both hold; but the
    second one can be invalid, where the rule's policy decides.
    """
    if not all(monotone(node) for each in (above, rule) for node in (each.when.node, released(each))):
        return False
    guard, release = above.when.node, released(above)
    if rule.on_invalid is not OnInvalid.CLEAR:  # it latches also on an invalid guard
        return (
            above.on_invalid is OnInvalid.TRIP
            and decided(rule.when.node, needed(guard, False))
            and decided(released(rule), needed(release, True))
            and decided(rule.when.node, needed(release, True))
        )
    latches = above.on_invalid is OnInvalid.TRIP or decided(guard, needed(rule.when.node, True))
    active = needed(kept(rule), True) & needed(rule.when.node, True)
    stays = above.on_invalid is not OnInvalid.CLEAR or decided(release, active)
    return latches and stays


def _shadowed(case: Case, rule: Rule, others: Sequence[Rule]) -> None:
    """Report that a rule never acts, if one of the candidates is proved to be latched whenever the rule is."""
    guard, why = rule.when.node, ""
    for above in others:
        questions = [(guard, negation(above.when.node)), (released(above), kept(rule)), (released(above), guard)]
        answers = [case.prover.decide(conjunction(question)) for question in questions]
        if all(answer.never for answer in answers):
            example = case.shown(case.prover.example(guard), [guard, above.when.node])
            case.warn(
                rule,
                "when",
                f"{short(rule)} never acts: whenever it is latched, so is {short(above)}, with a priority of "
                f"{above.priority}, higher than {rule.priority}; both hold, for example, with {example}.",
                f"Give {short(rule)} the higher priority, or a guard that is not covered by that of {short(above)}.",
                guard,
            )
            return
        unknown = next((answer.unknown for answer in answers if answer.unknown), "")
        if unknown and all(answer.example is None for answer in answers):
            why = why or f"whether {short(rule)} ever acts beside {short(above)}|{unknown}"
    if why:
        question, unknown = why.split("|", 1)
        case.undecided(rule, "when", question, unknown)


def released(rule: Rule) -> Node:
    """Release condition of a latched rule."""
    return negation(rule.when.node) if rule.until is None else rule.until.node


def kept(rule: Rule) -> Node:
    """Condition under which a latched rule stays latched."""
    return rule.when.node if rule.until is None else negation(rule.until.node)


def _ties(case: Case, alive: NDArray[np.bool_]) -> None:
    """Report rules of equal priority with guards that can hold at once, and example values of the signals.

    Args:
        case: Rule set.
        alive: Whether a snapshot is known on which each guard holds, shape (R,).
    """
    for k, others in ties(case.rules):
        rule = case.rules[k]
        for first in (case.rules[i] for i in others if alive[i] and alive[k]):
            guards = [first.when.node, rule.when.node]
            both = conjunction(guards)
            if case.prover.decide(both).example is not None:
                case.error(
                    rule,
                    "priority",
                    f"{tie(rule, [case.rules[i] for i in others])} {short(first)} and {short(rule)} both hold, for "
                    f"example, with {case.shown(case.prover.example(both), guards)}.",
                    "Give each of them its own priority.",
                )
                break
