"""Livelocks: two rules or actions that alternate while their robot stays near one position."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from itertools import pairwise

import msgspec
import numpy as np

from ..event import OutcomeDecided, TicketChanged
from .track import Curve, Steps

ALTERNATING = 6
"""Number of changes between two rules or actions from which they count as alternating."""

NEAR = 0.5
"""Distance from its first position within which a robot makes no progress [m]."""

SHARE = 0.25
"""Share of a run from which on an alternation explains a timeout, although it has ended before."""

_SLACK = 1e-6  # [s]


class Alternation(msgspec.Struct, frozen=True):
    """Two rules or actions that have alternated without progress.

    Attributes:
        begin: Time at which the first of them began [s].
        last: Time of the last change [s].
        pause: Longest time between two changes [s].
        changes: Number of changes.
        moved: Maximum distance from the position at the begin until the last change [m].
        text: All of it in words, without an end.
        names: Both rules as `file/Rule`, or names of actions.
    """

    begin: float
    last: float
    pause: float
    changes: int
    moved: float
    text: str
    names: tuple[str, str]

    def lasts(self, t: float) -> bool:
        """Whether the alternation goes on at a time after its last change [s]."""
        return t - self.last <= self.pause + _SLACK


@dataclass
class _Turn:
    """Time in which one rule or action ran, perhaps with several tickets."""

    name: str
    begin: float  # [s]
    reflex: bool
    ticket: int
    succeeded: bool = False


class Turns:
    """The longest alternation that ends with the action that began last; fed with the tickets of one agent."""

    def __init__(self) -> None:
        self._turns: list[_Turn] = []

    def take(self, event: TicketChanged, pose: Curve | None) -> Alternation | None:
        """Take a change of a ticket; returns the alternation so far, if there is one.

        Args:
            event: The change.
            pose: Poses of the robot until then; without them nothing is known about progress.
        """
        turns = self._turns
        if event.state == "RUNNING":
            self._begin(event)
            while pose is not None and len(turns) > 1 and _moved(pose, turns[0].begin, event.t) > NEAR:
                del turns[0]
        for turn in turns[-3:]:
            turn.succeeded |= turn.ticket == event.ticket and event.state == "SUCCEEDED"
        plan = {turn.name for turn in turns if not turn.reflex}
        in_vain = not plan or plan != {turn.name for turn in turns if turn.succeeded and not turn.reflex}
        return _alternation(turns, pose) if pose and in_vain and len(turns) > ALTERNATING else None

    def _begin(self, event: TicketChanged) -> None:
        turns, reflex = self._turns, event.priority == "HIGH"
        name = event.by if reflex else event.action
        if turns and turns[-1].name == name:
            turns[-1].ticket = event.ticket
            return
        if name not in [turn.name for turn in turns[-2:]]:
            del turns[:-1]
        turns.append(_Turn(name, event.t, reflex, event.ticket))


def _alternation(turns: list[_Turn], pose: Curve) -> Alternation:
    times = [turn.begin for turn in turns]
    moved = _moved(pose, times[0], times[-1])
    names = turns[0].name, turns[1].name
    one, other = (name.rpartition("/")[2] for name in names)
    text = (
        f"{one} and {other} alternate {len(turns) - 1} times from {times[0]:.2f} s to {times[-1]:.2f} s, "
        f"and the robot stays within {moved:.2f} m"
    )
    return Alternation(times[0], times[-1], max(b - a for a, b in pairwise(times)), len(turns) - 1, moved, text, names)


def _moved(pose: Curve, begin: float, end: float) -> float:
    """Maximum distance of the poses before a time from the one at another time [m]; infinite if it is not known."""
    first, last = bisect_right(pose.t, begin + _SLACK), bisect_left(pose.t, end - _SLACK)
    if not 0 < first <= last:
        return math.inf
    rows = pose.rows(first - 1)[: last - first + 1]
    offsets = rows[:, [0, 1, 3] if pose.width > 3 else [0, 1]]
    found = np.linalg.norm(offsets - offsets[0], axis=1)
    return float(found.max()) if np.isfinite(found).all() else math.inf


def livelock(track: Curve | Steps | None, judged: OutcomeDecided, start: float) -> Alternation | None:
    """The longest alternation of an agent, if it explains the outcome: it lasts until then, or took much of the time.

    Args:
        track: Alternations of the agent.
        judged: Its outcome.
        start: Time of the start of the run [s].
    """
    found = [each for each in track.v if each is not None] if isinstance(track, Steps) else []
    if not found or judged.outcome not in ("timeout", "failed", "stuck"):
        return None
    longest: Alternation = max(found, key=lambda each: each.last - each.begin)
    took = longest.last - longest.begin
    explains = longest.lasts(judged.t) or (judged.outcome == "timeout" and took >= SHARE * (judged.t - start))
    return longest if explains else None
