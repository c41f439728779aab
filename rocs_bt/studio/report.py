"""report.html: the page of a run that is over, made from its recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import RecordingError
from ..files import write_whole
from ..record import AgentResult, Recording, Summary
from ..record.comparisons import Comparisons
from ..record.tracks import Tracks
from ..words import inactive_rule
from .numbers import numbers, requirement
from .pack import pack
from .page import render_page


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
    tracks = Tracks(recording.header)
    tracks.take(recording.events())
    comparisons = Comparisons(tracks)
    comparisons.update(over=True)
    results = {} if summary is None else summary.agents
    about = {
        "complete": recording.complete,
        "guards": comparisons.texts(),
        "results": {name: _result(result) for name, result in results.items()},
        "inactive": {
            agent.name: [inactive_rule(rule, [agent.robot], missing) for rule, missing in agent.inactive.items()]
            for agent in recording.header.agents
        },
    }
    return render_page(recording.header.label, pack(tracks, about))


def _result(result: AgentResult) -> dict[str, Any]:
    return {
        "outcome": result.outcome,
        "reason": result.reason,
        "time_to_goal": result.time_to_goal,
        "numbers": numbers(result),
        "requirements": [requirement(finding) for finding in result.requirements],
    }
