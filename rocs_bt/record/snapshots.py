"""Signal snapshots of an agent for each period, reconstructed from events, with ground-truth signals.

Values are not interpolated. As in a running agent, a signal keeps its value until it is written again or exceeds its
`max_age`. In lockstep the samples are equal, bit by bit, to those on which the reflexes were evaluated. In threaded
mode there is one sample at each time of a write; samples may differ from the original ones because of the order of
threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import KnowledgeError, RecordingError
from ..event import AgentStopped, BodyMoved, ContactBegan, Event, KnowledgeChanged, MinClearanceLowered, SignalsWritten
from ..expression import Environment
from ..knowledge.signals import SignalTable
from ..signal import Signal
from ..units import ANGLE, LENGTH, NONE
from .header import AgentInfo
from .recording import Recording

#: Ground-truth signals from the simulation, unknown to the agent; only requirements may use them.
TRUTH: tuple[Signal, ...] = (
    Signal("min_clearance", 1, (LENGTH,), doc="Minimum distance so far from the hull to any geom but the floor."),
    Signal("true_pose", 3, (LENGTH, LENGTH, ANGLE), doc="Ground-truth pose, world frame."),
    Signal("true_height", 1, (LENGTH,), doc="Ground-truth height of the base; invalid for robots on wheels."),
    Signal("true_tilt", 1, (ANGLE,), doc="Ground-truth angle from the vertical; invalid for robots on wheels."),
    Signal("collisions", 1, (NONE,), doc="Number of collisions caused so far."),
    Signal("struck", 1, (NONE,), doc="Number of contacts so far while the robot was stationary."),
)


@dataclass(frozen=True, eq=False)
class Sample:
    """Sample of an agent's signals.

    Attributes:
        t: Time [s].
        x: Signals in the order of the snapshots, then those of TRUTH, SI units, shape (size,); NaN if invalid.
        mode: Mode of the agent.
        felt: Whether the agent evaluated its reflexes on this sample; False when the agent was stopped before that.
    """

    t: float
    x: NDArray[np.float64]
    mode: str
    felt: bool = True


class Snapshots:
    """Reconstructs samples from the events of one agent.

    Args:
        agent: Agent in the header of the recording.

    Raises:
        RecordingError: The header does not declare the agent's signals.
    """

    def __init__(self, agent: AgentInfo) -> None:
        self.name = agent.name
        self._late = {s.name for s in agent.signals if s.late}
        self._table = SignalTable()
        for signal in _declared(agent):
            self._table.declare(signal)
        self._table.freeze()
        self._clearance, self._pose, self._touches = math.inf, (math.nan,) * 3, {"collision": 0, "struck": 0}
        self._height = self._tilt = math.nan
        self._mode = ""
        self._t: float | None = None
        self._waiting: list[SignalsWritten | KnowledgeChanged] = []
        self._stopped = False

    def take(self, event: Event) -> Sample | None:
        """Process one event; returns the sample that it completes, if any."""
        if event.agent != self.name or self._stopped:
            return None
        if isinstance(event, (SignalsWritten, BodyMoved)):
            sample = self._begin(event.t)
            self._apply(event)
            return sample
        if isinstance(event, AgentStopped):
            self._stopped = True
            # In lockstep an agent is stopped at the beginning of a period, before its reflexes.
            return None if self._t is None else self._sample(self._t, felt=event.t > self._t)
        self._apply(event)
        return None

    def end(self) -> Sample | None:
        """Last sample of a recording that was cut off; None if the agent was stopped, which gave the last sample."""
        return None if self._stopped or self._t is None else self._sample(self._t)

    def _begin(self, t: float) -> Sample | None:
        """Begin a new sample if `t` [s] is later than the present one's time; returns the finished sample, or None."""
        if self._t is not None and t <= self._t:
            return None
        sample = None if self._t is None else self._sample(self._t)
        self._t = t
        waiting, self._waiting = self._waiting, []
        for event in waiting:
            self._write(event)
        return sample

    def _sample(self, t: float, felt: bool = True) -> Sample:
        touches = self._touches["collision"], self._touches["struck"]
        truth = (self._clearance, *self._pose, self._height, self._tilt, *touches)
        return Sample(t, np.concatenate([self._table.snapshot(t), truth]), self._mode, felt)

    def _apply(self, event: Event) -> None:
        if isinstance(event, BodyMoved):
            self._pose = event.x, event.y, event.yaw
            if event.height is not None:
                self._height, self._tilt = event.height, event.tilt
        elif isinstance(event, MinClearanceLowered):
            self._clearance = event.distance
        elif isinstance(event, ContactBegan):
            self._touches[event.kind] += 1
        elif isinstance(event, KnowledgeChanged) and event.subject == self.name and event.name == "mode":
            self._wait_or_write(event, late=True)
        elif isinstance(event, SignalsWritten):
            self._wait_or_write(event, late=not self._late.isdisjoint(event.signals))

    def _wait_or_write(self, event: SignalsWritten | KnowledgeChanged, late: bool) -> None:
        if late and self._t is not None:
            self._waiting.append(event)
        else:
            self._write(event)

    def _write(self, event: SignalsWritten | KnowledgeChanged) -> None:
        if isinstance(event, SignalsWritten):
            try:
                self._table.update(event.values, event.t if event.stamp is None else event.stamp)
            except KnowledgeError as error:
                raise RecordingError(f"the recording is damaged at t = {event.t:g} s: {error}") from error
        else:
            self._mode = str(event.value or "")


def environment_of(agent: AgentInfo, truth: bool = False) -> Environment:
    """Names available to expressions over an agent's samples.

    Args:
        agent: Agent in the header of the recording.
        truth: Whether to include the signals of TRUTH.

    Raises:
        RecordingError: The header does not declare the agent's signals.
    """
    return Environment.packed([*_declared(agent), *(TRUTH if truth else ())])


def samples_of(recording: Recording, agent: AgentInfo) -> Iterator[Sample]:
    """Samples of one agent of a recording, in order.

    Raises:
        RecordingError: The recording cannot be read, or its header does not declare the agent's signals.
    """
    return samples_in(recording.events(), Snapshots(agent))


def samples_in(events: Iterable[Event], snapshots: Snapshots) -> Iterator[Sample]:
    """Samples reconstructed from events."""
    for event in events:
        if (sample := snapshots.take(event)) is not None:
            yield sample
    if (sample := snapshots.end()) is not None:
        yield sample


def _declared(agent: AgentInfo) -> list[Signal]:
    if not agent.signals:
        raise RecordingError(
            f"the recording does not declare the signals of '{agent.name}': it has an older version or was not made by "
            "a run. Run the scenario again."
        )
    return [signal.signal() for signal in agent.signals]
