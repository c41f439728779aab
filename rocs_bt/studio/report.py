"""The page as a file: of a recorded run, of two runs, of the knowledge of an agent, and of the tree of a mission."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from ..base.errors import Fault, RecordingError
from ..base.files import write_whole
from ..event import Level, TreeNode
from ..knowledge.history import ChangeLog
from ..record import AgentInfo, AgentResult, Recording, RunHeader, Summary
from ..record.explanation.comparisons import Comparisons
from ..record.fold.states import LogLine
from ..record.fold.tracks import Tracks
from .numbers import numbers, requirement
from .pack import Json, opens_at, pack
from .page import render_page

KILLED = "The run was killed: its recording ends here."


def write_report(recording: Recording, summary: Summary | None, path: Path, second: Recording | None = None) -> None:
    """Write the report of a run; the file is replaced only when it is complete.

    Args:
        recording: Recording of the run.
        summary: Summary of the run; None if there is none.
        path: HTML file to write.
        second: Recording of another run, which is shown over the first.

    Raises:
        RecordingError: The file cannot be written.
    """
    text = render_report(recording, summary, second)
    try:
        write_whole(path, text)
    except OSError as error:
        raise RecordingError(f"the report '{path}' cannot be written: {error.strerror}.") from error


def render_report(recording: Recording, summary: Summary | None, second: Recording | None = None) -> str:
    """Render the report as HTML."""
    other = b"" if second is None else packed_run(second, second.summary)
    title = recording.header.label if second is None else f"{recording.header.label} and {second.header.label}"
    return render_page(title, packed_run(recording, summary), other)


def render_knowledge(log: ChangeLog) -> str:
    """Render the knowledge of an agent over time as HTML."""
    title, agent = f"Knowledge of {log.agent}", AgentInfo(name=log.agent, robot="", mission="")
    tracks = Tracks(RunHeader(scenario=title, seed=0, command=log.label, start=log.begin, agents=(agent,)))
    tracks.take(log.all_changes())
    tracks.end = max(tracks.end, log.end)
    return render_page(title, pack(tracks, {}))


def render_tree(title: str, doc: str, nodes: Sequence[TreeNode], faults: Iterable[Fault]) -> str:
    """Render the tree of a mission as HTML, with the faults that a check found."""
    agent = AgentInfo(name=title, robot="", mission=doc, nodes=tuple(nodes))
    tracks = Tracks(RunHeader(scenario=title, seed=0, agents=(agent,)))
    for fault in faults:
        level = Level.WARNING if fault.warning else Level.ERROR
        tracks.log.append(LogLine(0.0, title, level, str(fault), None))
    return render_page(title, pack(tracks, {}))


def packed_run(recording: Recording, summary: Summary | None, *, end: str = KILLED) -> bytes:
    """A recorded run, packed for the page.

    Args:
        recording: Recording of the run.
        summary: Summary of the run; None if there is none.
        end: Reason for the end of a recording that is not complete, if it is not damaged.
    """
    tracks = Tracks.of_recording(recording)
    Comparisons(tracks).update(over=True)
    about = {
        "missing": missing_of(recording, end),
        "decisive": opens_at(tracks, {} if summary is None else {n: a.outcome for n, a in summary.agents.items()}),
        "results": {} if summary is None else about_end(summary),
    }
    return pack(tracks, about)


def missing_of(recording: Recording, end: str) -> str:
    """Why a recording ends early: its damage, or the given reason; empty for a complete one."""
    return "" if recording.complete else recording.missing if recording.damage else end


def about_end(summary: Summary) -> Json:
    """Results of the agents, for the page."""
    return {name: _result(result) for name, result in summary.agents.items()}


def _result(result: AgentResult) -> Json:
    return {
        "outcome": result.outcome,
        "reason": result.reason,
        "time_to_goal": result.time_to_goal,
        "numbers": numbers(result),
        "requirements": [requirement(finding) for finding in result.requirements],
    }
