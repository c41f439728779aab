"""State of an agent at one time of a recording: knowledge, plan, active rules, tickets and commands."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..errors import Fault, InputError, unknown
from ..event import (
    ActuatorCommanded,
    AtomicStarted,
    BodyMoved,
    Change,
    CommandLimited,
    ContentRaised,
    Event,
    FollowerStepped,
    KnowledgeChanged,
    NodeTicked,
    RuleChanged,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    TicketChanged,
)
from ..knowledge.history import State
from ..knowledge.history.values import plain
from ..raised import reported
from ..words import inactive_rule
from .diverge import describe
from .header import nodes_after
from .recording import Recording

_RECENT = 0.5  # [s] interval before the requested time of which events are listed
_RAISED = 5  # maximum number of listed exceptions of content
_LONG = 24  # maximum number of printed values of a signal; of longer signals only the minimum is printed
_SLOW = 0.02  # speed above which the robot counts as moving [m/s]
_WORDS = {  # motion of each axis in words, by its signal: for positive and negative values
    "speed": ("moved ahead", "moved back"),
    "lateral_speed": ("moved left", "moved right"),
    "climb": ("climbed", "descended"),
}
_TURNING = 0.1  # turn rate above which the robot counts as turning [rad/s]
_STREAMS = (SensorRead, SignalsWritten, BodyMoved, ActuatorCommanded, FollowerStepped)  # every period, not listed


@dataclass
class Why:
    """State of one agent at a requested time: the latest recorded value of everything.

    Attributes:
        t: Requested time [s].
        agent: Name of the agent.
        signals: Time of writing [s] and values by signal, SI units.
        graph: Knowledge graph.
        tree: Last status of each node of the mission tree.
        ports: Given ports of its nodes as text, by path.
        rules: Last event of each active rule.
        inactive: Sentences about the rules that were inactive at the start of the run.
        fired: Firings of rules so far, newest last.
        tickets: Open tickets by number.
        atomic: Atomic action that started last.
        commands: Last command by actuator.
        limited: Last command that the safety gate scaled, by actuator.
        followed: Last command computed by the trajectory follower.
        bodies: Last ground-truth pose by body.
        changes: Last change of each kind.
        raised: Exceptions of content so far.
        recent: Events of the last half second, except those emitted every period.
    """

    t: float
    agent: str
    signals: dict[str, tuple[float, list[float]]] = field(default_factory=dict)
    graph: State = field(default_factory=lambda: State(""))
    tree: dict[str, NodeTicked] = field(default_factory=dict)
    ports: dict[str, str] = field(default_factory=dict)
    rules: dict[str, RuleChanged] = field(default_factory=dict)
    inactive: list[str] = field(default_factory=list)
    fired: list[RuleChanged] = field(default_factory=list)
    tickets: dict[int, TicketChanged] = field(default_factory=dict)
    atomic: AtomicStarted | None = None
    commands: dict[str, ActuatorCommanded] = field(default_factory=dict)
    limited: dict[str, CommandLimited] = field(default_factory=dict)
    followed: FollowerStepped | None = None
    bodies: dict[str, BodyMoved] = field(default_factory=dict)
    changes: dict[str, Change] = field(default_factory=dict)
    raised: list[ContentRaised] = field(default_factory=list)
    recent: list[Event] = field(default_factory=list)

    @property
    def answer(self) -> str:
        """Sentence with the motion of the robot, and the rule or leaf of the mission that caused this motion."""
        return f"{self.agent} {_motion(self)} because {_cause(self)}."

    def __str__(self) -> str:
        return "\n".join(_render(self))


def explain(recording: Recording, t: float, agent: str | None = None) -> Why:
    """Reconstruct the state of an agent at a time.

    Args:
        recording: Recording of the run.
        t: Time [s]; later events are ignored.
        agent: Name of the agent; the first agent by default.

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
    why, last = Why(t, name, graph=State(name), ports=ports, inactive=inactive), recording.header.start
    # Times given by users are rounded: tolerate half a millisecond.
    for event in recording.events():
        last = max(last, event.t)
        if event.t <= t + 5e-4 and (event.agent == name or isinstance(event, BodyMoved)):
            _take(why, event)
    if not recording.header.start <= t <= last + 5e-4:
        covered = f"from {recording.header.start:g} s to {last:g} s"
        raise InputError(Fault(f"the time {t:g} s is outside the run.", hint=f"The run is {covered}."))
    return why


def _take(why: Why, event: Event) -> None:
    if isinstance(event, SignalsWritten):
        why.signals.update({n: (event.t, v) for n, v in event.values.items()})
    elif isinstance(event, KnowledgeChanged):
        why.graph.apply(event)
    elif isinstance(event, NodeTicked):
        why.tree[event.node] = event
    elif isinstance(event, SubtreeSwapped):
        why.ports.update({node.path: node.ports for node in nodes_after(event)})
    elif isinstance(event, RuleChanged):
        before = why.rules.pop(event.rule, None)
        # A rule that fired stays active until its action has ended, even if released (docs/architecture.md).
        waited = before is None or before.phase in ("latched", "waits")
        if event.phase != "ended" and not (event.phase == "released" and waited):
            why.rules[event.rule] = event
        if event.phase.startswith("fired"):
            why.fired.append(event)
    elif isinstance(event, TicketChanged):
        why.tickets.pop(event.ticket, None)
        if event.state in ("QUEUED", "RUNNING"):
            why.tickets[event.ticket] = event
    elif isinstance(event, AtomicStarted):
        why.atomic = event
    elif isinstance(event, ActuatorCommanded):
        why.commands[event.actuator] = event
    elif isinstance(event, CommandLimited):
        why.limited[event.actuator] = event
    elif isinstance(event, FollowerStepped):
        why.followed = event
    elif isinstance(event, BodyMoved):
        why.bodies[event.body] = event
    elif isinstance(event, Change):
        why.changes[event.kind] = event
    elif isinstance(event, ContentRaised):
        why.raised.append(event)
    if event.t >= why.t - _RECENT and not isinstance(event, _STREAMS):
        why.recent.append(event)


def _height(body: BodyMoved) -> str:
    return "" if body.height is None else f", height {body.height:.3f} m"


def _motion(why: Why) -> str:
    """Motion of the robot in words: along its fastest axis, and its turn."""
    values = {name: why.signals[name][1][0] for name in (*_WORDS, "turn_rate") if name in why.signals}
    turn, along = values.pop("turn_rate", math.nan), {n: v for n, v in values.items() if math.isfinite(v)}
    side = " left" if turn > 0.0 else " right"
    fastest = max(along, key=lambda name: abs(along[name]), default="")
    if fastest and abs(along[fastest]) > _SLOW:
        return _WORDS[fastest][along[fastest] < 0.0] + (f" turning{side}" if abs(turn) > _TURNING else "")
    if abs(turn) > _TURNING:
        return f"turned{side}"
    return "was stationary" if "speed" in along else "acted"


def _cause(why: Why) -> str:
    """Cause of the motion in words: the rule that fired, or the leaf that submitted the running action."""
    running = [e for e in why.tickets.values() if e.state == "RUNNING"]
    for ticket in running:
        if ticket.priority == "HIGH":
            fired = next((e for e in reversed(why.fired) if e.rule == ticket.by), None)
            guard = "" if fired is None else f"{_since(fired, why.t)}: {fired.reading}"
            rule = ticket.by.rpartition("/")[2]
            action = "" if ticket.action == rule else f" {ticket.action}"
            return f"the rule {rule} fired{action}{guard}"
    for ticket in running:
        return f"the leaf '{ticket.by}' of its mission runs {ticket.action}({_values(ticket.parameters)})"
    root = next(iter(why.tree.values()), None)
    ended = root is not None and root.status in ("SUCCESS", "FAILURE")
    return f"its mission had ended with {root.status}" if root is not None and ended else "no action was active"


def _render(why: Why) -> Iterable[str]:
    yield why.answer
    yield f"Evidence at t = {why.t:.3f} s:"
    active = [f"{e.rule} {e.phase}, priority {e.priority}{_since(e, why.t)}: {e.reading}" for e in why.rules.values()]
    yield from _part("fired", active or ["no active rule"])
    if why.fired:
        last = why.fired[-1]
        yield f"             last: {last.rule}{_since(last, why.t)}: {last.reading}"
    yield from _part("", why.inactive)
    yield from _part(
        "planned", [f"{e.status:8} {e.node}{why.ports.get(e.node, '')}{_since(e, why.t)}" for e in why.tree.values()]
    )
    yield from _part("raised", [f"{reported(e)}{_since(e, why.t)}" for e in why.raised[-_RAISED:]])
    tickets = [
        f"#{e.ticket} {e.state} {e.action}({_values(e.parameters)}) {e.priority} by {e.by}"
        for e in why.tickets.values()
    ]
    yield from _part("sent", tickets or ["no open ticket"])
    if why.atomic is not None:
        yield f"             started {why.atomic.action}({_values(why.atomic.parameters)}){_since(why.atomic, why.t)}"
    for command in why.commands.values():
        yield f"             {command.actuator} = {_numbers(command.values)} ({command.route}){_since(command, why.t)}"
        limited = why.limited.get(command.actuator)
        if limited is not None and limited.t == command.t:
            by = f"{limited.action} wanted" if limited.action else "wanted"
            yield f"             limited by the safety gate: {by} {_numbers(list(limited.wanted))}"
    if why.followed is not None:
        yield f"             {_follower(why.followed)}{_since(why.followed, why.t)}"
    yield from _part("just before", [describe(e) for e in why.recent[-10:]])
    yield from _part(
        "true pose",
        [f"{b.body} at ({b.x:.3f}, {b.y:.3f}) m{_height(b)}, yaw {b.yaw:.3f} rad" for b in why.bodies.values()],
    )
    yield from _part("known", [_signal(n, *s, why.t) for n, s in sorted(why.signals.items())])
    yield from _part("", [f"{e.kind} ({e.source}, t = {e.t:.3f} s): {_values(e.values)}" for e in why.changes.values()])
    yield from _part("", [_node(why.graph, name) for name in sorted(why.graph.nodes())])


def _part(title: str, lines: list[str]) -> Iterable[str]:
    for i, line in enumerate(lines):
        yield f"{title if i == 0 else '':<13}{line}"


def _since(event: Event, t: float) -> str:
    age = t - event.t
    return "" if age < 5e-4 else f", {age:.2f} s ago"


def _follower(tick: FollowerStepped) -> str:
    return f"follower: {tick.cross_track * 100:+.1f} cm off, heading {tick.heading_error:+.3f} rad, {tick.rung}"


def _signal(name: str, stamp: float, values: list[float], t: float) -> str:
    age = "" if t - stamp < 5e-4 else f", {t - stamp:.2f} s old"
    return f"{name} = {_numbers(values)}{age}"


def _node(graph: State, name: str) -> str:
    held = {"kind": graph.kind(name), **{a: plain(v) for a, v in graph.attributes(name).items()}}
    edges = {f"{r} -> {target}": True for r in graph.schema.relations for target in graph.related(name, r)}
    return f"{name}: {_values(held | edges)}"


def _values(values: object) -> str:
    if not isinstance(values, dict):
        return str(values)
    return ", ".join(k if v is True else f"{k}={_numbers(v)}" for k, v in values.items())


def _numbers(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3f}"
    if isinstance(value, list) and len(value) > _LONG and all(isinstance(v, float) for v in value):
        heard = [v for v in value if math.isfinite(v)]
        least = f", least {min(heard):.3f} at [{value.index(min(heard))}]" if heard else ""
        return f"{len(value)} values, {len(heard)} finite{least}"
    if isinstance(value, list):
        shown = ", ".join(_numbers(v) for v in value)
        return shown if len(value) == 1 else f"[{shown}]"
    return str(value)
