"""Summary of a run, computed from header and events: a run and its recording give equal summaries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from msgspec import UNSET, UnsetType

from ..event import OutcomeDecided
from ..record import KnowledgeFile, Recording, RunHeader, Summary
from .metrics import Metrics
from .requirements import RequirementWatch


@dataclass(frozen=True)
class Unrecorded:
    """Parts of a summary that no event contains.

    Attributes:
        wall_time: Wall-clock duration of the run [s]; None if unknown.
        trajectory_hash: Hash of the trajectory; None if unknown.
        sharing: Statistics of the shared knowledge, by agent; an agent that does not share is None or missing.
        knowledge: Knowledge kept from run to run; UNSET without a file.
    """

    wall_time: float | None = None
    trajectory_hash: str | None = None
    sharing: Mapping[str, Mapping[str, float] | None] = field(default_factory=dict)
    knowledge: KnowledgeFile | UnsetType = UNSET


def make_summary(
    header: RunHeader, metrics: Metrics, requirements: RequirementWatch, end: float, unrecorded: Unrecorded
) -> Summary:
    """Summary of a run.

    Args:
        header: Header of the run.
        metrics: Metrics over all events of the run.
        requirements: Checks of the requirements over all events of the run, after `close`.
        end: Time of the end of the run [s].
        unrecorded: Parts that no event contains.
    """
    wall_time, sharing, duration = unrecorded.wall_time, unrecorded.sharing, end - header.start
    return Summary(
        scenario=header.scenario,
        seed=header.seed,
        mode=header.mode,
        simulated=header.simulated,
        versions=header.versions,
        content_hash=header.content_hash,
        sim_time=duration,
        wall_time=wall_time,
        real_time_factor=None if wall_time is None else duration / max(wall_time, 1e-9),
        trajectory_hash=unrecorded.trajectory_hash,
        agents={
            agent.name: metrics.of(agent, end, sharing.get(agent.name), requirements.of(agent.name))
            for agent in header.agents
        },
        knowledge=unrecorded.knowledge,
    )


def summary_of(recording: Recording) -> Summary:
    """Summary of a run, computed from its recording.

    Parts that no event contains come from the summary at the end of the recording; in a truncated recording they are
    None.

    Raises:
        RecordingError: The recording lacks an agent's signals.
    """
    header, end = recording.header, recording.header.start
    metrics = Metrics(header)
    requirements = RequirementWatch(header.requirements, header.agents)
    undecided = {agent.name for agent in header.agents}
    for event in recording.events():
        metrics.emit(event)
        requirements.emit(event)
        if isinstance(event, OutcomeDecided):
            end = event.t
            undecided.discard(event.agent)
        elif undecided:
            end = max(end, event.t)
    requirements.close()
    unrecorded, written = Unrecorded(), recording.summary
    if written is not None:
        sharing = {name: result.sharing for name, result in written.agents.items()}
        unrecorded = Unrecorded(written.wall_time, written.trajectory_hash, sharing, written.knowledge)
    return make_summary(header, metrics, requirements, end, unrecorded)
