"""Evidence of an explanation: what was known, planned and sent, and which events came just before, as lines."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from ..base.words import inactive_rule
from ..event import (
    AtomicStarted,
    BlackboardChanged,
    Change,
    CommandLimited,
    ContentRaised,
    Event,
    KnowledgeChanged,
    MapChanged,
    MinClearanceLowered,
    PathPlanned,
    RobotPushed,
    SubtreeSwapped,
    SwapRefused,
)
from ..knowledge import Stamp
from ..knowledge.attribute import plain
from ..knowledge.history import GraphState
from .diverge import describe
from .moment import SLACK, Moment

_RECENT = 0.5  # [s] interval before the requested time of which events are listed
_RAISED = 5  # maximum number of listed exceptions of content
_BRIEF = 10  # maximum number of lines of evidence, unless all of it is requested
_NEAREST = 3  # maximum number of listed movers
_LONG = 24  # maximum number of printed values; of longer lists only the minimum is printed
_MINOR = (  # and many
    MinClearanceLowered,
    KnowledgeChanged,
    MapChanged,
    PathPlanned,
    AtomicStarted,
    BlackboardChanged,
    Change,
)
_NAMED = ("speed", "turn_rate", "stop_distance", "goal_distance", "front")


def evidence(why: Moment, *, everything: bool) -> list[str]:
    """Lines of evidence: all of it, or at most ten."""
    return list(_all(why)) if everything else _brief(why)


def _brief(why: Moment) -> list[str]:
    mission, running, before = why.mission, why.running, _before(why)
    active = _rules(why)[:2] or ([f"last: {_last_firing(why)}"] if why.fired else ["no rule so far"])
    leaves = [
        f"{mission.status(path)} {_labelled(why, path)}, for {why.t - mission.since(path):.2f} s"
        for path in mission.waiting()
    ]
    raised = [e for e in before if isinstance(e, ContentRaised) and why.t - e.t <= _RECENT]
    sent = "no running action" if running is None else f"RUNNING {running.action}({values_text(running.parameters)})"
    signals = why.tracks.of(why.agent, "signal")
    known = [line for name in _NAMED if name in signals for line in _signal(why, name)]
    lines = [
        *_part("fired", active),
        *_part("planned", leaves[:2]),
        *_part("failed", [f"{path}: {why.mission.note(path)}" for path in _failed(why)[:2]]),
        *_part("raised", [f"{e.sentence}{since(e.t, why.t)}" for e in raised[-1:]]),
        *_part("sent", [sent, *_commands(why)][:3]),
        *_part("just before", [_sentence(e) for e in before if _recent(why, e) and not isinstance(e, _MINOR)][-2:]),
        *_part(_pose_of(why), _poses(why, why.agent)),
        *_part("around", ["; ".join(movers)] if (movers := _movers(why)[:_NEAREST]) else []),
        *_part("known", ["; ".join(known)] if known else []),
        *_part("faults", ["; ".join(why.info.faults)] if why.info.faults else []),
    ]
    return lines[:_BRIEF]


def _failed(why: Moment) -> list[str]:
    """Leaves with a message that have failed just now."""
    mission = why.mission
    return [
        path
        for path, node in mission.nodes.items()
        if not node.children and mission.status(path) == "FAILURE" and mission.note(path)
        if why.t - mission.changed(path) < SLACK
    ]


def _all(why: Moment) -> Iterator[str]:
    mission, before = why.mission, _before(why)
    yield from _part("fired", _rules(why) or ["no active rule"])
    if why.fired:
        yield f"             last: {_last_firing(why)}"
    info = why.info
    yield from _part("", [inactive_rule(rule, [info.robot], missing) for rule, missing in info.inactive.items()])
    yield from _part("planned", [_node(why, path) for path in why.tracks.of(why.agent, "node") if mission.status(path)])
    raised = [e for e in before if isinstance(e, ContentRaised)]
    yield from _part("raised", [f"{e.sentence}{since(e.t, why.t)}" for e in raised[-_RAISED:]])
    tickets = [
        f"#{e.ticket} {e.state} {e.action}({values_text(e.parameters)}) {e.priority} by {e.by}"
        for e in why.tickets.values()
    ]
    yield from _part("sent", tickets or ["no open ticket"])
    if (atomic := why.value("atomic")) is not None:
        yield f"             started {atomic.action}({values_text(atomic.parameters)}){since(atomic.t, why.t)}"
    yield from _part("", [*_commands(why), *_follower(why)])
    yield from _part("just before", [describe(e, digits=3) for e in before if _recent(why, e)][-10:])
    yield from _part(_pose_of(why), _poses(why))
    signals = sorted(why.tracks.of(why.agent, "signal"))
    yield from _part("known", [line for name in signals for line in _signal(why, name)])
    changes = {e.kind: e for e in before if isinstance(e, Change)}
    yield from _part("", [f"{e.kind} ({e.source}, t = {e.t:.3f} s): {values_text(e.values)}" for e in changes.values()])
    yield from _part("faults", [*why.info.faults])
    graph = graph_at(why)
    yield from _part("", [_subject(graph, name) for name in sorted(graph.nodes())])


def _before(why: Moment) -> list[Event]:
    """Events of the agent so far, and pushes of all robots."""
    return [e for e in why.tracks.events if e.t <= why.now and (e.agent == why.agent or isinstance(e, RobotPushed))]


def _recent(why: Moment, event: Event) -> bool:
    return event.t >= why.t - _RECENT


def _rules(why: Moment) -> list[str]:
    return [
        f"{name} {rule.phase}, priority {rule.priority}{since(why.since('rule', name), why.t)}: {rule.last}"
        for name, rule in why.rules.items()
    ]


def _last_firing(why: Moment) -> str:
    t, _, reading = why.value("rule", why.fired).firing
    return f"{why.fired}{since(t, why.t)}: {reading}"


def _node(why: Moment, path: str) -> str:
    mission = why.mission
    about = f": {mission.note(path)}" if mission.note(path) else ""
    ports = mission.nodes[path].ports if path in mission.nodes else ""
    return f"{mission.status(path):8} {path}{ports}, since {mission.since(path):.2f} s{about}"


def _labelled(why: Moment, path: str) -> str:
    """Path of a node with its given ports, numbers with three digits."""
    ports = why.mission.nodes[path].ports if path in why.mission.nodes else ""
    return path + re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.3g}", ports)


def _sentence(event: Event) -> str:
    """An event in one line; a swap in words, because its fields describe the whole tree."""
    if isinstance(event, (SubtreeSwapped, SwapRefused)):
        return f"t={event.t:.3f} {event.agent} {event.sentence}"
    return describe(event, digits=3)


def _pose_of(why: Moment) -> str:
    """Name of what is recorded as poses: on hardware the robots' own estimates."""
    return "true pose" if why.tracks.header.simulated else "own pose"


def _poses(why: Moment, only: str = "") -> list[str]:
    """Last poses of all bodies, or of one."""
    lines = []
    for body in [only] if only else [key.agent for key, _ in why.tracks.items() if key.topic == "pose"]:
        if (found := why.tracks.curve(body, "pose").last(why.now)) is not None:
            x, y, yaw, *spatial = found[1]
            height = f", height {spatial[0]:.3f} m" if spatial else ""
            lines.append(f"{body} at ({x:.3f}, {y:.3f}) m{height}, yaw {yaw:.3f} rad")
    return lines


def _movers(why: Moment) -> list[str]:
    """What the agent believes to move around it, the nearest first."""
    if (at := why.tracks.curve(why.agent, "pose").last(why.now)) is None:
        return []
    x, y, *_ = at[1]
    graph, found = graph_at(why), list[tuple[float, str]]()
    for name in graph.nodes():
        held = {attribute: plain(value) for attribute, value in graph.attributes(name).items()}
        pose = held.get("pose")
        if held.get("moves") is True and isinstance(pose, list):
            away = math.hypot(pose[0] - x, pose[1] - y)
            found.append((away, f"{name} {away:.2f} m away at {numbers_text(held.get('speed', 0.0))} m/s"))
    return [text for _, text in sorted(found)]


def _commands(why: Moment) -> list[str]:
    """Last command of each actuator, and what the safety gate changed of it."""
    lines = []
    for name, track in why.tracks.curves_of(why.agent, "command").items():
        if (found := track.last(why.now)) is None:
            continue
        t, values = found
        lines.append(f"{name} = {numbers_text(values)} ({why.value('route', name)}){since(t, why.t)}")
        limited = [e for e in why.tracks.events if isinstance(e, CommandLimited) and e.t == t and e.actuator == name]
        for event in [e for e in limited if e.agent == why.agent][-1:]:
            by = f"{event.action} wanted" if event.action else "wanted"
            lines.append(f"limited by the safety gate: {by} {numbers_text(list(event.wanted))}")
    return lines


def _follower(why: Moment) -> Iterator[str]:
    if (found := why.tracks.curve(why.agent, "follower", "error").last(why.now)) is not None:
        t, (cross, heading) = found
        rung = why.value("follower", "rung")
        yield f"follower: {cross * 100:+.1f} cm off, heading {heading:+.3f} rad, {rung}{since(t, why.t)}"


def _signal(why: Moment, name: str) -> Iterator[str]:
    if (found := why.tracks.curve(why.agent, "signal", name).last(why.now)) is not None:
        t, values = found
        age = "" if why.t - t < SLACK else f", {why.t - t:.2f} s old"
        yield f"{name} = {numbers_text(values)}{age}"


def graph_at(why: Moment) -> GraphState:
    """Knowledge of the agent at the time."""
    graph, stamp = GraphState(why.agent), Stamp(why.t, 0)
    facts = [(name.split("\n"), value) for name, value in why.tracks.state(why.now, why.agent, "fact").items()]
    for (node, *parts), value in sorted(facts, key=lambda fact: len(fact[0])):
        if not parts:
            graph.add(node, value, stamp)
        elif len(parts) == 1:
            graph.write(node, parts[0], value, stamp)
        else:
            graph.relate(node, parts[0], parts[1], value, stamp)
    return graph


def _subject(graph: GraphState, name: str) -> str:
    held = {"kind": graph.kind(name), **{a: plain(v) for a, v in graph.attributes(name).items()}}
    edges = {f"{r} -> {target}": True for r in graph.schema.relations for target in graph.related(name, r)}
    return f"{name}: {values_text(held | edges)}"


def _part(title: str, lines: list[str]) -> Iterator[str]:
    for i, line in enumerate(lines):
        yield f"{title if i == 0 else '':<13}{line}"


def since(then: float, t: float) -> str:
    """Age of a time in words, such as `, 0.10 s ago`; empty for this moment."""
    return "" if t - then < SLACK else f", {t - then:.2f} s ago"


def values_text(values: object) -> str:
    """Text of values by name, with three digits."""
    if not isinstance(values, dict):
        return str(values)
    return ", ".join(k if v is True else f"{k}={numbers_text(v)}" for k, v in values.items())


def numbers_text(value: object) -> str:
    """Text of a value with three digits; of a long list, its minimum only."""
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, list) and len(value) > _LONG and all(isinstance(v, float) for v in value):
        heard = [v for v in value if math.isfinite(v)]
        least = f", minimum {min(heard):.3g} at [{value.index(min(heard))}]" if heard else ""
        return f"{len(value)} values, {len(heard)} finite{least}"
    if isinstance(value, list):
        shown = ", ".join(numbers_text(v) for v in value)
        return shown if len(value) == 1 else f"[{shown}]"
    return str(value)
