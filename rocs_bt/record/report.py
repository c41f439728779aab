"""report.html: one file that needs nothing else, drawn from the recording alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from ..errors import RecordingError
from ..event import BlockFailed, CommandExpired, ContentRaised, PeerFault, SensorFailed, Stuck, TicketChanged
from ..raised import reported
from .animation import animation
from .atomic_file import write_whole
from .figures.plot import FIGURES
from .header import AgentInfo
from .history import AgentHistory, FaultEvent, History
from .knowledge.learnt import learnt
from .page import inline_svg, render_page
from .recording import Recording

_VERDICTS = {
    "success": "{name} reached its goal",
    "collision": "{name} collided",
    "failed": "The mission of {name} failed",
    "stuck": "{name} got stuck",
    "interrupted": "The run was ended before {name} came to another outcome",
    "timeout": "{name} ran out of time",
    "error": "{name} was stopped by an error",
}


def write_report(recording: Recording, summary: Mapping[str, Any] | None, path: Path) -> None:
    """Write the report of a run, as a whole or not at all.

    Args:
        recording: The run.
        summary: What summary.json holds; None where the run did not get so far.
        path: The HTML file.

    Raises:
        RecordingError: The file cannot be written, or the recording not read.
    """
    text = render_report(recording, summary)
    try:
        write_whole(path, text)
    except OSError as error:
        raise RecordingError(f"the report '{path}' cannot be written: {error.strerror}.") from error


def render_report(recording: Recording, summary: Mapping[str, Any] | None) -> str:
    """The report as HTML."""
    run = History(recording)
    summary = summary or {}
    told = summary.get("agents", {})
    # In JSON `<` occurs in texts only, where this escape means the same; no text can then end the script element.
    data = msgspec.json.encode(animation(run)).decode().replace("<", "\\u003c")
    return render_page(
        "report.html",
        header=run.header,
        complete=recording.complete,
        summary=summary,
        end=run.end,
        agents=[_agent(run, info, told.get(info.name, {})) for info in run.header.agents],
        figures=[(f.name, f.title, inline_svg(f.name, f.render([run], "svg").decode())) for f in FIGURES],
        data=data,
    )


def _agent(run: History, info: AgentInfo, told: Mapping[str, Any]) -> dict[str, Any]:
    agent = run.agents[info.name]
    if agent.judged is not None:  # a run that was killed later has this, but no summary
        judged = {"outcome": agent.judged.outcome, "reason": agent.judged.reason}
        told = {**judged, "time_to_goal": agent.judged.time_to_goal, **told}
    return {
        "info": info,
        "outcome": told.get("outcome", "unknown"),
        "verdict": _verdict(info.name, told),
        "reason": told.get("reason", ""),
        "numbers": _numbers(told),
        "requirements": told.get("requirements", ()),
        "tree": _tree(info, agent),
        "firings": agent.reflexes(run.end),
        "tickets": _tickets(agent),
        "learnt": learnt(agent.knowledge, run.header.start),
        "faults": [(e.t, _fault(e)) for e in agent.faults],
    }


def _verdict(name: str, told: Mapping[str, Any]) -> str:
    if "outcome" not in told:
        return f"The run ended before {name} came to an outcome"
    verdict = _VERDICTS.get(told["outcome"], "{name}: " + str(told["outcome"])).format(name=name)
    if told["outcome"] == "success" and not told.get("goals_reached", True):
        verdict = f"{name} fulfilled its mission"
    reached = told.get("time_to_goal")
    return f"{verdict} after {reached:.1f} s" if told["outcome"] == "success" and reached is not None else verdict


def _numbers(told: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the summary measured, as label and text with its unit; only what is there."""
    error, solve = told.get("tracking_error") or {}, told.get("solve_time") or {}
    lost, leash = told.get("localisation") or {}, told.get("following") or {}
    shared = told.get("sharing") or {}
    wanted = (
        ("time to goal", told.get("time_to_goal"), "{:.2f} s"),
        ("path length", told.get("path_length"), "{:.2f} m"),
        ("least clearance", told.get("min_clearance"), "{:.3f} m"),
        ("collisions", told.get("collisions"), "{}"),
        ("struck by others", told.get("struck"), "{}"),
        ("reflexes fired", told.get("reflex_activations"), "{}"),
        ("fired again while latched", told.get("reflex_refirings"), "{}"),
        ("exceptions of content", sum(told.get("exceptions", {}).values()) or None, "{}"),
        ("switches of route", told.get("route_switches"), "{}"),
        ("plans made anew", told.get("replans"), "{}"),
        ("commands limited by the safety gate", _counts(told.get("commands_limited")), "{}"),
        ("time deliberative", told.get("time_deliberative"), "{:.2f} s"),
        ("time reactive", told.get("time_reactive"), "{:.2f} s"),
        ("cross-track error, rms", _scaled(error.get("cross_rms"), 100), "{:.2f} cm"),
        (f"distance to {leash.get('leader')}, mean", leash.get("mean_distance"), "{:.2f} m"),
        ("how far it is from the one asked for, mean", leash.get("distance_error"), "{:.2f} m"),
        ("following time within its band", _scaled(leash.get("in_band"), 100), "{:.1f} %"),
        ("least distance while driving", leash.get("least_driving"), "{:.2f} m"),
        ("position estimate's error, rms", _scaled(lost.get("position_rms"), 100), "{:.2f} cm"),
        ("position estimate's error, greatest", _scaled(lost.get("position_max"), 100), "{:.2f} cm"),
        ("heading estimate's error, rms", _scaled(lost.get("heading_rms"), 180 / math.pi), "{:.2f}°"),
        ("heading estimate's error, greatest", _scaled(lost.get("heading_max"), 180 / math.pi), "{:.2f}°"),
        ("estimate's consistency (NEES over 3)", lost.get("nees"), "{:.2f}"),
        ("own writes that peers were told", shared.get("written"), "{}"),
        ("writes of peers that were taken", shared.get("merged"), "{}"),
        ("messages of peers that were turned away", _turned_away(shared), "{}"),
        ("follower, median", _scaled(solve.get("median"), 1e6), "{:.0f} µs"),
    )
    return [(label, form.format(value)) for label, value, form in wanted if value is not None]


def _turned_away(shared: Mapping[str, int]) -> int | None:
    reasons = ("oversized", "unauthenticated", "malformed", "flooded", "refused")
    return sum(shared[reason] for reason in reasons) if shared else None


def _counts(counts: Mapping[str, int] | None) -> str | None:
    """Counts by action, such as `12 (Creep 12)`; None where there are none."""
    if not counts:
        return None
    each = ", ".join(f"{name or 'outside of actions'} {count}" for name, count in counts.items())
    return f"{sum(counts.values())} ({each})"


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _tree(info: AgentInfo, agent: AgentHistory) -> list[dict[str, Any]]:
    """The mission's nodes with their last statuses, and how deep each stands."""
    said, rows = agent.statuses(), []
    depth: dict[str, int] = {}
    for node in agent.nodes(info):
        level = depth.setdefault(node.path, 0)
        depth.update(dict.fromkeys(node.children, level + 1))
        last = said.get(node.path)
        rows.append(
            {
                "path": node.path,
                "name": node.path.rpartition("/")[2],
                "type": node.type,
                "depth": level,
                "status": last.status if last else "never ticked",
                "feedback": last.feedback if last else "",
                "t": last.t if last else None,
            }
        )
    return rows


def _tickets(agent: AgentHistory) -> list[dict[str, Any]]:
    """One row for each ticket: when it was submitted, began and ended, and how."""
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
        return f"no command came for {event.actuator}, so it was stopped"
    if isinstance(event, Stuck):
        return event.reason
    if isinstance(event, PeerFault):
        return f"peer {event.peer}: {event.detail}"
    return "struck by " + event.other if event.kind == "struck" else f"{event.kind} with {event.other}"
