"""Livelocks: two rules or actions that alternate while their robot stays near one position."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import msgspec
import numpy as np

from ...event import OutcomeDecided, TicketChanged
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
    pause: float  # [s] longest between two changes so far
    succeeded: bool = False


class Turns:
    """The longest alternation that ends with the action that began last; fed with the tickets of one agent."""

    def __init__(self) -> None:
        self._turns: list[_Turn] = []
        self._looked = 0  # number of poses that `_far` includes
        self._far = 0.0  # [m]
        self._done: set[str] = set()  # actions of the plan that have succeeded in these turns

    def take(self, event: TicketChanged, pose: Curve) -> Alternation | None:
        """Take a change of a ticket; returns the alternation so far, if there is one.

        Without poses nothing is known about progress.
        """
        turns = self._turns
        if event.state == "RUNNING":
            self._begin(event)
            while pose.t and len(turns) > 1 and self._moved(pose, event.t) > NEAR:
                self._drop(1)
        for turn in turns[-3:]:
            if turn.ticket == event.ticket and event.state == "SUCCEEDED" and not turn.reflex:
                turn.succeeded = True
                self._done.add(turn.name)
        return self._alternation() if pose.t and len(turns) > ALTERNATING and self._in_vain() else None

    def _begin(self, event: TicketChanged) -> None:
        turns, reflex = self._turns, event.priority == "HIGH"
        name = event.by if reflex else event.action
        if turns and turns[-1].name == name:
            turns[-1].ticket = event.ticket
            return
        if name not in [turn.name for turn in turns[-2:]]:
            self._drop(len(turns) - 1)
        pause = max(turns[-1].pause, event.t - turns[-1].begin) if turns else 0.0
        turns.append(_Turn(name, event.t, reflex, event.ticket, pause))

    def _drop(self, count: int) -> None:
        """Forget the first turns."""
        del self._turns[: max(count, 0)]
        self._looked, self._far, before = 0, 0.0, None
        self._done = {turn.name for turn in self._turns if turn.succeeded}
        for turn in self._turns:
            turn.pause = 0.0 if before is None else max(before.pause, turn.begin - before.begin)
            before = turn

    def _in_vain(self) -> bool:
        """Whether no action of the plan succeeds, of those that take turns."""
        plan = {turn.name for turn in self._turns[:2] if not turn.reflex}
        return not plan or plan != self._done

    def _alternation(self) -> Alternation:
        first, second, *_, last = self._turns
        changes, names = len(self._turns) - 1, (first.name, second.name)
        one, other = (name.rpartition("/")[2] for name in names)
        text = (
            f"{one} and {other} alternate {changes} times from {first.begin:.2f} s to {last.begin:.2f} s, "
            f"and the robot stays within {self._far:.2f} m"
        )
        return Alternation(first.begin, last.begin, last.pause, changes, self._far, text, names)

    def _moved(self, pose: Curve, end: float) -> float:
        """Maximum distance of the poses before a time from the one at the begin [m]; infinite if it is not known."""
        first = bisect_right(pose.t, self._turns[0].begin + _SLACK) - 1
        last = bisect_left(pose.t, end - _SLACK)
        if not 0 <= first < max(last, 1):
            return math.inf
        new = max(self._looked, first)
        columns = [0, 1, 3] if pose.width > 3 else [0, 1]
        begin = np.array(pose.data[first * pose.width : (first + 1) * pose.width])[columns]
        offsets = pose.rows(new)[: max(last - new, 0), columns] - begin
        far = np.linalg.norm(offsets, axis=1).max(initial=0.0)
        self._looked, self._far = max(last, new), max(self._far, float(far) if np.isfinite(far) else math.inf)
        return self._far


def livelock(track: Steps, judged: OutcomeDecided, start: float) -> Alternation | None:
    """The longest alternation of an agent, if it explains the outcome: it lasts until then, or took much of the time.

    Args:
        track: Alternations of the agent.
        judged: Its outcome.
        start: Time of the start of the run [s].
    """
    found = [each for each in track.v if each is not None]
    if not found or judged.outcome not in ("timeout", "failed", "stuck"):
        return None
    longest: Alternation = max(found, key=lambda each: each.last - each.begin)
    took = longest.last - longest.begin
    explains = longest.lasts(judged.t) or (judged.outcome == "timeout" and took >= SHARE * (judged.t - start))
    return longest if explains else None
