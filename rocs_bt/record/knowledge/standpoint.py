"""From where one asks about a recorded run: where its robot was at a time, and what it measured."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from ...errors import RecordingError
from ...expression import Environment
from ...geometry import Pose2
from ...knowledge import Asker
from ...signal import Signal
from ..recording import Recording
from ..snapshots import environment_of, samples_of
from .story import Story


class RecordedSignals:
    """The signals of an agent of a recording, as they were at a time.

    Args:
        environment: Where each stands in a sample.
        x: The sample; NaN where a signal was not valid.
    """

    def __init__(self, environment: Environment, x: Sequence[float]) -> None:
        self._environment = environment
        self._x = x

    @property
    def names(self) -> Collection[str]:
        """All signals."""
        return self._environment.signals.keys()

    def spec(self, name: str) -> Signal:
        """A signal's declaration."""
        return self._environment.signals[name]

    def slice_of(self, name: str) -> slice:
        """Where a signal stands in the sample."""
        start = self._environment.offsets[name]
        return slice(start, start + self.spec(name).size)

    def read(self, name: str) -> Sequence[float]:
        """The values of a signal."""
        return self._x[self.slice_of(name)]


def recorded_asker(recording: Recording, story: Story, t: float) -> tuple[Asker, RecordedSignals]:
    """The robot of a recorded run as one who asks, at a time.

    Args:
        recording: The run.
        story: What its agent knew.
        t: When [s].

    Raises:
        RecordingError: The recording says nothing of the agent, or of its signals.
    """
    info = next((agent for agent in recording.header.agents if agent.name == story.agent), None)
    if info is None:
        raise RecordingError(f"'{recording.path}' says nothing of the signals of {story.agent}.")
    environment, x = environment_of(info), [math.nan] * 0
    for sample in samples_of(recording, info):
        if sample.t > t:
            break
        x = sample.x.tolist()
    signals = RecordedSignals(environment, x or [math.nan] * environment.size)
    pose = Pose2(*signals.read("pose")) if "pose" in signals.names else Pose2(math.nan, math.nan)
    here = None if math.isnan(pose.x) else pose
    return Asker(story.agent, here, t, signals.read, story), signals
