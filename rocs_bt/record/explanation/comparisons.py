"""Guards of rules over a run: both sides of each comparison, how near each guard is, and what keeps its rule back."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ...base.errors import InputError
from ...event import GuardInfo, RulesReplaced
from ...expression import parse
from ..file.header import AgentInfo
from ..fold.samples import environment_of, modes, samples
from ..fold.states import GuardState
from ..fold.tracks import Tracks
from .condition import Condition, Found, Numbers, run_starts

_NEAR = 20  # steps of how near a guard is; rounded down, because only 1 is true
_SLACK = 1e-6  # [s] between a sample and the events of its control period


class Comparisons:
    """Adds the tracks of all guards to the tracks of a run.

    The topic `compare` has left side, right side and truth (1, 0 or NaN) of each comparison, of `held` and `once` a
    time and their window. `near`, of a guard, is 1 while the guard is true, and only then; else it is the ratio of the
    smaller to the larger side of a comparison that has to change: of an `and` the least of its parts, of an `or` the
    greatest. `guard` has what keeps the rule from latching, a `GuardState`.
    """

    def __init__(self, tracks: Tracks, only: Collection[str] = ()) -> None:
        self._tracks, self._only = tracks, only
        self._done = {agent.name: -math.inf for agent in tracks.header.agents}
        self._guards = {a.name: guards_of(a, a.guards, only) for a in tracks.header.agents if a.signals}
        self._heard = 0  # events

    def update(self, *, over: bool = False) -> None:
        """Add the guards in all control periods that are complete; in all if the run is over."""
        end = math.inf if over else self._tracks.end
        self._replace()
        for agent in self._tracks.header.agents:
            guards = self._guards.get(agent.name)
            if not guards:
                continue
            t, x = samples(self._tracks, agent, self._done[agent.name], end)
            if t:
                self._done[agent.name] = t[-1]
                entered = modes(self._tracks, agent.name, t)
                for guard in guards:
                    guard.add(self._tracks, agent.name, t, x, entered)
                guards[:] = (guard for guard in guards if guard.end > t[-1])

    def _replace(self) -> None:
        """Follow the guards of a rule file until it is replaced, and from then on the new ones."""
        events, agents = self._tracks.events, {agent.name: agent for agent in self._tracks.header.agents}
        for event in events[self._heard :]:
            if isinstance(event, RulesReplaced) and event.accepted and event.agent in self._guards:
                guards = self._guards[event.agent]
                new = [guard for guard in event.guards if not guard.faults]
                for guard in guards:
                    if guard.info.rule.rpartition("/")[0] == event.rules and guard.end > event.t:
                        guard.end = event.t
                        guard.next = next((info for info in new if info.rule == guard.info.rule), None)
                guards += guards_of(agents[event.agent], new, self._only, event.t)
        self._heard = len(events)


def guards_of(
    agent: AgentInfo, infos: Sequence[GuardInfo], only: Collection[str] = (), begin: float = -math.inf
) -> list[Guard]:
    """Guards of an agent's rules, or of some, from a time on [s]; without those that only their rule file can read."""
    found = []
    environment = environment_of(agent)
    for info in infos:
        try:
            if not only or info.rule in only:
                found.append(Guard(info, [Condition(parse(text, environment)) for text in info.sources], begin))
        except InputError:  # a guard with names that only its rule file knows
            continue
    return found


class Guard:
    """Guard of one rule: its conditions, and the time for which they hold.

    Attributes:
        info: Description of the guard.
        begin: Time from which it is the guard of its rule [s].
        end: Time at which the rule's file was replaced [s].
        next: Description of the guard of the rule from then on; None if the new file has none.
    """

    def __init__(self, info: GuardInfo, conditions: Sequence[Condition], begin: float = -math.inf) -> None:
        self.info, self.begin, self.end = info, begin, math.inf
        self.next: GuardInfo | None = None
        self._conditions = conditions
        self._names = [f"{info.rule}\n{i}" for i in range(len(info.comparisons))]
        self._since = self._unknown = math.nan  # begins of the runs in which the guard counts, and is not known [s]
        self._counted = self._latched = False
        self._ready = self._seen = -math.inf  # end of the cooldown, last change of the rule [s]

    def add(
        self,
        tracks: Tracks,
        agent: str,
        t: Sequence[float],
        x: Numbers,
        entered: Sequence[str],
    ) -> None:
        """Add the guard at times to the tracks of an agent.

        Args:
            tracks: Tracks of the run.
            agent: Name of the agent.
            t: Times of the samples [s].
            x: Samples of all signals, SI units, shape (n, size).
            entered: Mode of the agent at these times.
        """
        own = slice(bisect_left(t, self.begin), bisect_left(t, self.end))
        if own.start < own.stop:
            found = [condition(t[own], x[own]) for condition in self._conditions]
            self._put(tracks, agent, t[own], [row for each in found for row in each.rows], found[0].near)
            self._keep(tracks, agent, np.array(t[own]), found[0], entered[own])
        if own.stop < len(t):
            more, nothing = len(self.next.comparisons) if self.next else 0, np.full((1, 3), math.nan)
            for name in self._names[more:]:
                tracks.samples(agent, "compare", name, 3).extend([self.end], nothing)
            if self.next is None:
                tracks.samples(agent, "near", self.info.rule, 1).extend([self.end], nothing[:, :1])
                tracks.begun(agent, "guard", self.info.rule).put(self.end, GuardState(replaced=True))

    def _put(self, tracks: Tracks, agent: str, t: Sequence[float], rows: Sequence[Numbers], near: Numbers) -> None:
        for name, row in zip(self._names, rows, strict=True):
            tracks.samples(agent, "compare", name, 3).extend(t, row)
        tracks.samples(agent, "near", self.info.rule, 1).extend(t, np.floor(near[:, None] * _NEAR) / _NEAR)

    def _keep(self, tracks: Tracks, agent: str, t: Numbers, found: Found, entered: Sequence[str]) -> None:
        """Add what keeps the rule from latching."""
        modes = self.info.modes
        enabled = np.array([not modes or mode in modes for mode in entered[: len(t)]])
        latched, ready = self._rule(tracks, agent, t)
        counts = self._counts(found.truth, t, enabled & ~latched)
        since = run_starts(counts, t, self._since)
        self._since = float(since[-1])
        blind = counts & np.isnan(found.truth)
        other = np.where(enabled, -1, np.unique(entered[: len(t)], return_inverse=True)[1])
        kept = np.column_stack([other, found.needs, since, blind, np.where(counts, ready, -math.inf)])
        changes = (kept[1:] != kept[:-1]) & ~(np.isnan(kept[1:]) & np.isnan(kept[:-1]))
        track = tracks.begun(agent, "guard", self.info.rule)
        for i in [0, *(np.flatnonzero(changes.any(axis=1)) + 1).tolist()]:
            if not enabled[i]:
                state = GuardState(mode=entered[i])
            elif counts[i]:
                later = float(ready[i]) if ready[i] > t[i] else None
                state = GuardState(since=float(since[i]), blind=bool(blind[i]), ready=later)
            else:
                needs = found.needs[i].tolist()
                state = GuardState(held=tuple(k if need > 0 else -1 - k for k, need in enumerate(needs) if need))
            track.put(float(t[i]), state)

    def _counts(self, truth: Numbers, t: Numbers, active: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether the guard of a rule that can latch counts as true; while it is not known, `on_invalid` decides."""
        counts: NDArray[np.bool_] = active & (truth == 1.0)
        unknown = active & np.isnan(truth)
        since = run_starts(unknown, t, self._unknown)
        self._unknown = float(since[-1])
        if self.info.on_invalid == "trip":
            counts |= unknown
        elif self.info.on_invalid == "hold":
            waits = unknown & (t - since < self.info.max_hold - _SLACK)
            last = np.maximum.accumulate(np.where(waits, -1, np.arange(len(t))))
            counts = np.where(last < 0, self._counted, (counts | unknown)[last])
        self._counted = bool(counts[-1])
        return counts

    def _rule(self, tracks: Tracks, agent: str, t: Numbers) -> tuple[NDArray[np.bool_], Numbers]:
        """Whether the rule was latched before or after the times, and the end of its cooldown then [s]."""
        track, info = tracks.steps(agent, "rule", self.info.rule), self.info
        times, values = track.t, track.v
        first = bisect_right(times, self._seen)
        times, latched, ready = times[first:], [self._latched], [self._ready]
        for at, state in zip(times, values[first:], strict=True):
            starts = state.latched != latched[-1] and state.latched is not info.level
            ready.append(at + info.cooldown if starts else ready[-1])
            latched.append(state.latched)
        after = np.searchsorted(times, t + _SLACK, side="right")
        before = np.searchsorted(times, t - _SLACK, side="left")
        if known := int(after[-1]):
            self._seen, self._latched, self._ready = times[known - 1], latched[known], ready[known]
        return np.array(latched)[before] | np.array(latched)[after], np.array(ready)[after]
