"""Tracks: what held at any time of a run, folded once from its events.

Each thing that changes in a run is a track, found by its agent, topic and name: the pose of a body, a signal, the
command of an actuator, the status of a node, the state of a rule or ticket, a fact, an outcome. A track is a step
function, so the state at a time is a search in the tracks that are asked for. One function per topic makes the tracks
from the events; everything that shows, explains or measures a run reads them.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import msgspec

from ...event import (
    ActuatorCommanded,
    AgentStopped,
    AtomicStarted,
    BlackboardChanged,
    BlockFailed,
    BodyMoved,
    ContactBegan,
    Event,
    FollowerStepped,
    GuardInfo,
    KnowledgeChanged,
    MapChanged,
    MinClearanceLowered,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    OutcomeDecided,
    PathPlanned,
    RobotPushed,
    RuleChanged,
    RulesReplaced,
    RunControlled,
    ScriptActed,
    SensorFailed,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    TicketChanged,
    pack,
)
from ..file.codec import KINDS
from ..file.header import RunHeader
from ..file.recording import Recording
from .actors import ActorMotion
from .alternation import Turns
from .clue import Clues
from .motion import MOTION, motion_words, tilt_words
from .states import Drive, Failures, LogLine, RuleState, TrackKey, about
from .track import Curve, Scans, Steps, TrackSet


class Tracks(TrackSet):
    """What held at any time of a run; fed by a recording, or by a run that goes on.

    Args:
        header: Header of the run.
        topics: Topics to follow; all of `TOPICS` by default.
        signals: Names of the signals to follow; all by default.

    Attributes:
        events: Events that are not emitted in every period, in order.
        end: Time of the last event [s].
        movers: Actuator that moves each robot, the first that was commanded; empty after its stop.
        turns: Alternations of rules and actions so far, by agent.
        clues: Finder of clues.
        facts: Names of the facts about each node, by agent and node.
        actors: Movements so far, by body.
        scanners: Number of rays by agent and sensor.
    """

    def __init__(self, header: RunHeader, topics: Collection[str] = (), signals: Collection[str] = ()) -> None:
        super().__init__()
        self.header = header
        self.events: list[Event] = []
        self.signals = frozenset(signals)
        self._log: list[LogLine] = []
        self._logged = 0
        self.end = header.start
        self.movers: dict[str, str] = {}
        self._running: dict[tuple[str, int], TicketChanged] = {}
        self.turns: defaultdict[str, Turns] = defaultdict(Turns)
        self.clues = Clues(header, self)
        self.facts: dict[tuple[str, str], set[str]] = {}
        self.actors = {body.name: ActorMotion(body, header.start) for body in header.bodies}
        self._ages = {(a.name, s.name): s.max_age for a in header.agents for s in a.signals if s.max_age is not None}
        self.scanners = {(b.name, name): len(beams) for b in header.bodies for name, beams in b.beams.items()}
        self.scanners |= {(b.name, name): fan.rays for b in header.bodies for name, fan in b.fans.items()}
        self._folds: dict[type[Event], list[Callable[[Tracks, Any], None]]] = {}
        for name in topics or TOPICS:
            for kind, fold in TOPICS[name].items():
                self._folds.setdefault(kind, []).append(fold)
        for agent in header.agents:
            self.begun(agent.name, "tree").put(header.start, agent.nodes)

    @staticmethod
    def of_recording(recording: Recording, topics: Collection[str] = ()) -> Tracks:
        """Tracks of a recording; only the events of the topics are decoded."""
        tracks = Tracks(recording.header, topics)
        tracks.take(recording.events(tracks.kinds))
        return tracks

    @property
    def log(self) -> list[LogLine]:
        """Sentences about the events, in order."""
        for event in self.events[self._logged :]:
            if type(event).sentence is not Event.sentence and (text := event.sentence):
                self._log.append(LogLine(event.t, event.agent, event.level, text, about(event)))
        self._logged = len(self.events)
        return self._log

    @property
    def kinds(self) -> Collection[type[Event]]:
        """Types of events that these tracks take."""
        return self._folds.keys()

    def emit(self, event: Event) -> None:
        """Take one event."""
        self.take((event,))

    def take(self, events: Iterable[Event]) -> None:
        """Take events, all of them later than those before; threads emit them in nearly the order of their times."""
        folds = self._folds
        if self.header.mode != "lockstep":
            events = sorted(events, key=lambda event: event.t)
        for event in events:
            if event.t > self.end:
                self.end = event.t
            for fold in folds.get(type(event), ()):
                fold(self, event)

    def samples(self, agent: str, topic: str, name: str, width: int) -> Curve:
        """A track of numbers to add to; it begins if there is none."""
        track = self.get(agent, topic, name)
        if isinstance(track, Curve):
            return track
        age = self._ages.get((agent, name), math.inf) if topic == "signal" else math.inf
        rays = self.scanners.get((agent, name), 0) if topic == "scan" else 0
        begun = Scans(rays, min(2400, 6000 // len(self.scanners))) if rays else Curve(width, age)
        return self.add(TrackKey(agent, topic, name), begun)

    def run(self, event: TicketChanged) -> None:
        """Note the state of a ticket."""
        if event.state == "RUNNING":
            self._running[event.agent, event.ticket] = event
        else:
            self._running.pop((event.agent, event.ticket), None)

    def running(self, agent: str) -> TicketChanged | None:
        """Ticket of the action that runs now, of a reflex first; None if no action runs."""
        found = [event for (name, _), event in self._running.items() if name == agent]
        return min(found, key=lambda event: event.priority, default=None)  # "HIGH" < "NORMAL"

    def guard(self, agent: str, rule: str, t: float) -> GuardInfo | None:
        """Guard of a rule at a time: that of the header, until its file is replaced."""
        infos = (guard for info in self.header.agents if info.name == agent for guard in info.guards)
        new: GuardInfo | None = self.steps(agent, "guards", rule).at(t)
        return new or next((guard for guard in infos if guard.rule == rule), None)


def _put(topic: str, name: str = "", value: str = "", of: str = "agent") -> Callable[[Tracks, Any], None]:
    """Fold that sets a track, named by a field of the event, to another field; without these to the event itself."""

    def fold(tracks: Tracks, event: Any) -> None:
        track = tracks.begun(getattr(event, of), topic, getattr(event, name) if name else "")
        track.put(event.t, getattr(event, value) if value else event)

    return fold


def _pose(tracks: Tracks, event: BodyMoved) -> None:
    pose = [event.x, event.y, event.yaw]
    if event.height is not None:
        pose += [event.height, event.roll or 0.0, event.pitch or 0.0]
    tracks.samples(event.body, "pose", "", len(pose)).add(event.t, pack(pose))
    if event.wheels:
        tracks.samples(event.body, "wheels", "", len(event.wheels) // 8).add(event.t, event.wheels)


def _actor(tracks: Tracks, event: BodyMoved) -> None:
    """A body without an agent is an actor; what it begins and ends has a sentence in the log."""
    actor = None if event.agent else tracks.actors.get(event.body)
    if actor is not None and (change := actor.take(event)) is not None:
        tracks.begun(event.body, "actor").put(change.since, change.state)
        tracks.events.append(change)


def _joints(tracks: Tracks, event: BodyMoved) -> None:
    if event.joints:
        tracks.samples(event.body, "joints", "", len(event.joints)).add(event.t, pack(event.joints))


def _signal(tracks: Tracks, event: SignalsWritten) -> None:
    wanted = tracks.signals
    for name, part in event.parts():
        if not wanted or name in wanted:
            tracks.samples(event.agent, "signal", name, len(part) // 8).add(event.t, part, event.stamp)


def _scan(tracks: Tracks, event: SensorRead) -> None:
    if (event.agent, event.sensor) in tracks.scanners:
        tracks.samples(event.agent, "scan", event.sensor, len(event.data) // 8).add(event.t, event.data)


def _answers(tracks: Tracks, event: SensorRead) -> None:
    """Only a sensor that has failed has a track; it is empty while the sensor gives values again."""
    if tracks.get(event.agent, "sensor", event.sensor) is not None:
        tracks.begun(event.agent, "sensor", event.sensor).put(event.t, "")


def _motion(tracks: Tracks, event: SignalsWritten) -> None:
    """After the signals themselves."""
    if not MOTION.isdisjoint(event.signals):
        curves = tracks.of(event.agent, "signal")
        values = {n: c.data[-c.width] for n in MOTION if isinstance(c := curves.get(n), Curve) and c.data}
        tracks.begun(event.agent, "motion").put(event.t, motion_words(values))
    if "tilt" in event.signals and not isinstance(tracks.get(event.agent, "motion", "true tilt"), Steps):
        tracks.begun(event.agent, "motion", "tilt").put(event.t, tilt_words(event.values["tilt"][0]))


def _tilt(tracks: Tracks, event: BodyMoved) -> None:
    if not math.isnan(event.tilt):
        tracks.begun(event.body, "motion", "true tilt").put(event.t, tilt_words(event.tilt))


def _command(tracks: Tracks, event: ActuatorCommanded) -> None:
    tracks.samples(event.agent, "command", event.actuator, len(event.data) // 8).add(event.t, event.data)
    tracks.begun(event.agent, "route", event.actuator).put(event.t, event.route)
    if tracks.movers.setdefault(event.agent, event.actuator) == event.actuator:
        tracks.begun(event.agent, "route").put(event.t, event.route)


def _drive(tracks: Tracks, event: ActuatorCommanded) -> None:
    """One sample for each time, even if nothing changes: the age of a command is that of its last sample."""
    track, running = tracks.begun(event.agent, "drive"), tracks.running(event.agent)
    ticket, action = (0, "") if running is None else (running.ticket, running.action)
    neutral = not any(event.values) and not (track.t and track.t[-1] == event.t and not track.v[-1].neutral)
    track.add(event.t, Drive(event.route, ticket, action, neutral))


def _stop(tracks: Tracks, event: AgentStopped) -> None:
    tracks.movers[event.agent] = ""  # from then on nothing moves it, whatever is commanded
    tracks.begun(event.agent, "route").put(event.t, "idle")
    tracks.begun(event.agent, "stopped").first(event.t, event.by)


def _failed(tracks: Tracks, event: BlockFailed) -> None:
    tracks.begun(event.agent, "failed").first(event.t, f"{event.what} failed\n{event.detail}")


def _script(tracks: Tracks, event: ScriptActed) -> None:
    tracks.begun(event.agent, "script", f"{event.topic}\n{event.name}").put(event.t, event)


def _replaced(tracks: Tracks, event: RulesReplaced) -> None:
    for guard in event.guards:
        if not guard.faults:
            tracks.begun(event.agent, "guards", guard.rule).put(event.t, guard)
            tracks.clues.replace(event.agent, guard)


def _release(tracks: Tracks, event: MotionReleased) -> None:
    tracks.begun(event.agent, "hold", event.actuator).put(event.t, "")


def _follower(tracks: Tracks, event: FollowerStepped) -> None:
    sample = pack((event.cross_track, event.heading_error))
    tracks.samples(event.agent, "follower", "error", 2).add(event.t, sample)
    tracks.begun(event.agent, "follower", "rung").put(event.t, event.rung)
    if event.solve_time > 0.0:  # it was measured
        tracks.samples(event.agent, "solve", "", 1).add(event.t, pack((event.solve_time,)))


def _path_ended(tracks: Tracks, event: TicketChanged) -> None:
    """An action that begins has no path yet, and one that has ended none any more."""
    tracks.run(event)
    begins_or_ends = event.state == "RUNNING" or tracks.running(event.agent) is None
    if begins_or_ends and tracks.get(event.agent, "path") is not None:
        tracks.begun(event.agent, "path").put(event.t, None)


def _clearance(tracks: Tracks, event: MinClearanceLowered) -> None:
    tracks.begun(event.agent, "truth", "min_clearance").put(event.t, event.distance)


def _contact(tracks: Tracks, event: ContactBegan) -> None:
    track = tracks.begun(event.agent, "truth", event.kind)
    track.put(event.t, (track.v[-1] if track.v else 0) + 1)


def _node(tracks: Tracks, event: NodeTicked) -> None:
    tracks.begun(event.agent, "node", event.node).put(event.t, event.status)
    tracks.begun(event.agent, "note", event.node).put(event.t, event.feedback)


def _tree(tracks: Tracks, event: SubtreeSwapped) -> None:
    tracks.begun(event.agent, "tree").put(event.t, event.nodes)
    for name in tracks.of(event.agent, "node").keys() - {node.path for node in event.nodes}:
        tracks.begun(event.agent, "node", name).put(event.t, None)


def _board(tracks: Tracks, event: BlackboardChanged) -> None:
    tracks.begun(event.agent, "board", f"{event.subtree}\n{event.key}").put(event.t, event.value or None)


def _rule(tracks: Tracks, event: RuleChanged) -> None:
    track, others = tracks.begun(event.agent, "rule", event.rule), dict[str, RuleState]()
    if event.phase == "waits":  # only then the state depends on the other rules
        others = {name: rule.v[-1] for name, rule in tracks.steps_of(event.agent, "rule").items() if rule is not track}
    track.put(event.t, (track.v[-1] if track.v else RuleState()).after(event, others))


def _clue(tracks: Tracks, event: RuleChanged) -> None:
    """A rule that latches and fires at once has one clue; one that fires again and again has one a second."""
    agent, rule, t = event.agent, event.rule, event.t
    track = tracks.begun(agent, "clue", rule)
    if event.phase in ("latched", "fired", "stopped") and (not track.t or track.t[-1] < t):
        track.put(t, tracks.clues.of(agent, rule, t))
    elif event.phase == "fired again":
        track.put(t, tracks.clues.of(agent, rule, t) if tracks.clues.due(agent, rule, t) else "")


def _failure(tracks: Tracks, event: TicketChanged | OutcomeDecided) -> None:
    """What is near when an action fails, or a robot is stuck; once a second for what fails again and again."""
    if isinstance(event, TicketChanged):
        name, wanted = str(event.ticket), event.state == "FAILED" and tracks.clues.due(event.agent, event.by, event.t)
    else:
        name, wanted = "outcome", event.outcome == "stuck"
    if wanted and (found := tracks.clues.nearest(event.agent, event.t)):
        tracks.begun(event.agent, "clue", name).put(event.t, found)


def _failing(tracks: Tracks, event: TicketChanged) -> None:
    if event.state == "FAILED" and event.priority == "HIGH":
        track = tracks.begun(event.agent, "failures", event.by)
        track.put(event.t, Failures.after(track.v[-1] if track.v else None, event))


def _fires(tracks: Tracks, event: RuleChanged) -> None:
    """A new activation of a rule has no failures yet."""
    if event.phase == "fired" and tracks.get(event.agent, "failures", event.rule) is not None:
        tracks.begun(event.agent, "failures", event.rule).put(event.t, None)


def _ticket(tracks: Tracks, event: TicketChanged) -> None:
    track = tracks.begun(event.agent, "ticket", str(event.ticket))
    if track.v and not event.parameters:  # they are recorded with the first event only
        event = msgspec.structs.replace(event, parameters=track.v[-1].parameters)
    track.put(event.t, event)


def _alternation(tracks: Tracks, event: TicketChanged) -> None:
    found = tracks.turns[event.agent].take(event, tracks.curve(event.agent, "pose"))
    if found is not None or tracks.get(event.agent, "alternation") is not None:
        tracks.begun(event.agent, "alternation").put(event.t, found)


def _fact(tracks: Tracks, event: KnowledgeChanged) -> None:
    r"""Facts are named `node`, `node\nattribute` and `node\nrelation\ntarget`; names contain no line breaks."""
    node = (event.agent, event.subject)
    if event.what == "node removed":
        for name in sorted(tracks.facts.pop(node, ())):
            tracks.begun(event.agent, "fact", name).put(event.t, None)
        return
    value: object
    if event.what == "node added":
        name, value = event.subject, event.name
    elif event.what == "attribute":
        name, value = f"{event.subject}\n{event.name}", event.value
    else:
        name = f"{event.subject}\n{event.name}\n{event.value}"
        value = None if event.what == "edge removed" else dict(event.attributes)
    tracks.facts.setdefault(node, set()).add(name)
    tracks.begun(event.agent, "fact", name).put(event.t, value)


def _event(tracks: Tracks, event: Event) -> None:
    tracks.events.append(event)


def _control(tracks: Tracks, event: RunControlled) -> None:
    if event.command in ("pause", "step", "continue") and not event.refusal:
        tracks.begun(event.agent, "control").put(event.t, event.command)


STREAMS: tuple[type[Event], ...] = (SensorRead, SignalsWritten, BodyMoved, ActuatorCommanded, FollowerStepped)
"""Types of events that are emitted in every period."""


TOPICS: Mapping[str, Mapping[type[Event], Callable[[Tracks, Any], None]]] = {
    "pose": {BodyMoved: _pose},
    "actor": {BodyMoved: _actor},
    "joints": {BodyMoved: _joints},
    "signal": {SignalsWritten: _signal},
    "scan": {SensorRead: _scan},
    "sensor": {SensorFailed: _put("sensor", "sensor", "detail"), SensorRead: _answers},
    "motion": {SignalsWritten: _motion, BodyMoved: _tilt},
    "command": {ActuatorCommanded: _command},
    "stopped": {AgentStopped: _stop},
    "drive": {ActuatorCommanded: _drive, TicketChanged: Tracks.run},
    "failed": {BlockFailed: _failed},
    "atomic": {AtomicStarted: _put("atomic")},
    "push": {RobotPushed: _put("push", of="body")},
    "script": {ScriptActed: _script},
    "guards": {RulesReplaced: _replaced},
    "hold": {MotionHeld: _put("hold", "actuator", "reason"), MotionReleased: _release},
    "follower": {FollowerStepped: _follower},
    "map": {MapChanged: _put("map")},  # each value is a change; the map is the sum of all so far
    "path": {PathPlanned: _put("path", value="points"), TicketChanged: _path_ended},
    "truth": {MinClearanceLowered: _clearance, ContactBegan: _contact},
    "node": {NodeTicked: _node, SubtreeSwapped: _tree},
    "board": {BlackboardChanged: _board},
    "rule": {RuleChanged: _rule},
    "clue": {RuleChanged: _clue, TicketChanged: _failure, OutcomeDecided: _failure},
    "failures": {RuleChanged: _fires, TicketChanged: _failing},
    "ticket": {TicketChanged: _ticket},
    "alternation": {TicketChanged: _alternation},
    "fact": {KnowledgeChanged: _fact},
    "outcome": {OutcomeDecided: _put("outcome")},
    "control": {RunControlled: _control},
    "event": {kind: _event for kind in KINDS if kind not in STREAMS},
}
"""Functions that fold events into tracks, by topic and type of event."""
