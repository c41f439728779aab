"""Decisive moments of a run: what a person wants to see first, on the page and by `--why`."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from ...event import ContactBegan, Level, OutcomeDecided
from ..fold.alternation import livelock
from ..fold.samples import stopped
from ..fold.states import TrackKey
from ..fold.tracks import Tracks
from .moment import MissionState

DECISIVE_TOPICS = ("pose", "node", "rule", "stopped", "outcome", "alternation", "failures", "event")
"""Topics of tracks from which the decisive moments are found."""

AGAIN = 3
"""Number of failures of a rule's action from which on they count as the cause."""

_BEFORE = 0.01  # [s] before an outcome, when the nodes are not halted yet


class Decisive(msgspec.Struct, frozen=True):
    """Decisive moment of an agent.

    Attributes:
        t: Time [s].
        about: Track that it is about.
        text: Cause in words; may be empty.
    """

    t: float
    about: TrackKey
    text: str = ""


def decisive(tracks: Tracks, outcomes: Mapping[str, str] = {}) -> list[Decisive]:
    """Causes of all failures, in the order of the agents; without a failure the first reflex, if one fired.

    `outcomes` is for a recording that was cut off before they were decided.
    """
    judged = (_judged(tracks, agent.name, outcomes) for agent in tracks.header.agents)
    failures = [_cause(tracks, each) for each in judged if each is not None and each.outcome != "success"]
    return failures or _first_reflex(tracks)


def _judged(tracks: Tracks, agent: str, outcomes: Mapping[str, str]) -> OutcomeDecided | None:
    if decided := tracks.steps(agent, "outcome").v:
        return decided[-1]  # type: ignore[no-any-return]  # tracks hold anything
    end = min(stopped(tracks, agent), tracks.end)
    return OutcomeDecided(t=end, agent=agent, outcome=outcomes[agent], reason="") if agent in outcomes else None


def _cause(tracks: Tracks, judged: OutcomeDecided) -> Decisive:
    t, agent = judged.t, judged.agent
    if lock := livelock(tracks.steps(agent, "alternation"), judged, tracks.header.start):
        return Decisive(lock.begin, TrackKey(agent, "alternation"), lock.text)
    for line in reversed(tracks.log):
        about = line.about  # a sensor that failed need not be the cause
        if line.agent == agent and line.level >= Level.ERROR and line.t <= t and about and about.topic != "sensor":
            return Decisive(line.t, about)
    if judged.outcome in ("timeout", "failed", "stuck") and (failing := _failing(tracks, agent, t)):
        return failing
    mission = MissionState(tracks, agent, t)
    leaf = mission.failed() or max((p for p in mission.nodes if mission.status(p) == "FAILURE"), key=len, default="")
    if leaf and mission.note(leaf):
        return Decisive(mission.since(leaf), TrackKey(agent, "node", leaf))
    # A leaf such as AlwaysFailure has no message: one before it often has.
    said = _said(tracks, mission, agent, t) if judged.outcome == "failed" else None
    if said is None and leaf:
        return Decisive(mission.since(leaf), TrackKey(agent, "node", leaf))
    if judged.outcome == "collision":  # it need not have ended the run
        hits = (
            e.t for e in tracks.events if isinstance(e, ContactBegan) and e.agent == agent and e.kind == "collision"
        )
        t = min(hits, default=t)
    return said or Decisive(max(tracks.header.start, t - _BEFORE), TrackKey(agent, "outcome"))


def _failing(tracks: Tracks, agent: str, t: float) -> Decisive | None:
    """The first failure of the action of the rule that is active at a time, if it fails again and again."""
    rules = (name for name, state in tracks.state(t, agent, "rule").items() if state.active)
    for rule in rules:
        failures = tracks.steps(agent, "failures", rule).at(t)
        if failures is not None and failures.count >= AGAIN:
            return Decisive(failures.first, TrackKey(agent, "rule", rule), failures.text)
    return None


def _said(tracks: Tracks, mission: MissionState, agent: str, end: float) -> Decisive | None:
    """The last leaf that failed with a message; of several at once the last of the tree."""
    found = None
    for path, node in mission.nodes.items():
        track, notes = (tracks.steps(agent, topic, path) for topic in ("node", "note"))
        if node.children:
            continue
        failed = [t for t, status in zip(track.t, track.v, strict=True) if status == "FAILURE" and t <= end]
        last = max((t for t in failed if notes.at(t)), default=None)
        if last is not None and (found is None or last >= found.t):
            found = Decisive(last, TrackKey(agent, "node", path))
    return found


def _first_reflex(tracks: Tracks) -> list[Decisive]:
    fired = (
        Decisive(
            next(t for t, state in zip(track.t, track.v, strict=True) if state.fired),
            TrackKey(agent.name, "rule", rule),
        )
        for agent in tracks.header.agents
        for rule, track in tracks.steps_of(agent.name, "rule").items()
        if track.v[-1].fired
    )
    first = min(fired, key=lambda each: each.t, default=None)
    return [] if first is None else [first]
