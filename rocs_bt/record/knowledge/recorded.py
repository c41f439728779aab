"""Knowledge of an agent in a recording: change log, and pose and signals at the time of a query."""

from __future__ import annotations

import math

from ...base.errors import InputError, RecordingError, unknown
from ...base.geometry import Pose2
from ...event import KnowledgeChanged
from ...knowledge import SCHEMA, QueryContext, Schema, SignalTable
from ...knowledge.history import ChangeLog, GraphState
from ..file.recording import Recording
from ..fold.samples import SAMPLE_TOPICS, environment_of, samples
from ..fold.tracks import Tracks


def recorded_log(recording: Recording, agent: str | None = None, schema: Schema = SCHEMA) -> ChangeLog:
    """Change log of an agent's knowledge in a recording.

    Args:
        recording: Recording of the run.
        agent: Name of the agent; optional if there is only one.
        schema: Schema of the project in which the run was recorded.

    Raises:
        InputError: Unknown agent, or an agent is required; lists all agents.
        RecordingError: The recording has no changes of the agent's knowledge.
    """
    tracks = Tracks.of_recording(recording, ("pose", "event"))
    found, end = [event for event in tracks.events if isinstance(event, KnowledgeChanged)], tracks.end
    names = list(dict.fromkeys((*(a.name for a in recording.header.agents), *(e.agent for e in found))))
    if agent is None and len(names) == 1:
        agent = names[0]
    if agent is None:
        raise InputError(f"'{recording.path}' contains the knowledge of {', '.join(names)}. Choose one with --agent.")
    if agent not in names:
        raise InputError(unknown("agent", agent, names, f"'{recording.path}'"))
    changes = sorted((e for e in found if e.agent == agent), key=lambda e: e.revision)
    if not changes:
        raise RecordingError(f"'{recording.path}' has no changes of the knowledge of {agent}.")
    return ChangeLog(GraphState(agent, schema), recording.header.label, changes, begin=changes[0].t, end=end)


def recorded_context(recording: Recording, log: ChangeLog, t: float) -> tuple[QueryContext, SignalTable]:
    """Inputs of a query on recorded knowledge: pose and signals of the querying robot at a time of the run.

    Args:
        recording: Recording of the run.
        log: Change log of the agent's knowledge.
        t: Time of the query [s].

    Raises:
        RecordingError: The recording lacks the agent or its signals.
    """
    info = next((agent for agent in recording.header.agents if agent.name == log.agent), None)
    if info is None:
        raise RecordingError(f"'{recording.path}' has no signals of {log.agent}.")
    table = SignalTable()
    for signal in environment_of(info).signals.values():
        table.declare(signal)
    table.freeze()
    _, x = samples(Tracks.of_recording(recording, SAMPLE_TOPICS), info, before=math.nextafter(t, math.inf))
    if len(x):
        table.update({name: x[-1, table.slice_of(name)] for name in table.names}, t)

    def read(name: str) -> list[float]:
        values: list[float] = table.read(name, t).tolist()
        return values

    pose = Pose2(*read("pose")) if "pose" in table else Pose2(math.nan, math.nan)
    return QueryContext(log.agent, None if math.isnan(pose.x) else pose, t, read, log), table
