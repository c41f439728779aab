"""Knowledge of an agent in a recording: change log, and pose and signals at the time of a query."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from ...base.errors import InputError, RecordingError, unknown
from ...base.geometry import Pose2
from ...base.signal import Signal
from ...event import KnowledgeChanged
from ...expression import Environment
from ...knowledge import SCHEMA, QueryContext, Schema
from ...knowledge.history import ChangeLog, State
from ..recording import Recording
from ..samples import TOPICS, environment_of, samples
from ..tracks import Tracks


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
    return ChangeLog(State(agent, schema), recording.header.label, changes, begin=changes[0].t, end=end)


class RecordedSignals:
    """Values of all signals of an agent at one time of a recording.

    Args:
        environment: Layout of the signals in a sample.
        x: Sample of the signals, SI units; NaN for invalid ones.
    """

    def __init__(self, environment: Environment, x: Sequence[float]) -> None:
        self._environment = environment
        self._x = x

    @property
    def names(self) -> Collection[str]:
        """Names of all signals."""
        return self._environment.signals.keys()

    def spec(self, name: str) -> Signal:
        """Declaration of a signal."""
        return self._environment.signals[name]

    def slice_of(self, name: str) -> slice:
        """Slice of the sample of all signals that contains the values of one signal."""
        start = self._environment.offsets[name]
        return slice(start, start + self.spec(name).size)

    def read(self, name: str) -> Sequence[float]:
        """Values of a signal, SI units."""
        return self._x[self.slice_of(name)]


def recorded_context(recording: Recording, log: ChangeLog, t: float) -> tuple[QueryContext, RecordedSignals]:
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
    environment = environment_of(info)
    _, x = samples(Tracks.of_recording(recording, TOPICS), info, before=math.nextafter(t, math.inf))
    signals = RecordedSignals(environment, x[-1].tolist() if len(x) else [math.nan] * environment.size)
    pose = Pose2(*signals.read("pose")) if "pose" in signals.names else Pose2(math.nan, math.nan)
    here = None if math.isnan(pose.x) else pose
    return QueryContext(log.agent, here, t, signals.read, log), signals
