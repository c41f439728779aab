"""History: trajectories, commands and intervals of a run for figures, as views of its tracks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from ...event import AtomicStarted, RobotPushed
from ..file.recording import Recording
from ..file.summary import Finding
from .track import Span
from .tracks import Tracks

Series = NDArray[np.float64]

_TOPICS = ("pose", "command", "stopped", "rule", "ticket", "atomic", "push")


@dataclass
class BodyHistory:
    """Trajectory of one body.

    Attributes:
        t: Times [s], shape (n,).
        pose: x, y, yaw [m, m, rad], world frame, shape (n, 3).
        wheels: Wheel linear speeds [m/s], shape (n, w); (n, 0) if not recorded.
        height: Heights of the base [m], shape (n,); (0,) if not recorded.
        tilt: Angles from the vertical [rad], shape (n,); (0,) if not recorded.
    """

    t: Series
    pose: Series
    wheels: Series
    height: Series
    tilt: Series

    @property
    def spatial(self) -> bool:
        """Whether height and tilt are recorded."""
        return len(self.height) > 0

    def speed(self, axis: str) -> Series | None:
        """Speeds along an axis of the body [m/s, rad/s], shape (n,), from the poses; None if they are too few.

        Args:
            axis: `vx`, `vy` (horizontal), `vz` (vertical) or `wz` (about the vertical).
        """
        if len(self.t) < 2 or (axis == "vz" and not self.spatial):
            return None
        x, y, yaw = self.pose.T
        ahead = yaw if axis == "vx" else yaw + 0.5 * np.pi
        if axis in ("vz", "wz"):
            speed: Series = np.gradient(self.height if axis == "vz" else np.unwrap(yaw), self.t)
        else:
            speed = np.gradient(x, self.t) * np.cos(ahead) + np.gradient(y, self.t) * np.sin(ahead)
        return speed

    def at(self, t: Series | float) -> Series:
        """Positions [m] at times, shape (m, 2), linearly interpolated; NaN if the body has no samples."""
        times = np.atleast_1d(t)
        if not len(self.t):
            return np.full((len(times), 2), np.nan)
        return np.stack([np.interp(times, self.t, self.pose[:, i]) for i in (0, 1)], axis=1)


class AgentHistory:
    """Intervals and events of one agent.

    Attributes:
        commands: Commands by actuator.
        routes: Intervals of the route that moved the robot.
        atomic: Starts of atomic actions.
        worst: Name of each requirement with a minimum margin, and the time of this margin [s].
    """

    def __init__(self, tracks: Tracks, name: str, findings: tuple[Finding, ...]) -> None:
        self.commands = tracks.curves_of(name, "command")
        self.routes: list[Span] = tracks.steps(name, "route").spans(tracks.end)
        self.atomic: list[AtomicStarted] = tracks.steps(name, "atomic").v
        self.worst = [(f.name, f.worst) for f in findings if f.margin is not None and f.worst is not None]
        self._tracks, self._name = tracks, name

    @property
    def switches(self) -> list[float]:
        """Times of the switches between the deliberative and the reactive route [s] (paper, Figure 5b)."""
        acting = [s for s in self.routes if s.value in ("deliberative", "reactive")]
        return [b.begin for a, b in pairwise(acting) if a.value != b.value]

    def reflexes(self) -> list[Span]:
        """Activations of rules, each with its rule, from its firing until its end; in the order of their beginning."""
        found = []
        for rule, track in self._tracks.steps_of(self._name, "rule").items():
            spans = track.spans(self._tracks.end)
            for (active, _), group in groupby(spans, key=lambda span: (span.value.active, span.value.fired)):
                parts = list(group)
                if active:
                    found.append(Span(parts[0].begin, parts[-1].end, rule))
        return sorted(found, key=lambda each: each.begin)

    def runs(self) -> list[Span]:
        """Intervals in which tickets were running, with their tickets, in the order of their beginning."""
        tickets = self._tracks.steps_of(self._name, "ticket").values()
        spans = [span for track in tickets for span in track.spans(self._tracks.end) if span.value.state == "RUNNING"]
        return sorted(spans, key=lambda span: span.begin)


class History:
    """Trajectories, commands and intervals of one recording.

    Attributes:
        label: Short name of the run.
        header: Header of the recording.
        bodies: Trajectories by body, in the header's order.
        agents: Histories by agent, in the header's order.
        pushes: Pushes of all robots, with and without an agent.
        end: Time of the last event [s].
    """

    def __init__(self, recording: Recording) -> None:
        tracks = Tracks.of_recording(recording, _TOPICS)
        results = {} if recording.summary is None else recording.summary.agents
        self.header, self.label, self.end = recording.header, recording.header.label, tracks.end
        names = [b.name for b in self.header.bodies]
        names += [k.agent for k, _ in tracks.items() if k.topic == "pose" and k.agent not in names]
        self.bodies = {name: _body(tracks, name) for name in names}
        self.agents = {
            a.name: AgentHistory(tracks, a.name, results[a.name].requirements if a.name in results else ())
            for a in self.header.agents
        }
        self.pushes: list[RobotPushed] = [
            push for k, _ in tracks.items() if k.topic == "push" for push in tracks.steps(*k).v
        ]


def _body(tracks: Tracks, name: str) -> BodyHistory:
    pose, wheels = (tracks.curve(name, topic) for topic in ("pose", "wheels"))
    rows = pose.rows() if pose.t else np.empty((0, 3))
    spatial = rows[:, 3:] if rows.shape[1] > 3 else np.empty((0, 3))
    cosine = np.cos(spatial[:, 1]) * np.cos(spatial[:, 2])
    return BodyHistory(
        t=np.array(pose.t, float),
        pose=rows[:, :3],
        wheels=wheels.rows() if wheels.t else np.empty((len(rows), 0)),
        height=spatial[:, 0],
        tilt=np.arccos(np.clip(cosine, -1.0, 1.0)),
    )
