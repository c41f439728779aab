"""Why a rule did not fire at a time: the comparisons of its guard that held it back, and by how much.

The page gives the same answer (studio/web/why.js).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...base.errors import InputError, unknown
from ...base.words import inactive_rule
from ...event import GuardInfo
from ..fold.clue import limit_text
from ..fold.states import GuardState, RuleState
from ..fold.tracks import Tracks
from .comparisons import Comparisons
from .evidence import since
from .moment import SLACK, Moment

ONLY_INVALID = "; it fires only when its signals are invalid"
"""What is said of a guard that can never hold."""


class Held(NamedTuple):
    """Comparison that held a rule back.

    Attributes:
        text: The comparison as written.
        left: Value of its left side, SI units; of a group the deciding one, of `held` and `once` a time.
        right: Value of its right side, SI units.
        unit: Their unit; may be empty.
        holds: Whether it is true and must not be; None if it is not decided.
        limit: Sentence if the left side is a limit of a sensor.
    """

    text: str
    left: float
    right: float
    unit: str
    holds: bool | None = False
    limit: str = ""

    @property
    def gap(self) -> float:
        """Distance between both sides; NaN if one is not known."""
        return abs(self.left - self.right)

    def __str__(self) -> str:
        if self.holds is None:
            return f"'{self.text}' is not decided, because a value is not known"
        holds = f"'{self.text}' {'must not hold, but holds' if self.holds else 'does not hold'}"
        if math.isnan(self.gap):
            return holds
        unit = f" {self.unit}" if self.unit else ""
        by = f" by {self.gap:.3g}{unit}" if math.isfinite(self.gap) else ""
        return f"{holds}{by} ({self.left:.3g} against {self.right:.3g}{unit}{self.limit and '; '}{self.limit})"


class WhyNot(NamedTuple):
    """Answer to why a rule did not fire.

    Attributes:
        rule: Rule as `file/Rule`.
        because: Reason in words.
        held: Comparisons that held it back, the fewest; with all of them changed, its guard would have been true.
    """

    rule: str
    because: str
    held: tuple[Held, ...] = ()

    def __str__(self) -> str:
        return f"{self.rule.rpartition('/')[2]}: {self.because}."


def why_not(tracks: Tracks, t: float, agent: str, rule: str) -> WhyNot:
    """Why a rule did not fire at a time.

    Args:
        tracks: Tracks of the run, with its signals and rules. The tracks of the guard are added if they are missing.
        t: Time [s].
        agent: Name of the agent.
        rule: Rule as `file/Rule`.

    Raises:
        InputError: Unknown agent or rule, or a time outside the run.
    """
    moment = Moment(tracks, t, agent)
    info, state = moment.info, moment.value("rule", rule)
    known = [*dict.fromkeys([*(guard.rule for guard in info.guards), *tracks.of(agent, "guards")]), *info.inactive]
    if rule not in known and state is None:
        raise InputError(unknown("rule", rule, known, f"The agent '{agent}'"))
    if rule in info.inactive:
        return WhyNot(rule, inactive_rule(rule, [info.robot], info.inactive[rule]).rstrip("."))
    if state is not None and state.active:
        return WhyNot(rule, "it fired, and its action is active")
    if state is not None and state.waits:
        return WhyNot(rule, _waits(moment, rule, state))
    if moment.since("stopped") < t - SLACK:
        return WhyNot(rule, f"the agent was stopped{since(moment.since('stopped'), t)}")
    if tracks.get(agent, "guard", rule) is None:
        Comparisons(tracks, [rule]).update(over=True)
    found, guard = moment.value("guard", rule), tracks.guard(agent, rule, moment.now)
    if found is None or guard is None:
        return WhyNot(rule, "the values of its guard are not recorded")
    held = tuple(_held(moment, guard, index) for index in found.held)
    because = " and ".join(map(str, held))
    return WhyNot(
        rule, f"{because}{ONLY_INVALID if guard.only_invalid else ''}" if held else _back(guard, found, t), held
    )


def _waits(moment: Moment, rule: str, state: RuleState) -> str:
    """That a rule waits for another, and why."""
    other, own = (moment.tracks.guard(moment.agent, name, moment.now) for name in (state.behind, rule))
    above = other is not None and own is not None and other.priority > own.priority
    fired = "" if state.firing is None else f", fired last at t = {state.firing[0]:.2f} s,"
    name = (state.behind or "another rule").rpartition("/")[2]
    return f"it is latched{fired} and waits for {name}{', which has a higher priority' if above else ''}"


def _held(moment: Moment, guard: GuardInfo, index: int) -> Held:
    i = index if index >= 0 else -1 - index
    left, right, truth = moment.value("compare", f"{guard.rule}\n{i}")
    limit = limit_text(guard, left) if guard.units[i] == "m" else ""
    return Held(guard.comparisons[i], left, right, guard.units[i], None if math.isnan(truth) else truth == 1.0, limit)


def _back(guard: GuardInfo, state: GuardState, t: float) -> str:
    """What keeps a rule back if no comparison does."""
    if state.replaced:
        return "its rule file was replaced, and the new one does not have it"
    if state.mode is not None:
        modes = " or ".join(f"'{mode}'" for mode in guard.modes)
        return f"it acts in mode {modes} only, and the mode is '{state.mode}'"
    if state.since is None:
        return "nothing that it compares can make its guard true"
    blind = "its guard cannot be evaluated, which counts as true"
    lasts, reasons = t - state.since, list[str]()
    if lasts < guard.hold:
        held = f"{max(lasts, 0.0):.2f} s of the {guard.hold:.3g} s that it must"
        reasons.append(f"{f'{blind},' if state.blind else 'its guard has held'} for {held}")
    if state.ready is not None and state.ready > t:
        reasons.append(f"its cooldown ends in {state.ready - t:.2f} s")
    return " and ".join(reasons) or (blind if state.blind else "its guard holds")
