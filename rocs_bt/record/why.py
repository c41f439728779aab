"""State of an agent at one time of a recording: knowledge, plan, active rules, tickets and commands."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from ..errors import Fault, InputError, unknown
from ..event import (
    ActuatorCommanded,
    AgentStopped,
    AtomicStarted,
    BlackboardChanged,
    BlockFailed,
    BodyMoved,
    Change,
    CommandLimited,
    ContentRaised,
    Event,
    FollowerStepped,
    KnowledgeChanged,
    MinClearanceLowered,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    RobotPushed,
    RuleChanged,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    SwapRefused,
    TicketChanged,
)
from ..knowledge.history import State
from ..knowledge.history.values import plain
from ..words import inactive_rule
from .diverge import describe
from .header import nodes_after
from .recording import Recording
from .tree_state import TreeState
from .why_sentence import numbers_text as _numbers
from .why_sentence import sentence
from .why_sentence import since as _since
from .why_sentence import values_text as _values
from .why_state import Drive, WhyState

_RECENT = 0.5  # [s] interval before the requested time of which events are listed
_RAISED = 5  # maximum number of listed exceptions of content
_BRIEF = 10  # maximum number of lines of evidence, unless all of it is requested
_TIMES = 5e-4  # [s] tolerance of times given by users, which are rounded
_STREAMS = (SensorRead, SignalsWritten, BodyMoved, ActuatorCommanded, FollowerStepped)  # every period, not listed
_MINOR = (
    MinClearanceLowered,
    KnowledgeChanged,
    AtomicStarted,
    BlackboardChanged,
    Change,
)  # minor evidence, and many


class Why(WhyState):
    """State of one agent at a requested time, with its explanation in words."""

    @property
    def answer(self) -> str:
        """Sentence with the motion of the robot, and what caused it: a rule, a leaf of the mission, a wait, an end."""
        return sentence(self)

    def text(self, *, everything: bool = False) -> str:
        """The answer and its evidence, a few lines or all of it."""
        lines = list(_brief(self) if not everything else _render(self))
        hint = "" if everything else " (--all prints everything known)"
        return "\n".join([self.answer, f"Evidence at t = {self.t:.3f} s{hint}:", *lines])

    def __str__(self) -> str:
        return self.text()


def explain(recording: Recording, t: float, agent: str | None = None) -> Why:
    """Reconstruct the state of an agent at a time.

    Args:
        recording: Recording of the run.
        t: Time [s]; later events are ignored.
        agent: Name of the agent; the first agent by default.

    Raises:
        InputError: Unknown agent, or a time outside the run.
    """
    return next(explain_each(recording, [t], agent))


def explain_each(recording: Recording, times: Sequence[float], agent: str | None = None) -> Iterator[Why]:
    """Reconstruct the states of an agent at several times, in one pass over the recording.

    Args:
        recording: Recording of the run.
        times: Times [s], ascending.
        agent: Name of the agent; the first agent by default.

    Yields:
        State at each time. It is one object, which changes when the next one is requested.

    Raises:
        InputError: Unknown agent, or a time outside the run.
    """
    names = [a.name for a in recording.header.agents]
    name = agent if agent is not None else names[0] if names else ""
    if name not in names:
        raise InputError(unknown("agent", name, names, "The run"))
    info = next(a for a in recording.header.agents if a.name == name)
    ports = {node.path: node.ports for node in info.nodes}
    inactive = [inactive_rule(rule, [info.robot], missing) for rule, missing in info.inactive.items()]
    why = Why(0.0, name, graph=State(name), tree=TreeState(info.nodes), ports=ports, inactive=inactive)
    events = sorted(recording.events(), key=lambda event: event.t)  # threads emit them in nearly this order
    start, end = recording.header.start, max([recording.header.start, *(e.t for e in events[-1:])])
    at = 0
    for t in times:
        if not start <= t <= end + _TIMES:
            covered = f"from {start:g} s to {end:g} s"
            raise InputError(Fault(f"the time {t:g} s is outside the run.", hint=f"The run is {covered}."))
        while at < len(events) and events[at].t <= t + _TIMES:
            if events[at].agent == name or isinstance(events[at], (BodyMoved, RobotPushed)):
                _take(why, events[at])
            at += 1
        why.t = t
        yield why


def _take(why: Why, event: Event) -> None:
    if isinstance(event, SignalsWritten):
        why.signals.update({n: (event.t, v) for n, v in event.values.items()})
    elif isinstance(event, KnowledgeChanged):
        why.graph.apply(event)
    elif isinstance(event, NodeTicked):
        why.tree.take(event)
    elif isinstance(event, SubtreeSwapped):
        why.tree.swap(event)
        why.ports.update({node.path: node.ports for node in nodes_after(event)})
    elif isinstance(event, RuleChanged):
        _take_rule(why, event)
    elif isinstance(event, TicketChanged):
        why.tickets.pop(event.ticket, None)
        if event.state in ("QUEUED", "RUNNING"):
            why.tickets[event.ticket] = event
    elif isinstance(event, AtomicStarted):
        why.atomic = event
    elif isinstance(event, ActuatorCommanded):
        why.commands[event.actuator] = event
        why.drives.append(Drive(event.t, why.running, not any(event.values)))
    elif isinstance(event, CommandLimited):
        why.limited[event.actuator] = event
    elif isinstance(event, MotionHeld):
        why.held[event.actuator] = event
    elif isinstance(event, MotionReleased):
        why.held.pop(event.actuator, None)
    elif isinstance(event, RobotPushed):
        why.pushed = event if event.body == why.agent else why.pushed
    elif isinstance(event, FollowerStepped):
        why.followed = event
    elif isinstance(event, BodyMoved):
        why.bodies[event.body] = event
    elif isinstance(event, Change):
        why.changes[event.kind] = event
    elif isinstance(event, ContentRaised):
        why.raised.append(event)
    elif isinstance(event, BlockFailed):
        why.failed = why.failed or event
    elif isinstance(event, AgentStopped):
        why.stopped = why.stopped or event
    if not isinstance(event, _STREAMS):
        why.recent.append(event)


def _take_rule(why: Why, event: RuleChanged) -> None:
    before = why.rules.pop(event.rule, None)
    # A rule that fired stays active until its action has ended, even if released (docs/architecture.md).
    waited = before is None or before.phase in ("latched", "waits")
    if event.phase != "ended" and not (event.phase == "released" and waited):
        why.rules[event.rule] = event
    if event.phase == "latched":
        why.latched[event.rule] = event
    elif event.phase == "waits":
        active = (e.rule for e in reversed(why.fired) if e.rule in why.rules and e.rule != event.rule)
        why.waited[event.rule] = next(active, "another rule")
    elif event.phase.startswith("fired") or event.phase == "stopped":
        why.fired.append(event)
        if event.rule in why.latched:
            why.causes[event.rule] = why.latched[event.rule]


def _height(body: BodyMoved) -> str:
    return "" if body.height is None else f", height {body.height:.3f} m"


def _brief(why: Why) -> Iterable[str]:
    """At most ten lines: rules, waiting or running leaves, action, command, the last events, pose and motion."""
    active = [f"{e.rule} {e.phase}, priority {e.priority}{_since(e, why.t)}: {e.reading}" for e in why.rules.values()]
    if not active and why.fired:
        active = [f"last: {why.fired[-1].rule}{_since(why.fired[-1], why.t)}: {why.fired[-1].reading}"]
    lines = [*_part("fired", active[:2] or ["no rule so far"])]
    leaves = [f"{e.status} {_labelled(why, e.node)}, for {why.t - began:.2f} s" for e, began in why.tree.waiting()]
    lines += _part("planned", leaves[:2])
    lines += _part("raised", [f"{e.sentence}{_since(e, why.t)}" for e in why.raised[-1:] if why.t - e.t <= _RECENT])
    running = why.running
    sent = "no running action" if running is None else f"RUNNING {running.action}({_values(running.parameters)})"
    lines += _part("sent", [sent, *_commands(why)][:3])
    events = [e for e in why.recent if e.t >= why.t - _RECENT and not isinstance(e, _MINOR)]
    lines += _part("just before", [_sentence(e) for e in events[-2:]])
    own = [b for b in why.bodies.values() if b.body == why.agent]
    lines += _part("true pose", [_pose(b) for b in own])
    named = [n for n in ("speed", "turn_rate", "stop_distance", "goal_distance", "front") if n in why.signals]
    known = [_signal(n, *why.signals[n], why.t) for n in named]
    lines += _part("known", ["; ".join(known)] if known else [])
    return lines[:_BRIEF]


def _render(why: Why) -> Iterable[str]:
    active = [f"{e.rule} {e.phase}, priority {e.priority}{_since(e, why.t)}: {e.reading}" for e in why.rules.values()]
    yield from _part("fired", active or ["no active rule"])
    if why.fired:
        last = why.fired[-1]
        yield f"             last: {last.rule}{_since(last, why.t)}: {last.reading}"
    yield from _part("", why.inactive)
    yield from _part(
        "planned",
        [
            f"{e.status:8} {e.node}{why.ports.get(e.node, '')}, since {why.tree.since[e.node]:.2f} s"
            + (f": {e.feedback}" if e.feedback else "")
            for e in why.tree.events.values()
        ],
    )
    yield from _part("raised", [f"{e.sentence}{_since(e, why.t)}" for e in why.raised[-_RAISED:]])
    tickets = [
        f"#{e.ticket} {e.state} {e.action}({_values(e.parameters)}) {e.priority} by {e.by}"
        for e in why.tickets.values()
    ]
    yield from _part("sent", tickets or ["no open ticket"])
    if why.atomic is not None:
        yield f"             started {why.atomic.action}({_values(why.atomic.parameters)}){_since(why.atomic, why.t)}"
    yield from _part("", _commands(why))
    if why.followed is not None:
        yield f"             {_follower(why.followed)}{_since(why.followed, why.t)}"
    yield from _part("just before", [describe(e, digits=3) for e in why.recent if e.t >= why.t - _RECENT][-10:])
    yield from _part(
        "true pose",
        [_pose(b) for b in why.bodies.values()],
    )
    yield from _part("known", [_signal(n, *s, why.t) for n, s in sorted(why.signals.items())])
    yield from _part("", [f"{e.kind} ({e.source}, t = {e.t:.3f} s): {_values(e.values)}" for e in why.changes.values()])
    yield from _part("", [_node(why.graph, name) for name in sorted(why.graph.nodes())])


def _sentence(event: Event) -> str:
    """An event in one line; a swap in words, because its fields describe the whole tree."""
    if isinstance(event, (SubtreeSwapped, SwapRefused)):
        return f"t={event.t:.3f} {event.agent} {event.sentence}"
    return describe(event, digits=3)


def _labelled(why: Why, path: str) -> str:
    """Path of a node with its given ports, numbers with three digits."""
    return path + re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.3g}", why.ports.get(path, ""))


def _pose(b: BodyMoved) -> str:
    return f"{b.body} at ({b.x:.3f}, {b.y:.3f}) m{_height(b)}, yaw {b.yaw:.3f} rad"


def _commands(why: Why) -> list[str]:
    """Last command of each actuator, and what the safety gate changed of it."""
    lines = []
    for command in why.commands.values():
        lines.append(f"{command.actuator} = {_numbers(command.values)} ({command.route}){_since(command, why.t)}")
        limited = why.limited.get(command.actuator)
        if limited is not None and limited.t == command.t:
            by = f"{limited.action} wanted" if limited.action else "wanted"
            lines.append(f"limited by the safety gate: {by} {_numbers(list(limited.wanted))}")
    return lines


def _part(title: str, lines: list[str]) -> Iterable[str]:
    for i, line in enumerate(lines):
        yield f"{title if i == 0 else '':<13}{line}"


def _follower(tick: FollowerStepped) -> str:
    return f"follower: {tick.cross_track * 100:+.1f} cm off, heading {tick.heading_error:+.3f} rad, {tick.rung}"


def _signal(name: str, stamp: float, values: list[float], t: float) -> str:
    age = "" if t - stamp < 5e-4 else f", {t - stamp:.2f} s old"
    return f"{name} = {_numbers(values)}{age}"


def _node(graph: State, name: str) -> str:
    held = {"kind": graph.kind(name), **{a: plain(v) for a, v in graph.attributes(name).items()}}
    edges = {f"{r} -> {target}": True for r in graph.schema.relations for target in graph.related(name, r)}
    return f"{name}: {_values(held | edges)}"
