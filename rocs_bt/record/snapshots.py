"""What an agent's reflexes saw, period by period, rebuilt from events; and what was true meanwhile.

Nothing is interpolated. A signal's value stands from when it was written until it is written again or is older than
its `max_age`, as in the live table. In lockstep the samples are those that the reflexes were evaluated on, to the bit;
in threaded mode there is one at each time of a write, so that they may differ by what one thread did before another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..event import AgentStopped, Approached, BodyMoved, Event, KnowledgeChanged, SignalsWritten, Touched
from ..expression import Environment
from ..knowledge.signals import SignalTable
from ..signal import Signal
from ..units import ANGLE, LENGTH, NONE
from .header import AgentInfo
from .recording import Recording

#: What the simulation knows of an agent and its mind does not; only requirements may use it.
TRUTH: tuple[Signal, ...] = (
    Signal("min_clearance", 1, (LENGTH,), doc="The least distance so far from the hull to anything, but the floor."),
    Signal("true_pose", 3, (LENGTH, LENGTH, ANGLE), doc="Where the robot truly is, in the world frame."),
    Signal("collisions", 1, (NONE,), doc="How often it ran into something so far."),
    Signal("struck", 1, (NONE,), doc="How often something ran into it so far, while it stood."),
)


@dataclass(frozen=True, eq=False)
class Sample:
    """One moment of an agent.

    Attributes:
        t: When [s].
        x: Its signals in the order of its snapshots, then those of TRUTH, (size,) in SI units; NaN where invalid.
        mode: The mode that it was in.
        felt: Whether its reflexes were evaluated; False of the moment at which it was stopped.
    """

    t: float
    x: NDArray[np.float64]
    mode: str
    felt: bool = True


class Snapshots:
    """Makes samples of one agent's events.

    Args:
        agent: What the recording's header says of it.

    Raises:
        RecordingError: It says nothing of its signals.
    """

    def __init__(self, agent: AgentInfo) -> None:
        self.name = agent.name
        self._late = {s.name for s in agent.signals if s.late}
        self._table = SignalTable()
        for signal in _declared(agent):
            self._table.declare(signal)
        self._table.freeze()
        self._clearance, self._pose, self._touches = math.inf, (math.nan,) * 3, {"collision": 0, "struck": 0}
        self._mode = ""
        self._t: float | None = None
        self._waiting: list[SignalsWritten | KnowledgeChanged] = []
        self._stopped = False

    def take(self, event: Event) -> Sample | None:
        """Take one event; gives the sample that it ends."""
        if event.agent != self.name or self._stopped:
            return None
        if isinstance(event, (SignalsWritten, BodyMoved)):
            sample = self._begin(event.t)
            self._apply(event)
            return sample
        if isinstance(event, AgentStopped):
            self._stopped = True
            # In lockstep it is stopped at the beginning of a period, before its reflexes.
            return None if self._t is None else self._sample(self._t, felt=event.t > self._t)
        self._apply(event)
        return None

    def end(self) -> Sample | None:
        """The last sample of events that were cut off."""
        return None if self._stopped or self._t is None else self._sample(self._t)

    def _begin(self, t: float) -> Sample | None:
        """The sample that is over where this is a later time."""
        if self._t is not None and t <= self._t:
            return None
        sample = None if self._t is None else self._sample(self._t)
        self._t = t
        waiting, self._waiting = self._waiting, []
        for event in waiting:
            self._write(event)
        return sample

    def _sample(self, t: float, felt: bool = True) -> Sample:
        truth = (self._clearance, *self._pose, self._touches["collision"], self._touches["struck"])
        return Sample(t, np.concatenate([self._table.snapshot(t), truth]), self._mode, felt)

    def _apply(self, event: Event) -> None:
        if isinstance(event, BodyMoved):
            self._pose = event.x, event.y, event.yaw
        elif isinstance(event, Approached):
            self._clearance = event.distance
        elif isinstance(event, Touched):
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
            self._table.update(event.values, event.t if event.stamp is None else event.stamp)
        else:
            self._mode = str(event.value or "")


def environment_of(agent: AgentInfo, truth: bool = False) -> Environment:
    """The names that expressions over an agent's samples may use; those of TRUTH only where asked for.

    Raises:
        RecordingError: The recording says nothing of the agent's signals.
    """
    return Environment.packed([*_declared(agent), *(TRUTH if truth else ())])


def samples_of(recording: Recording, agent: AgentInfo) -> Iterator[Sample]:
    """The samples of one agent of a recording, in order.

    Raises:
        RecordingError: It cannot be read, or says nothing of the agent's signals.
    """
    return samples_in(recording.events(), Snapshots(agent))


def samples_in(events: Iterable[Event], snapshots: Snapshots) -> Iterator[Sample]:
    """The samples that events make."""
    for event in events:
        if (sample := snapshots.take(event)) is not None:
            yield sample
    if (sample := snapshots.end()) is not None:
        yield sample


def _declared(agent: AgentInfo) -> list[Signal]:
    if not agent.signals:
        raise RecordingError(
            f"the recording does not say which signals '{agent.name}' has: it is of an older version, or was not made "
            "by a run. Run the scenario again."
        )
    return [signal.signal() for signal in agent.signals]
