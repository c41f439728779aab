"""The verdicts on many pairs in few lines, for a screen: by metric a matrix, then in words what is told apart."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from ..metric import SHARES
from ..verdict import Verdict, favourable
from .tables import matrix

WIDTH = 100
_SIGNS = {"better": "+", "not better": "-", "inconclusive": "?"}
LEGEND = "+ better than the column's, - worse, ? cannot be told"


def pairs(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    """A few lines for each metric; of two planners one sentence, of more a matrix and words.

    Args:
        verdicts: On all pairs of the planners.
        planners: Their names, the best first.
    """
    found: list[str] = []
    for name in dict.fromkeys(verdict.metric for verdict in verdicts):
        of = [favourable(verdict) for verdict in verdicts if verdict.metric == name]
        found += [str(of[0])] if len(of) == 1 else [*_of_metric(of, planners), ""]
    return found


def _of_metric(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    told = [verdict for verdict in verdicts if verdict.word == "better"]
    are = "is" if len(told) == 1 else "are"
    lines = [f"{verdicts[0].metric}: {len(told)} of {len(verdicts)} pairs {are} told apart"]
    if told:
        lines[0] += f" ({LEGEND})"
        lines += _square(verdicts, planners)
    for name in planners:
        beaten = sorted((v for v in told if v.a == name), key=lambda v: planners.index(v.b))
        if beaten:
            words = ", ".join(f"{v.b} by {_by(v)}" for v in beaten)
            lines += _wrapped(f"{name} is better than {words}")
    if open_ := [verdict for verdict in verdicts if verdict.word == "inconclusive"]:
        lines += _wrapped(_open(open_))
    return lines


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="      ", break_on_hyphens=False)


def _square(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[str]:
    """A row each planner: how it stands to the others, which have numbers for columns."""
    wide, digits = max(map(len, planners)), len(str(len(planners)))
    numbers = [str(number).rjust(digits) for number in range(1, len(planners) + 1)]
    lines = [f"  {'':{digits + 1 + wide}}  {' '.join(numbers)}"]
    for number, row, stands in zip(numbers, planners, matrix(verdicts, planners), strict=True):
        cells = ["." if verdict is None else _SIGNS[verdict.word] for verdict in stands]
        lines.append(f"  {number} {row:{wide}}  {' '.join(cell.rjust(digits) for cell in cells)}")
    return lines


def _by(verdict: Verdict) -> str:
    if verdict.metric in SHARES:
        points = f"{100.0 * verdict.difference:.3g}"
        return f"{points} point{'' if points == '1' else 's'}"
    return f"{verdict.difference:.3g} {verdict.unit}".rstrip()


def _open(verdicts: Sequence[Verdict]) -> str:
    """How many pairs are not told apart, and how many scenes would probably do that."""
    needed = sorted(verdict.needed for verdict in verdicts if verdict.needed is not None)
    kind = "scenes" if max(verdict.scenes for verdict in verdicts) > 1 else "seeds"
    count = f"{len(verdicts)} inconclusive"
    if not needed:
        return f"{count}, with no difference that more {kind} would be likely to find"
    same = len(verdicts) - len(needed)
    all_ = "all that differ" if same else "all of them"
    if needed[0] == needed[-1]:
        told = f"about {needed[0]} {kind} would settle {all_}"
    else:
        half = needed[(len(needed) - 1) // 2]
        middle = f", {half} half of {'those that differ' if same else 'them'}" if needed[0] < half < needed[-1] else ""
        told = f"about {needed[0]} {kind} would settle the first{middle}, {needed[-1]} {all_}"
    return f"{count}: {told}" + (f"; {same} {'shows' if same == 1 else 'show'} no difference" if same else "")
