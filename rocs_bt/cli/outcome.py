"""Outcome of a run as text and as exit code."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import RecordingError
from ..words import counted
from .requirements import finding_line
from .terminal import styled

if TYPE_CHECKING:
    from ..record import AgentResult, Following, KnowledgeFile, Localisation, Summary

_FAULTS = 3  # maximum number of printed faults


def exit_code(summary: Summary, *, signal: int | None = None, missing: bool = False) -> int:
    """Exit code of a command that ran a scenario.

    Args:
        summary: Summary of the run.
        signal: Signal that ended the run, if any.
        missing: Whether a file of the run could not be written.

    Returns:
        128 + signal; else 3 if a block of the engine failed; else 0 if every agent succeeded and every file was
        written; else 1.
    """
    agents = list(summary.agents.values())
    if signal is not None:
        return 128 + signal
    if any(agent.outcome == "error" and agent.failed_owner != "content" for agent in agents):
        return 3
    return int(missing or any(agent.outcome != "success" for agent in agents))


def outcome_text(summary: Summary, folder: Path, report: Path | None) -> str:
    """Outcome of each agent in a few lines, path of the report, and suggested commands.

    Args:
        summary: Summary of the run.
        folder: Folder of the run.
        report: Report file, if any.
    """
    lines: list[str] = []
    for name, agent in summary.agents.items():
        lines += _outcome(name, agent, summary)
        lines += [f"  {finding_line(name, finding)}" for finding in agent.requirements]
    where = shlex.quote(str(folder))
    if summary.knowledge:
        lines += _remembered(summary.knowledge)
    if report is not None:
        lines.append(f"Report: {report}")
    why = _start(summary, folder) + min(summary.sim_time / 2, 5.0)
    lines.append(f"Try next: rocs-bt replay {where} --why {why:.1f}   or   rocs-bt plot {where}")
    return "\n".join(lines)


def _start(summary: Summary, folder: Path) -> float:
    """Time of the first control period [s]: on hardware, the preflight check comes before it."""
    if summary.simulated:
        return 0.0
    from ..record import Recording

    try:
        return Recording.open(folder).header.start
    except RecordingError:
        return 0.0


def _remembered(kept: KnowledgeFile) -> list[str]:
    """Lines about the knowledge loaded at the start, its refused items, and the file with this run's knowledge."""
    lines = []
    for name, found in kept.remembered.items():
        lines.append(
            f"{name} loaded {counted(found.nodes, 'node')} and {counted(found.edges, 'relation')}"
            f" of earlier runs{', but not all' if found.refused else ''}."
        )
        lines += [f"  refused: {reason}" for reason in found.refused[:_FAULTS]]
    if kept.lost:
        lines.append(f"{counted(kept.lost, 'change')} of knowledge lost: the disk was too slow.")
    file = shlex.quote(kept.file)
    return [*lines, f"Knowledge: {file}   (rocs-bt knowledge show {file})"]


def _outcome(name: str, agent: AgentResult, summary: Summary) -> list[str]:
    colour = "green" if agent.outcome == "success" else "red"
    outcome = styled(f"{name} {agent.outcome}", fg=colour, bold=True)
    reason = f": {agent.reason}" if agent.reason else ""
    place = f"{summary.scenario}, seed {summary.seed}"
    took = f" in {agent.time_to_goal:.1f} s" if agent.time_to_goal is not None else ""
    reactive, deliberative = agent.time_reactive, agent.time_deliberative
    share = 100.0 * reactive / max(reactive + deliberative, 1e-9)
    refirings = agent.reflex_refirings
    again = f", {counted(refirings, 're-firing')} while latched" if refirings else ""
    clearance, collisions = agent.min_clearance, agent.collisions
    hit = "" if collisions is None else f" with {counted(collisions, 'collision')}"
    near = "" if clearance is None else f", minimum clearance {max(clearance, 0.0):.2f} m"
    struck = f", {counted(agent.struck, 'contact')} while stationary" if agent.struck else ""
    struck += ", then fell" if agent.fell and agent.outcome != "fell" else ""
    kept = [*_followed(agent.following), *_located(agent.localisation)]
    faults = [f"  fault at {fault}" for fault in agent.faults[:_FAULTS]]
    if (more := len(agent.faults) - _FAULTS) > 0:
        faults.append(f"  and {counted(more, 'more fault')}: see the report")
    return [
        f"{outcome}{took} ({place}){reason}",
        f"  moved {agent.path_length:.2f} m{hit}{struck}{near}; {_duration(summary)}",
        f"  {counted(agent.reflex_activations, 'reflex activation')} ({share:.0f} % of the time){again},"
        f" {counted(agent.replans, 'replan')},"
        f" {counted(agent.route_switches, 'plan/reflex switch', 'es')}",
        *kept,
        *faults,
    ]


def _duration(summary: Summary) -> str:
    if not summary.simulated:
        return f"{summary.sim_time:.1f} s in all"
    simulated = f"{summary.sim_time:.1f} s simulated"
    if summary.wall_time is None:  # unknown for a recording that was cut off
        return simulated
    return f"{simulated} in {summary.wall_time:.1f} s ({summary.real_time_factor:.0f} times real time)"


def _followed(following: Following | None) -> list[str]:
    """Line about the distance to a leader; none for an agent that followed no robot or never caught up."""
    if following is None or following.mean_distance is None or following.in_band is None:
        return []
    driving = following.least_driving
    near = "" if driving is None else f", minimum {driving:.2f} m while driving"
    return [
        f"  followed {following.leader} at a mean distance of {following.mean_distance:.2f} m,"
        f" {100.0 * following.in_band:.0f} % of the time within the follow band{near}"
    ]


def _located(error: Localisation | None) -> list[str]:
    """Line about the error of the pose estimate; none for an agent without an estimator."""
    if error is None:
        return []
    rms = f"{100.0 * error.position_rms:.1f} cm and {math.degrees(error.heading_rms):.1f} deg"
    most = f"{100.0 * error.position_max:.1f} cm and {math.degrees(error.heading_max):.1f} deg"
    return [f"  error of the pose estimate: {rms} (rms), at most {most}"]
