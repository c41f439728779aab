"""Metrics of each agent in summary.json, read from the tracks of a run: a run and its recording give equal metrics."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from ..base.errors import BlockError
from ..base.geometry import wrap_angle
from ..event import (
    BlockFailed,
    CommandExpired,
    CommandLimited,
    ContactBegan,
    ContentRaised,
    Event,
    GoalEntered,
    MinClearanceLowered,
    MotionHeld,
    OutcomeDecided,
    PeerFault,
    Replanned,
    RuleChanged,
    ScriptActed,
    SensorFailed,
    Stuck,
    TicketChanged,
)
from ..record import AgentInfo, AgentResult, Finding, Following, Localisation, RunHeader, SolveTime, TrackingError
from ..record.fold.alternation import livelock
from ..record.fold.clue import failed_text
from ..record.fold.tracks import Tracks

E = TypeVar("E", bound=Event)

_HELD = 0.2  # [s] maximum time that a command counts as driving; then the watchdog stops the wheels
_ENDED = ("SUCCEEDED", "FAILED", "CANCELLED")
_FAULTS = (SensorFailed, BlockFailed, ContentRaised, CommandExpired, PeerFault, MotionHeld, Stuck)
_TOPICS = ("pose", "drive", "follower", "alternation", "event")


class Metrics:
    """Event sink that follows the tracks from which the metrics of all agents are made.

    Args:
        header: Header of the run. If its world was not simulated, metrics that need ground truth are None.
    """

    def __init__(self, header: RunHeader) -> None:
        localised = any(signal.name in SIGNALS for agent in header.agents for signal in agent.signals)
        self._tracks = Tracks(header, (*_TOPICS, "signal") if localised else _TOPICS, SIGNALS)
        self.emit: Callable[[Event], None] = self._tracks.emit
        self.take: Callable[[Sequence[Event]], None] = self._tracks.take

    def of(
        self,
        agent: AgentInfo,
        end: float,
        sharing: Mapping[str, float] | None = None,
        requirements: Sequence[Finding] = (),
    ) -> AgentResult:
        """Result of one agent.

        Args:
            agent: Description of the agent.
            end: Time of the end of the run [s].
            sharing: Statistics of the knowledge that the agent shares; None if it shares none.
            requirements: Results of the agent's requirements.
        """
        tracks, name, true = self._tracks, agent.name, self._tracks.header.simulated
        events = _Events(tracks, name)
        judged = events.last(OutcomeDecided) or _cut_off(events, end)
        failed, phases = events.first(BlockFailed), Counter(event.phase for event in events.all(RuleChanged))
        touches = Counter(event.kind for event in events.all(ContactBegan))
        clearance, times = events.last(MinClearanceLowered), _Times(tracks, name)
        lock = livelock(tracks.steps(name, "alternation"), judged, tracks.header.start)
        cross = _column(tracks, name, "follower", "error")
        solve = _column(tracks, name, "solve", "")
        return AgentResult(
            robot=agent.robot,
            mission=agent.mission,
            rules=agent.rules,
            inactive_rules=agent.inactive,
            outcome=judged.outcome,
            reason=_reason(judged, events, "" if lock is None else lock.text),
            time_to_goal=judged.time_to_goal,
            failed_block=None if failed is None else failed.block,
            failed_owner=None if failed is None else failed.owner,
            faults=tuple(f"{event.t:.2f} s: {event.sentence}" for event in events.own if isinstance(event, _FAULTS)),
            exceptions=_counts(f"{event.kind} {event.content}" for event in events.all(ContentRaised)),
            goals_reached=len({event.goal for event in events.all(GoalEntered)}) if true else None,
            path_length=_path_length(tracks, name, spatial="vz" in agent.axes),
            min_clearance=None if clearance is None else clearance.distance,
            collisions=touches["collision"] if true else None,
            struck=touches["struck"] if true else None,
            contacts=_by(events.all(ContactBegan), "kind", "other") if true else None,
            fell=judged.fell if true else None,
            reflex_activations=phases["fired"],
            reflex_refirings=phases["fired again"],
            route_switches=times.switches,
            time_reactive=times.of["reactive"],
            time_deliberative=times.of["deliberative"],
            replans=len(events.all(Replanned)),
            commands_limited=_counts(event.action for event in events.all(CommandLimited)),
            actions=_by((event for event in events.all(TicketChanged) if event.state in _ENDED), "action", "state"),
            tracking_error=TrackingError(
                cross_rms=math.sqrt(sum(c * c for c in cross) / len(cross)) if cross else None,
                cross_max=max(map(abs, cross), default=None),
            ),
            solve_time=SolveTime(median=quantile(solve, 0.5), p99=quantile(solve, 0.99)),
            localisation=localisation(tracks, name) if true else None,
            following=self._following(events),
            sharing=sharing,
            requirements=tuple(requirements),
        )

    def _following(self, events: _Events) -> Following | None:
        """Distance from the leader of the first action that follows a robot; None if there is no such action."""
        for event in events.all(TicketChanged):
            if event.parameters.keys() >= {"leader", "distance", "safety"}:
                judged = _Events(self._tracks, str(event.parameters["leader"])).last(OutcomeDecided)
                reached = None if judged is None else judged.time_to_goal
                until = None if reached is None else self._tracks.header.start + reached
                return following(self._tracks, event, until)
        return None


class _Events:
    """Events of one agent."""

    def __init__(self, tracks: Tracks, agent: str) -> None:
        self.own = [event for event in tracks.events if event.agent == agent]

    def all(self, kind: type[E]) -> list[E]:
        return [event for event in self.own if isinstance(event, kind)]

    def first(self, kind: type[E]) -> E | None:
        return next((event for event in self.own if isinstance(event, kind)), None)

    def last(self, kind: type[E]) -> E | None:
        return next((event for event in reversed(self.own) if isinstance(event, kind)), None)


class _Times:
    """Time commanded by each route [s], and the number of changes between them."""

    def __init__(self, tracks: Tracks, agent: str) -> None:
        self.of = {"reactive": 0.0, "deliberative": 0.0}
        self.switches = 0
        route, driven_by, since = "", "", 0.0  # route is empty while it is idle, driven_by is not
        drives = tracks.steps(agent, "drive")
        for t, drive in zip(drives.t, drives.v, strict=True):
            if route:
                self.of[route] += min(t - since, _HELD)
            route, since = "", t
            if drive.route in self.of:
                self.switches += driven_by not in ("", drive.route)
                route = driven_by = drive.route


def _reason(judged: OutcomeDecided, events: _Events, lock: str) -> str:
    """Reason of an outcome, with the sensor without which the values in it are invalid, and a livelock."""
    failed = {event.sensor: event.t for event in events.all(SensorFailed) if "invalid" in judged.reason}
    scripted = [event.sentence for event in events.all(ScriptActed) if event.topic == "sensor" and event.name in failed]
    return "; ".join(filter(None, (judged.reason, *(failed_text(*each) for each in failed.items()), *scripted, lock)))


def _path_length(tracks: Tracks, agent: str, *, spatial: bool) -> float:
    """Length of the path of a robot [m], in space or in the plane."""
    rows = tracks.curve(agent, "pose").rows().tolist()
    length, in_space = 0.0, spatial and bool(rows) and len(rows[0]) > 3
    for before, row in pairwise(rows):
        moved = math.hypot(row[0] - before[0], row[1] - before[1])
        length += math.hypot(moved, row[3] - before[3]) if in_space else moved
    return length


def _column(tracks: Tracks, agent: str, topic: str, name: str) -> list[float]:
    """First values of all samples of a track."""
    track = tracks.curve(agent, topic, name)
    return track.rows()[:, 0].tolist() if track.t else []


def _counts(texts: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(texts).items()))


def _by(events: Iterable[Any], key: str, value: str) -> dict[str, dict[str, int]]:
    """Number of events by one field, and by another one within it."""
    found: dict[str, list[str]] = {}
    for event in events:
        found.setdefault(getattr(event, key), []).append(getattr(event, value))
    return {name: _counts(values) for name, values in sorted(found.items())}


def _cut_off(events: _Events, end: float) -> OutcomeDecided:
    """Outcome of an agent if the recording ends without one: a recorded failure or collision, else `interrupted`."""
    if (failed := events.first(BlockFailed)) is not None:
        error = BlockError(f"{failed.agent}/{failed.block}", failed.kind, failed.detail, failed.owner)
        return OutcomeDecided(t=end, outcome="error", reason=str(error))
    for event in events.all(ContactBegan):
        if event.kind == "collision":
            reason = f"it ran into {event.other} at {event.t:.2f} s"
            return OutcomeDecided(t=end, outcome="collision", reason=reason)
    return OutcomeDecided(t=end, outcome="interrupted", reason=f"the recording ends at {end:.2f} s without an outcome")


def quantile(values: Iterable[float], share: float) -> float | None:
    """Quantile of values, without interpolation; None if there are no values."""
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else None


DRIVING = 0.02
"""Wheel linear speed above which a robot counts as driving [m/s]; a robot that is pushed does not count."""


def following(tracks: Tracks, ticket: TicketChanged, until: float | None) -> Following:
    """Ground-truth distance between a follower and its leader over a run.

    The follow band is the interval `distance` +- (`distance` - `safety`), from the parameters of FollowRobot. Distances
    are counted from the time at which the follower first is not beyond the band, until the leader reaches its goal. The
    minimum distance while driving is that of the whole run.

    Args:
        tracks: Tracks of the run, with the poses.
        ticket: First ticket of FollowRobot, with its parameters `leader`, `distance` [m] and `safety` [m].
        until: Time at which the leader reached its goal [s]; None if the leader did not.
    """
    given: Mapping[str, Any] = ticket.parameters
    leader, wanted, safety = str(given["leader"]), float(given["distance"]), float(given["safety"])
    slack = wanted - safety
    kept, driving = list[float](), math.inf
    begun = False
    for t, distance, speed in _distances(tracks, ticket.agent, leader, ticket.t):
        begun = begun or distance <= wanted + slack
        if begun and (until is None or t <= until):
            kept.append(distance)
        if speed > DRIVING:
            driving = min(driving, distance)
    return Following(
        leader=leader,
        periods=len(kept),
        mean_distance=_mean(kept),
        distance_error=_mean([abs(d - wanted) for d in kept]),
        in_band=_mean([abs(d - wanted) <= slack for d in kept]),
        too_far=_mean([d > wanted + slack for d in kept]),
        least_distance=min(kept, default=None),
        least_driving=driving if math.isfinite(driving) else None,
        safe=driving >= safety,
    )


def _distances(tracks: Tracks, agent: str, leader: str, after: float) -> list[tuple[float, float, float]]:
    """Times [s], distances from the leader [m] and largest wheel linear speeds [m/s] of a follower after a time."""
    own, other, wheels = (tracks.curve(*key) for key in ((agent, "pose"), (leader, "pose"), (agent, "wheels")))
    found: list[tuple[float, float, float]] = []
    for t, (x, y, *_) in zip(own.t, own.rows().tolist(), strict=True):
        if t > after and (pose := other.last(t)) is not None:
            speeds = wheels.last(t)
            speed = 0.0 if speeds is None else max(map(abs, speeds[1]), default=0.0)
            found.append((t, math.dist((x, y), pose[1][:2]), speed))
    return found


def _mean(values: list[float] | list[bool]) -> float | None:
    return sum(values) / len(values) if values else None


SIGNALS = ("pose_covariance", "pose")
"""Signals of a robot that localises: covariance of the pose estimate, and the estimate."""


def localisation(tracks: Tracks, agent: str) -> Localisation | None:
    """Errors of the pose estimates of an agent over a run; None for a robot that does not localise."""
    covariances, estimates = (tracks.curve(agent, "signal", name) for name in SIGNALS)
    poses = tracks.curve(agent, "pose")
    distances, angles, consistency = list[float](), list[float](), list[float]()
    for t, covariance in zip(covariances.t, covariances.rows().tolist(), strict=True):
        estimate, truth = estimates.last(t), poses.last(t)
        if estimate is not None and truth is not None:
            (x, y, yaw), (true_x, true_y, true_yaw) = estimate[1], truth[1][:3]
            error = (x - true_x, y - true_y, wrap_angle(yaw - true_yaw))
            distances.append(math.hypot(error[0], error[1]))
            angles.append(abs(error[2]))
            consistency.append(_squared(error, covariance) / 3.0)
    if not distances:
        return None
    return Localisation(
        position_rms=_rms(distances),
        position_max=max(distances),
        heading_rms=_rms(angles),
        heading_max=max(angles),
        nees=sum(consistency) / len(consistency),
    )


def _rms(values: list[float]) -> float:
    return math.sqrt(sum(v * v for v in values) / len(values))


def _squared(error: tuple[float, float, float], covariance: list[float]) -> float:
    """Squared Mahalanobis distance e' P^-1 e.

    Args:
        error: Error e: x [m], y [m], yaw [rad].
        covariance: Upper triangle of the covariance P, row by row, 6 values.
    """
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = covariance
    matrix += np.triu(matrix, 1).T
    return float(np.array(error) @ np.linalg.solve(matrix, np.array(error)))
