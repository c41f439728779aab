"""Samples of an agent's signals in each control period, looked up in the tracks of a run.

Values are not interpolated. As in a running agent, a signal keeps its value until it is written again or exceeds its
`max_age`, and values of an analyser are read from the next period on. In lockstep the samples are equal, bit by bit,
to those on which the reflexes were evaluated. In threaded mode there is one sample at each time of a write; samples may
differ from the original ones because of the order of threads.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ...base.errors import RecordingError
from ...base.signal import Signal
from ...base.units import ANGLE, LENGTH, NONE
from ...expression import Environment
from ..file.header import AgentInfo, SignalInfo
from .track import Curve
from .tracks import Tracks

Numbers = NDArray[np.float64]

_SLACK = 5e-7  # [s] rounding of times, as of the signals of an agent

#: Ground-truth signals from the simulation, unknown to the agent; only requirements may use them.
TRUTH: tuple[Signal, ...] = (
    Signal("min_clearance", 1, (LENGTH,), doc="Minimum distance so far from the hull to any geom but the floor."),
    Signal("true_pose", 3, (LENGTH, LENGTH, ANGLE), doc="Ground-truth pose, world frame."),
    Signal("true_height", 1, (LENGTH,), doc="Ground-truth height of the base; invalid for robots on wheels."),
    Signal("true_tilt", 1, (ANGLE,), doc="Ground-truth angle from the vertical; invalid for robots on wheels."),
    Signal("collisions", 1, (NONE,), doc="Number of collisions caused so far."),
    Signal("struck", 1, (NONE,), doc="Number of contacts so far that its own motion did not cause."),
)

SAMPLE_TOPICS = ("pose", "signal", "truth", "stopped")
"""Topics of tracks from which samples are made; only `newest` needs the truth."""


def samples(
    tracks: Tracks, agent: AgentInfo, after: float = -math.inf, before: float = math.inf
) -> tuple[list[float], Numbers]:
    """Times of an agent's control periods, and all of its signals then, shape (n, size); NaN for what is invalid.

    Args:
        tracks: Tracks of the run.
        agent: The agent.
        after: Time after which the samples begin [s].
        before: Time before which they end [s].
    """
    curves = tracks.curves_of(agent.name, "signal")
    stop, seen = stopped(tracks, agent.name), [*curves.values(), tracks.curve(agent.name, "pose")]
    new = (curve.t[bisect_right(curve.t, after) : bisect_left(curve.t, before)] for curve in seen)
    times = sorted({t for part in new for t in part if t <= stop})
    columns = [_column(curves.get(signal.name), times, signal) for signal in agent.signals] if times else []
    size = sum(signal.size for signal in agent.signals)
    return times, np.hstack(columns) if columns else np.empty((len(times), size))


def stopped(tracks: Tracks, agent: str) -> float:
    """Time at which an agent was stopped [s]; from then on it evaluates no reflexes. Infinite if it was not."""
    return next(iter(tracks.steps(agent, "stopped").t), math.inf)


def modes(tracks: Tracks, agent: str, times: Sequence[float]) -> list[str]:
    """Mode of an agent in control periods; a change counts from the next period on."""
    track = tracks.steps(agent, "fact", f"{agent}\nmode")
    found = (bisect_left(track.t, t) - 1 for t in times)
    return [str(track.v[i] or "") if i >= 0 else "" for i in found]


class Newest:
    """Newest sample of an agent while its run goes on, with the signals of TRUTH.

    Signals that are not in `names` are NaN.

    Raises:
        RecordingError: The header does not declare the agent's signals.
    """

    def __init__(self, tracks: Tracks, agent: AgentInfo, names: Collection[str]) -> None:
        environment = environment_of(agent, truth=True)
        self._tracks, self._agent, self._size = tracks, agent.name, environment.size
        self._signals = [(environment.offsets[s.name], s) for s in agent.signals if s.name in names]
        self._truth = environment.offsets["min_clearance"]

    def at(self, t: float) -> Numbers:
        """The sample of the period that began at a time [s], SI units, shape (size,)."""
        x = np.full(self._size, math.nan)
        for start, signal in self._signals:
            curve = self._tracks.curve(self._agent, "signal", signal.name)
            if curve.width == signal.size:
                x[start : start + signal.size] = _newest(curve, t, signal)
        tracks, agent = self._tracks, self._agent
        clearance, *touches = (
            tracks.steps(agent, "truth", name).v for name in ("min_clearance", "collision", "struck")
        )
        pose = tracks.curve(agent, "pose")
        x[self._truth] = clearance[-1] if clearance else math.inf
        if pose.t:
            row = pose.data[-pose.width :]
            x[self._truth + 1 : self._truth + 4] = row[:3]
            if pose.width > 3:
                x[self._truth + 4 : self._truth + 6] = row[3], _tilt(row[4], row[5])
        x[-2:] = [counts[-1] if counts else 0 for counts in touches]
        return x


def environment_of(agent: AgentInfo, truth: bool = False) -> Environment:
    """Names available to expressions over an agent's samples.

    Args:
        agent: Agent in the header of the recording.
        truth: Whether to include the signals of TRUTH.

    Raises:
        RecordingError: The header does not declare the agent's signals.
    """
    return Environment.packed([*_declared(agent), *(TRUTH if truth else ())])


def _newest(curve: Curve, t: float, signal: SignalInfo) -> Numbers:
    """Values of a signal in the newest period, shape (size,)."""
    i = len(curve.t) - 1
    while signal.late and i >= 0 and curve.t[i] >= t:
        i -= 1
    if i < 0 or curve.stamp(i) + curve.max_age + _SLACK < t:
        return np.full(signal.size, math.nan)
    return _bounded(np.array(curve.data[i * curve.width : (i + 1) * curve.width]), signal)


def _column(curve: Curve | None, times: Sequence[float], signal: SignalInfo) -> Numbers:
    """Values of a signal at times, shape (n, size)."""
    unknown = np.full((len(times), signal.size), np.nan)
    if curve is None or curve.width != signal.size:
        return unknown
    first = max(0, bisect_left(curve.t, times[0]) - 1)
    t, rows = np.array(curve.t[first:]), curve.rows(first)
    if not len(t):
        return unknown
    at = np.searchsorted(t, times, side="left" if signal.late else "right") - 1
    stamps = t if curve.stamps is None else np.array(curve.stamps[first:])
    known = (at >= 0) & (stamps[at] + curve.max_age + _SLACK >= np.array(times))
    return np.where(known[:, None], _bounded(rows, signal)[at], np.nan)


def _bounded(values: Numbers, signal: SignalInfo) -> Numbers:
    """Values with NaN for those out of the signal's bounds."""
    if signal.low is not None:
        values = np.where(values < signal.low, np.nan, values)
    return values if signal.high is None else np.where(values > signal.high, np.nan, values)


def _tilt(roll: float, pitch: float) -> float:
    return math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))


def _declared(agent: AgentInfo) -> list[Signal]:
    if not agent.signals:
        raise RecordingError(
            f"the recording does not declare the signals of '{agent.name}': it has an older version or was not made by "
            "a run. Run the scenario again."
        )
    return [signal.signal() for signal in agent.signals]
