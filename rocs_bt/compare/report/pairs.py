"""Verdicts on many pairs as text for a terminal: a matrix per metric, then the conclusive pairs in words."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from ...base.words import counted
from ..metric import SHARES
from ..verdict import Verdict, favourable
from .tables import matrix

WIDTH = 100
_SIGNS = {"better": "+", "not better": "-", "inconclusive": "?"}
LEGEND = "+ better than the column's, - worse, ? inconclusive"


def pairs(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    """Lines of text on each metric: one sentence for two planners, a matrix and sentences for more.

    Args:
        verdicts: Verdicts on all pairs of the planners.
        planners: Names of the planners, the best first.
    """
    found: list[str] = []
    for name in dict.fromkeys(verdict.metric for verdict in verdicts):
        of = [favourable(verdict) for verdict in verdicts if verdict.metric == name]
        found += [str(of[0])] if len(of) == 1 else [*_of_metric(of, planners), ""]
    return found


def _of_metric(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    decided = [verdict for verdict in verdicts if verdict.word == "better"]
    lines = [f"{verdicts[0].metric}: {len(decided)} of {counted(len(verdicts), 'pair')} conclusive"]
    if decided:
        lines[0] += f" ({LEGEND})"
        lines += _square(verdicts, planners)
    for name in planners:
        beaten = sorted((v for v in decided if v.a == name), key=lambda v: planners.index(v.b))
        if beaten:
            words = ", ".join(f"{v.b} by {_by(v)}" for v in beaten)
            lines += _wrapped(f"{name} is better than {words}")
    if open_ := [verdict for verdict in verdicts if verdict.word == "inconclusive"]:
        lines += _wrapped(_open(open_))
    return lines


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="      ", break_on_hyphens=False)


def _square(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    """Matrix as lines of text: one row per planner with the verdicts against the others, in numbered columns."""
    wide, digits = max(map(len, planners)), len(str(len(planners)))
    numbers = [str(number).rjust(digits) for number in range(1, len(planners) + 1)]
    lines = [f"  {'':{digits + 1 + wide}}  {' '.join(numbers)}"]
    for number, row, against in zip(numbers, planners, matrix(verdicts, planners), strict=True):
        cells = ["." if verdict is None else _SIGNS[verdict.word] for verdict in against]
        lines.append(f"  {number} {row:{wide}}  {' '.join(cell.rjust(digits) for cell in cells)}")
    return lines


def _by(verdict: Verdict) -> str:
    if verdict.metric in SHARES:
        points = f"{100.0 * verdict.difference:.3g}"
        return f"{points} point{'' if points == '1' else 's'}"
    return f"{verdict.difference:.3g} {verdict.unit}".rstrip()


def _open(verdicts: Sequence[Verdict]) -> str:
    """Sentence with the number of inconclusive pairs, and the estimated number of scenes for conclusive verdicts."""
    needed = sorted(verdict.needed for verdict in verdicts if verdict.needed is not None)
    kind = "scenes" if max(verdict.scenes for verdict in verdicts) > 1 else "seeds"
    count = f"{len(verdicts)} inconclusive"
    if not needed:
        return f"{count}, without a difference that more {kind} would probably show"
    same = len(verdicts) - len(needed)
    if needed[0] == needed[-1]:
        estimate = f"about {needed[0]} {kind} needed" + (" for all that differ" if same else "")
    else:
        half = needed[(len(needed) - 1) // 2]
        middle = f", {half} for half" if needed[0] < half < needed[-1] else ""
        estimate = f"about {needed[0]} {kind} needed for the first{middle}, {needed[-1]} for all"
        estimate += " that differ" if same else ""
    return f"{count}: {estimate}" + (f"; {same} {'shows' if same == 1 else 'show'} no difference" if same else "")
