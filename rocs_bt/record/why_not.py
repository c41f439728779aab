"""Why a rule did not fire at a time: the comparisons of its guard that held it back, and by how much.

The page gives the same answer (studio/web/why.js).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..errors import InputError, unknown
from ..words import inactive_rule
from .comparisons import guards_of
from .moment import Moment
from .samples import samples
from .tracks import Tracks

_RECENT = 1.0  # [s] a control period is not longer


class Held(NamedTuple):
    """Comparison that held a rule back.

    Attributes:
        text: The comparison as written.
        left: Value of its left side, SI units; of a group the deciding one.
        right: Value of its right side, SI units.
        unit: Their unit; may be empty.
        holds: Whether it is true and must not be, because it is under a `not`.
    """

    text: str
    left: float
    right: float
    unit: str
    holds: bool = False

    @property
    def gap(self) -> float:
        """Distance between both sides; NaN if one is not known."""
        return abs(self.left - self.right)

    def __str__(self) -> str:
        if math.isnan(self.gap):
            return f"'{self.text}' is not decided, because a value is not known"
        unit = f" {self.unit}" if self.unit else ""
        by = f" by {self.gap:.3g}{unit}" if math.isfinite(self.gap) else ""
        holds = "must not hold, but holds" if self.holds else "does not hold"
        return f"'{self.text}' {holds}{by} ({self.left:.3g} against {self.right:.3g}{unit})"


class WhyNot(NamedTuple):
    """Answer to why a rule did not fire.

    Attributes:
        rule: Rule as `file/Rule`.
        because: Reason in words.
        held: Comparisons that held it back; if all of them had been true, the guard would have been.
    """

    rule: str
    because: str
    held: tuple[Held, ...] = ()

    def __str__(self) -> str:
        return f"{self.rule.rpartition('/')[2]}: {self.because}."


def why_not(tracks: Tracks, t: float, agent: str, rule: str) -> WhyNot:
    """Why a rule did not fire at a time.

    Args:
        tracks: Tracks of the run, with its signals and rules.
        t: Time [s].
        agent: Name of the agent.
        rule: Rule as `file/Rule`.

    Raises:
        InputError: Unknown agent or rule, or a time outside the run.
    """
    moment = Moment(tracks, t, agent)
    info, state = moment.info, moment.value("rule", rule)
    known = [*(guard.rule for guard in info.guards), *info.inactive]
    if rule not in known and state is None:
        raise InputError(unknown("rule", rule, known, f"The agent '{agent}'"))
    if rule in info.inactive:
        return WhyNot(rule, inactive_rule(rule, [info.robot], info.inactive[rule]).rstrip("."))
    if state is not None and state.active:
        return WhyNot(rule, "it fired, and its action is active")
    if state is not None and state.waits:
        return WhyNot(rule, f"it is latched and waits for {(state.behind or 'another rule').rpartition('/')[2]}")
    guard = next((guard for guard in guards_of(info) if guard.info.rule == rule), None)
    times, x = samples(tracks, info, moment.now - _RECENT, moment.now)
    if guard is None or not times:
        return WhyNot(rule, "the values of its guard are not recorded")
    rows = [None if row is None else row[0].tolist() for row in guard.rows(times[-1:], x[-1:])]
    found, texts = list[Held](), guard.texts["comparisons"]
    for i in holding(guard.texts["tree"], rows, want=True):
        if (row := rows[i]) is not None:
            found.append(Held(texts[i]["text"], row[0], row[1], texts[i]["unit"], row[2] == 1.0))
    return WhyNot(rule, " and ".join(map(str, found)) or "its comparisons hold", tuple(found))


def holding(tree: Any, rows: Sequence[Sequence[float] | None], *, want: bool) -> list[int]:
    """Comparisons that keep a condition from being true, or false: the fewest that had to change.

    Args:
        tree: Structure of the condition; see `Guard`.
        rows: Left side, right side and truth of each comparison; None if it is not known.
        want: The other truth of the condition.

    Returns:
        Indices of the comparisons.
    """
    if tree is None:
        return []
    if isinstance(tree, int):
        row = rows[tree]
        return [] if row is not None and row[2] == float(want) else [tree]
    op, *parts = tree
    if op == "not":
        return holding(parts[0], rows, want=not want)
    found = [holding(part, rows, want=want) for part in parts]
    if (op == "or") is want:  # one of them is enough
        return min(found, key=lambda part: (len(part), sum(_far(rows[i]) for i in part)))
    return [i for part in found for i in part]


def _far(row: Sequence[float] | None) -> float:
    """Relative distance of both sides of a comparison, 0 to 1."""
    if row is None or not math.isfinite(row[0]) or not math.isfinite(row[1]):
        return 1.0
    most = max(abs(row[0]), abs(row[1]))
    return abs(row[0] - row[1]) / most if most else 0.0
