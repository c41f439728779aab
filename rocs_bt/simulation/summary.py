"""Summary of a run from its header and its events, so that a live run and its recording give the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..event import Judged
from ..record import Recording, RunHeader
from .metrics import Metrics
from .requirements import RequirementWatch


def make_summary(
    header: RunHeader, metrics: Metrics, requirements: RequirementWatch, end: float, unrecorded: Mapping[str, Any]
) -> dict[str, Any]:
    """Content of summary.json (docs/architecture.md).

    Args:
        header: Header of the run.
        metrics: Metrics over all events of the run.
        requirements: Requirements over all events of the run, closed.
        end: End of the run [s].
        unrecorded: What no event holds, with the keys of summary.json: `wall_time` [s], `trajectory_hash`, `knowledge`
            and `agents.NAME.sharing`. A missing key becomes null.
    """
    wall_time, agents = unrecorded.get("wall_time"), unrecorded.get("agents", {})
    summary = {
        "scenario": header.scenario,
        "seed": header.seed,
        "mode": header.mode,
        "simulated": header.simulated,
        "versions": dict(header.versions),
        "content_hash": header.content_hash,
        "sim_time": end,
        "wall_time": wall_time,
        "real_time_factor": None if wall_time is None else end / max(wall_time, 1e-9),
        "trajectory_hash": unrecorded.get("trajectory_hash"),
        "agents": {
            agent.name: {
                "robot": agent.robot,
                "mission": agent.mission,
                "rules": list(agent.rules),
                **metrics.of(agent.name, end),
                "sharing": agents.get(agent.name, {}).get("sharing"),
                "requirements": [finding.as_dict() for finding in requirements.of(agent.name)],
            }
            for agent in header.agents
        },
    }
    return summary if "knowledge" not in unrecorded else {**summary, "knowledge": unrecorded["knowledge"]}


def summary_of(recording: Recording) -> dict[str, Any]:
    """Content of summary.json, computed from a recording.

    What no event holds comes from the summary at the end of the recording; it is null if the recording is cut off.

    Raises:
        RecordingError: The recording is damaged, or lacks an agent's signals.
    """
    header, end = recording.header, recording.header.start
    metrics = Metrics((agent.name for agent in header.agents), simulated=header.simulated)
    requirements = RequirementWatch(header.requirements, header.agents)
    judged = False
    for event in recording.events():
        metrics.emit(event)
        requirements.emit(event)
        if isinstance(event, Judged):
            end, judged = event.t, True
        elif not judged:
            end = max(end, event.t)
    requirements.close()
    return make_summary(header, metrics, requirements, end, recording.summary or {})
