"""Evidence of an explanation: what was known, planned and sent, and which events came just before, as lines."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from ...base.words import inactive_rule
from ...event import (
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
from ...knowledge import Stamp
from ...knowledge.attribute import plain
from ...knowledge.history import GraphState
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


def evidence(moment: Moment, *, everything: bool) -> list[str]:
    """Lines of evidence: all of it, or at most ten."""
    return list(_all(moment)) if everything else _brief(moment)


def _brief(moment: Moment) -> list[str]:
    mission, running, before = moment.mission, moment.running, _before(moment)
    active = _rules(moment)[:2] or ([f"last: {_last_firing(moment)}"] if moment.fired else ["no rule so far"])
    leaves = [
        f"{mission.status(path)} {_labelled(moment, path)}, for {moment.t - mission.since(path):.2f} s"
        for path in mission.waiting()
    ]
    raised = [e for e in before if isinstance(e, ContentRaised) and moment.t - e.t <= _RECENT]
    sent = "no running action" if running is None else f"RUNNING {running.action}({values_text(running.parameters)})"
    signals = moment.tracks.of(moment.agent, "signal")
    known = [line for name in _NAMED if name in signals for line in _signal(moment, name)]
    lines = [
        *_part("fired", active),
        *_part("planned", leaves[:2]),
        *_part("failed", [f"{path}: {moment.mission.note(path)}" for path in _failed(moment)[:2]]),
        *_part("raised", [f"{e.sentence}{since(e.t, moment.t)}" for e in raised[-1:]]),
        *_part("sent", [sent, *_commands(moment)][:3]),
        *_part("just before", [_sentence(e) for e in before if _recent(moment, e) and not isinstance(e, _MINOR)][-2:]),
        *_part(_pose_of(moment), _poses(moment, moment.agent)),
        *_part("around", ["; ".join(movers)] if (movers := _movers(moment)[:_NEAREST]) else []),
        *_part("known", ["; ".join(known)] if known else []),
        *_part("faults", ["; ".join(moment.info.faults)] if moment.info.faults else []),
    ]
    return lines[:_BRIEF]


def _failed(moment: Moment) -> list[str]:
    """Leaves with a message that have failed just now."""
    mission = moment.mission
    return [
        path
        for path, node in mission.nodes.items()
        if not node.children and mission.status(path) == "FAILURE" and mission.note(path)
        if moment.t - mission.changed(path) < SLACK
    ]


def _all(moment: Moment) -> Iterator[str]:
    mission, before = moment.mission, _before(moment)
    yield from _part("fired", _rules(moment) or ["no active rule"])
    if moment.fired:
        yield f"             last: {_last_firing(moment)}"
    info = moment.info
    yield from _part("", [inactive_rule(rule, [info.robot], missing) for rule, missing in info.inactive.items()])
    yield from _part(
        "planned", [_node(moment, path) for path in moment.tracks.of(moment.agent, "node") if mission.status(path)]
    )
    raised = [e for e in before if isinstance(e, ContentRaised)]
    yield from _part("raised", [f"{e.sentence}{since(e.t, moment.t)}" for e in raised[-_RAISED:]])
    tickets = [
        f"#{e.ticket} {e.state} {e.action}({values_text(e.parameters)}) {e.priority} by {e.by}"
        for e in moment.tickets.values()
    ]
    yield from _part("sent", tickets or ["no open ticket"])
    if (atomic := moment.value("atomic")) is not None:
        yield f"             started {atomic.action}({values_text(atomic.parameters)}){since(atomic.t, moment.t)}"
    yield from _part("", [*_commands(moment), *_follower(moment)])
    yield from _part("just before", [describe(e, digits=3) for e in before if _recent(moment, e)][-10:])
    yield from _part(_pose_of(moment), _poses(moment))
    signals = sorted(moment.tracks.of(moment.agent, "signal"))
    yield from _part("known", [line for name in signals for line in _signal(moment, name)])
    changes = {e.kind: e for e in before if isinstance(e, Change)}
    yield from _part("", [f"{e.kind} ({e.source}, t = {e.t:.3f} s): {values_text(e.values)}" for e in changes.values()])
    yield from _part("faults", [*moment.info.faults])
    graph = graph_at(moment)
    yield from _part("", [_subject(graph, name) for name in sorted(graph.nodes())])


def _before(moment: Moment) -> list[Event]:
    """Events of the agent so far, and pushes of all robots."""
    return [
        e for e in moment.tracks.events if e.t <= moment.now and (e.agent == moment.agent or isinstance(e, RobotPushed))
    ]


def _recent(moment: Moment, event: Event) -> bool:
    return event.t >= moment.t - _RECENT


def _rules(moment: Moment) -> list[str]:
    return [
        f"{name} {rule.phase}, priority {rule.priority}{since(moment.since('rule', name), moment.t)}: {rule.last}"
        for name, rule in moment.rules.items()
    ]


def _last_firing(moment: Moment) -> str:
    t, _, reading = moment.value("rule", moment.fired).firing
    return f"{moment.fired}{since(t, moment.t)}: {reading}"


def _node(moment: Moment, path: str) -> str:
    mission = moment.mission
    about = f": {mission.note(path)}" if mission.note(path) else ""
    ports = mission.nodes[path].ports if path in mission.nodes else ""
    return f"{mission.status(path):8} {path}{ports}, since {mission.since(path):.2f} s{about}"


def _labelled(moment: Moment, path: str) -> str:
    """Path of a node with its given ports, numbers with three digits."""
    ports = moment.mission.nodes[path].ports if path in moment.mission.nodes else ""
    return path + re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.3g}", ports)


def _sentence(event: Event) -> str:
    """An event in one line; a swap in words, because its fields describe the whole tree."""
    if isinstance(event, (SubtreeSwapped, SwapRefused)):
        return f"t={event.t:.3f} {event.agent} {event.sentence}"
    return describe(event, digits=3)


def _pose_of(moment: Moment) -> str:
    """Name of what is recorded as poses: on hardware the robots' own estimates."""
    return "true pose" if moment.tracks.header.simulated else "own pose"


def _poses(moment: Moment, only: str = "") -> list[str]:
    """Last poses of all bodies, or of one."""
    lines = []
    for body in [only] if only else [key.agent for key, _ in moment.tracks.items() if key.topic == "pose"]:
        if (found := moment.tracks.curve(body, "pose").last(moment.now)) is not None:
            x, y, yaw, *spatial = found[1]
            height = f", height {spatial[0]:.3f} m" if spatial else ""
            lines.append(f"{body} at ({x:.3f}, {y:.3f}) m{height}, yaw {yaw:.3f} rad")
    return lines


def _movers(moment: Moment) -> list[str]:
    """What the agent believes to move around it, the nearest first."""
    if (at := moment.tracks.curve(moment.agent, "pose").last(moment.now)) is None:
        return []
    x, y, *_ = at[1]
    graph, found = graph_at(moment), list[tuple[float, str]]()
    for name in graph.nodes():
        held = {attribute: plain(value) for attribute, value in graph.attributes(name).items()}
        pose = held.get("pose")
        if held.get("moves") is True and isinstance(pose, list):
            away = math.hypot(pose[0] - x, pose[1] - y)
            found.append((away, f"{name} {away:.2f} m away at {numbers_text(held.get('speed', 0.0))} m/s"))
    return [text for _, text in sorted(found)]


def _commands(moment: Moment) -> list[str]:
    """Last command of each actuator, and what the safety gate changed of it."""
    lines = []
    for name, track in moment.tracks.curves_of(moment.agent, "command").items():
        if (found := track.last(moment.now)) is None:
            continue
        t, values = found
        lines.append(f"{name} = {numbers_text(values)} ({moment.value('route', name)}){since(t, moment.t)}")
        limited = [e for e in moment.tracks.events if isinstance(e, CommandLimited) and e.t == t and e.actuator == name]
        for event in [e for e in limited if e.agent == moment.agent][-1:]:
            by = f"{event.action} wanted" if event.action else "wanted"
            lines.append(f"limited by the safety gate: {by} {numbers_text(list(event.wanted))}")
    return lines


def _follower(moment: Moment) -> Iterator[str]:
    if (found := moment.tracks.curve(moment.agent, "follower", "error").last(moment.now)) is not None:
        t, (cross, heading) = found
        rung = moment.value("follower", "rung")
        yield f"follower: {cross * 100:+.1f} cm off, heading {heading:+.3f} rad, {rung}{since(t, moment.t)}"


def _signal(moment: Moment, name: str) -> Iterator[str]:
    if (found := moment.tracks.curve(moment.agent, "signal", name).last(moment.now)) is not None:
        t, values = found
        age = "" if moment.t - t < SLACK else f", {moment.t - t:.2f} s old"
        yield f"{name} = {numbers_text(values)}{age}"


def graph_at(moment: Moment) -> GraphState:
    """Knowledge of the agent at the time."""
    graph, stamp = GraphState(moment.agent), Stamp(moment.t, 0)
    facts = [(name.split("\n"), value) for name, value in moment.tracks.state(moment.now, moment.agent, "fact").items()]
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
