"""Outcome of a run as text and as exit code."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import RecordingError
from ..base.words import counted
from .requirements import finding_line
from .terminal import styled

if TYPE_CHECKING:
    from ..record import AgentResult, Following, KnowledgeFile, Localisation, Summary

_FAULTS = 3  # maximum number of printed faults
_SHORT = 5  # number of agents above which each has one line


def exit_code(summary: Summary, *, signal: int | None = None, missing: bool = False) -> int:
    """Exit code of a command that ran a scenario.

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
    """Outcome of each agent in a few lines, path of the report, and suggested commands."""
    lines: list[str] = []
    many = len(summary.agents) > _SHORT
    if many:
        lines += _counts(summary)
    for name, agent in summary.agents.items():
        lines += [_line(name, agent)] if many else _outcome(name, agent, summary)
        lines += [f"  {finding_line(name, finding)}" for finding in agent.requirements]
    where = shlex.quote(str(folder))
    if summary.knowledge:
        lines += _remembered(summary.knowledge)
    if report is not None:
        lines.append(f"Report: {report}")
    lines.append(f"Try next: rocs-bt replay {where} --why {_moment(summary, folder)}   or   rocs-bt plot {where}")
    return "\n".join(lines)


def _moment(summary: Summary, folder: Path) -> str:
    """Time to explain, with the agent if it is not the first: the decisive moment of the run."""
    from ..record import Recording
    from ..record.explanation.decisive import DECISIVE_TOPICS, decisive
    from ..record.fold.tracks import Tracks

    t, name = min(summary.sim_time / 2, 5.0), ""
    outcomes = {name: agent.outcome for name, agent in summary.agents.items()}
    succeeded = set(outcomes.values()) <= {"success"}
    try:
        recording = Recording.open(folder)
        t += 0.0 if summary.simulated else recording.header.start  # on hardware, the preflight check comes first
        tracks = Tracks.of_recording(recording, ("rule", "outcome") if succeeded else DECISIVE_TOPICS)
        for found in decisive(tracks, outcomes)[:1]:
            t, name = found.t, found.about.agent
    except RecordingError:  # the run has no recording
        pass
    seconds = f"{t:.3f}".rstrip("0")
    other = f" --agent {shlex.quote(name)}" if name not in ("", next(iter(outcomes), "")) else ""
    return seconds + ("0" if seconds.endswith(".") else "") + other


def _counts(summary: Summary) -> list[str]:
    """Line with the number of agents of each outcome, and the duration of the run."""
    counts = Counter(agent.outcome for agent in summary.agents.values())
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    return [f"{len(summary.agents)} agents: {outcomes} ({summary.scenario}, seed {summary.seed}); {_duration(summary)}"]


def _line(name: str, agent: AgentResult) -> str:
    """Outcome of one agent of many in one line."""
    outcome = styled(f"{name} {agent.outcome}", fg="green" if agent.outcome == "success" else "red", bold=True)
    took = f" in {agent.time_to_goal:.1f} s" if agent.time_to_goal is not None else ""
    hit = f", {counted(agent.collisions, 'collision')}" if agent.collisions else ""
    reason = f": {agent.reason}" if agent.reason else ""
    reflexes = counted(agent.reflex_activations, "reflex", "es")
    return f"{outcome}{took} (moved {agent.path_length:.2f} m{hit}, {reflexes}){reason}"


def _remembered(kept: KnowledgeFile) -> list[str]:
    """Lines about the knowledge loaded at the start, its refused items, and the file with this run's knowledge."""
    lines = []
    for name, found in kept.remembered.items():
        lines.append(
            f"{name} loaded {counted(found.nodes, 'node')} and {counted(found.edges, 'relation')}"
            f" of earlier runs{', but not all' if found.refused else ''}."
        )
        lines += [f"  refused: {reason}" for reason in found.refused[:_FAULTS]]
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
    struck = f", struck {counted(agent.struck, 'time')}" if agent.struck else ""
    struck += ", then fell" if agent.fell and agent.outcome != "fell" else ""
    kept = [*_followed(agent.following), *_located(agent.localisation)]
    faults = [f"  fault at {fault}" for fault in agent.faults[:_FAULTS]]
    if (more := len(agent.faults) - _FAULTS) > 0:
        faults.append(f"  and {counted(more, 'more fault')}: see the report")
    return [
        f"{outcome}{took} ({place}){reason}",
        f"  moved {agent.path_length:.2f} m{hit}{struck}{near}; {_duration(summary)}",
        f"  {counted(agent.reflex_activations, 'reflex activation')} ({share:.0f} % of the time){again},"
        f" {counted(agent.replans, 'action')} resumed after a reflex,"
        f" {counted(agent.route_switches, 'plan/reflex switch', 'es')}",
        *kept,
        *faults,
    ]


def _duration(summary: Summary) -> str:
    if not summary.simulated:
        return f"{summary.sim_time:.1f} s in all"
    simulated = f"{summary.sim_time:.1f} s simulated"
    if summary.wall_time is None or summary.real_time_factor is None:  # unknown for a recording that was cut off
        return simulated
    return f"{simulated} in {summary.wall_time:.1f} s ({_factor(summary.real_time_factor)} times real time)"


def _factor(value: float) -> str:
    return f"{value:.0f}" if value >= 1.0 else f"{value:.2g}"


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
