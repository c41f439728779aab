"""What can be wrong with two rules: one is never heard beside the other, or it is chance which of them acts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...expression import Node
from ..rule import OnInvalid, Rule, tie, ties
from .case import Case, short
from .sample import Samples
from .translate import conjunction, negation

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
