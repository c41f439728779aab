"""report.html: self-contained report of a run, made from its recording."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from ..errors import RecordingError
from ..event import (
    BlockFailed,
    CommandExpired,
    ContentRaised,
    MotionHeld,
    MotionReleased,
    OtherPublisherFound,
    OutcomeDecided,
    PeerFault,
    RobotPushed,
    SensorFailed,
    Stuck,
    TicketChanged,
)
from ..files import write_whole
from ..raised import reported
from ..words import inactive_rule
from .animation import animation
from .figures.plot import FIGURES
from .header import AgentInfo
from .history import AgentHistory, FaultEvent, History
from .knowledge.learnt import learnt
from .page import inline_svg, render_page
from .recording import Recording
from .summary import AgentResult, Following, Localisation, Summary

Number = tuple[str, float | str | None, str]
"""Label, value and format of a number of the report; the value is None if it was not measured."""

_REJECTED = ("oversized", "unauthenticated", "malformed", "flooded", "refused")

_VERDICTS = {
    "success": "{name} reached its goal",
    "collision": "{name} collided",
    "failed": "The mission of {name} failed",
    "stuck": "{name} got stuck",
    "fell": "{name} fell",
    "interrupted": "The run of {name} was interrupted",
    "timeout": "{name} ran out of time",
    "error": "{name} was stopped by an error",
}


def write_report(recording: Recording, summary: Summary | None, path: Path) -> None:
    """Write the report of a run; the file is replaced only when it is complete.

    Args:
        recording: Recording of the run.
        summary: Summary of the run; None if there is none.
        path: HTML file to write.

    Raises:
        RecordingError: The file cannot be written, or the recording cannot be read.
    """
    text = render_report(recording, summary)
    try:
        write_whole(path, text)
    except OSError as error:
        raise RecordingError(f"the report '{path}' cannot be written: {error.strerror}.") from error


def render_report(recording: Recording, summary: Summary | None) -> str:
    """Render the report as HTML."""
    run = History(recording)
    results = {} if summary is None else summary.agents
    # JSON has `<` only in strings, where this escape is equivalent; so no string can end the script element.
    data = msgspec.json.encode(animation(run)).decode().replace("<", "\\u003c")
    return render_page(
        "report.html",
        header=run.header,
        complete=recording.complete,
        summary=summary,
        end=run.end,
        agents=[_agent(run, info, results.get(info.name)) for info in run.header.agents],
        pushes=[(push.t, f"{push.body} {push.text}") for push in run.pushes if push.agent not in run.agents],
        figures=[
            (f.name, f.title, inline_svg(f.name, f.render([run], "svg").decode())) for f in FIGURES if f.applies([run])
        ],
        data=data,
    )


def _agent(run: History, info: AgentInfo, result: AgentResult | None) -> dict[str, Any]:
    agent = run.agents[info.name]
    judged = result if result is not None else agent.judged  # a killed run may have an outcome, but no summary
    return {
        "info": info,
        "outcome": "unknown" if judged is None else judged.outcome,
        "verdict": _verdict(info.name, judged),
        "reason": "" if judged is None else judged.reason,
        "numbers": [] if result is None else _numbers(result),
        "limited": "" if result is None else _counts(result.commands_limited),
        "requirements": () if result is None else result.requirements,
        "tree": _tree(info, agent),
        "inactive": [inactive_rule(rule, [info.robot], missing) for rule, missing in info.inactive.items()],
        "firings": agent.reflexes(run.end),
        "tickets": _tickets(agent),
        "learnt": learnt(agent.knowledge, run.header.start),
        "faults": [(e.t, _fault(e)) for e in agent.faults],
        "swaps": [(e.t, e.text) for e in agent.requested_swaps],
    }


def _verdict(name: str, judged: AgentResult | OutcomeDecided | None) -> str:
    if judged is None:
        return f"The run ended without an outcome of {name}"
    verdict = _VERDICTS.get(judged.outcome, "{name}: " + judged.outcome).format(name=name)
    if judged.outcome != "success":
        return verdict
    if isinstance(judged, AgentResult) and not judged.goals_reached:
        verdict = f"{name} fulfilled its mission"
    reached = judged.time_to_goal
    return verdict if reached is None else f"{verdict} after {reached:.1f} s"


def _numbers(result: AgentResult) -> list[tuple[str, str]]:
    """Measured values as pairs of label and text with unit; missing values are omitted."""
    wanted = (
        ("time to goal", result.time_to_goal, "{:.2f} s"),
        ("path length", result.path_length, "{:.2f} m"),
        ("minimum clearance", result.min_clearance, "{:.3f} m"),
        ("collisions", result.collisions, "{}"),
        ("contacts while stationary", result.struck, "{}"),
        ("falls", 1 if result.fell else None, "{}"),
        ("reflex activations", result.reflex_activations, "{}"),
        ("fired again while latched", result.reflex_refirings, "{}"),
        ("exceptions of content", sum(result.exceptions.values()) or None, "{}"),
        ("plan/reflex switches", result.route_switches, "{}"),
        ("actions resumed after a reflex", result.replans, "{}"),
        ("commands limited by the safety gate", sum(result.commands_limited.values()) or None, "{}"),
        ("time deliberative", result.time_deliberative, "{:.2f} s"),
        ("time reactive", result.time_reactive, "{:.2f} s"),
        ("cross-track error, rms", _scaled(result.tracking_error.cross_rms, 100), "{:.2f} cm"),
        *_following(result.following),
        *_localisation(result.localisation),
        *_sharing(result.sharing),
        ("follower, median", _scaled(result.solve_time.median, 1e6), "{:.0f} µs"),
    )
    return [(label, form.format(value)) for label, value, form in wanted if value is not None]


def _following(following: Following | None) -> list[Number]:
    if following is None:
        return []
    return [
        (f"distance to {following.leader}, mean", following.mean_distance, "{:.2f} m"),
        ("error of the follow distance, mean", following.distance_error, "{:.2f} m"),
        ("time within the follow band", _scaled(following.in_band, 100), "{:.1f} %"),
        ("minimum distance while driving", following.least_driving, "{:.2f} m"),
    ]


def _localisation(error: Localisation | None) -> list[Number]:
    if error is None:
        return []
    return [
        ("position error of the estimate, rms", 100 * error.position_rms, "{:.2f} cm"),
        ("position error of the estimate, maximum", 100 * error.position_max, "{:.2f} cm"),
        ("heading error of the estimate, rms", math.degrees(error.heading_rms), "{:.2f}°"),
        ("heading error of the estimate, maximum", math.degrees(error.heading_max), "{:.2f}°"),
        ("consistency of the estimate (NEES / 3)", error.nees, "{:.2f}"),
    ]


def _sharing(shared: Mapping[str, float] | None) -> list[Number]:
    if shared is None:
        return []
    return [
        ("writes sent to peers", shared.get("written"), "{}"),
        ("writes of peers accepted", shared.get("merged"), "{}"),
        ("messages of peers rejected", sum(shared[reason] for reason in _REJECTED), "{}"),
    ]


def _counts(counts: Mapping[str, int]) -> str:
    """Counts by action, such as `Creep 12, GoTo 3`."""
    return ", ".join(f"{name or 'outside of actions'} {count}" for name, count in counts.items())


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _tree(info: AgentInfo, agent: AgentHistory) -> list[dict[str, Any]]:
    """Table of the mission's nodes, parents before children: depth and last status of each."""
    statuses, rows = agent.statuses(), []
    depth: dict[str, int] = {}
    for node in agent.nodes(info):
        level = depth.setdefault(node.path, 0)
        depth.update(dict.fromkeys(node.children, level + 1))
        last = statuses.get(node.path)
        rows.append(
            {
                "path": node.path,
                "name": node.path.rpartition("/")[2],
                "ports": node.ports,
                "type": node.type,
                "depth": level,
                "status": last.status if last else "never ticked",
                "feedback": last.feedback if last else "",
                "t": last.t if last else None,
            }
        )
    return rows


def _tickets(agent: AgentHistory) -> list[dict[str, Any]]:
    """Table rows of an agent's tickets: times of submission, start and end, and result."""
    rows: dict[int, dict[str, Any]] = {}
    for event in agent.tickets:
        row = rows.setdefault(event.ticket, {"submitted": event.t, "began": None, "ended": None, "by": event.by})
        row.update(number=event.ticket, action=event.action, priority=event.priority, state=event.state)
        row["parameters"] = event.parameters or row.get("parameters", {})
        if event.state == "RUNNING":
            row["began"] = event.t
        elif event.state != "QUEUED":
            row.update(ended=event.t, why=_ending(event))
    return list(rows.values())


def _ending(event: TicketChanged) -> str:
    return event.reason or (f"by {event.by}" if event.state == "CANCELLED" else "")


def _fault(event: FaultEvent) -> str:
    if isinstance(event, ContentRaised):
        return reported(event)
    if isinstance(event, SensorFailed):
        return f"sensor {event.sensor} failed: {event.detail}"
    if isinstance(event, BlockFailed):
        return f"{event.what} {event.kind}: {event.detail}"
    if isinstance(event, CommandExpired):
        return f"no command for {event.actuator}: stopped by its watchdog"
    if isinstance(event, MotionHeld):
        return f"{event.actuator} held in neutral: {event.reason}"
    if isinstance(event, MotionReleased):
        return f"{event.actuator} released" + (f" by {event.by}" if event.by else "")
    if isinstance(event, Stuck):
        return event.reason
    if isinstance(event, (RobotPushed, OtherPublisherFound)):
        return event.text
    if isinstance(event, PeerFault):
        return f"peer {event.peer}: {event.detail}"
    return "struck by " + event.other if event.kind == "struck" else f"{event.kind} with {event.other}"
