"""PeerMonitor: tags, ranges and bearings of the other robots in view."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

from ..base.signal import Signal
from ..base.units import ANGLE, LENGTH, NONE, Bounds
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .monitor import Monitor

TAGS = 1e6
"""Largest plausible tag, which is the number that identifies a robot."""


class PeerMonitor(Monitor):
    """Writes `peer_tag`, `peer_range` [m] and `peer_bearing` [rad, left positive] from a robot sensor, nearest first.

    An empty slot has tag 0, range +inf and bearing 0, so `min(peer_range) < 0.5 m` is a valid guard for any rule. The
    tag of each robot is the attribute `tag` of its `peer` node in Knowledge.

    Attributes:
        max_peers: Maximum number of robots that the sensor reports at once.
    """

    max_peers: Annotated[int, Bounds(1)]

    def signals(self) -> Sequence[Signal]:
        size, age = self.max_peers, self.max_age
        return [
            Signal("peer_tag", size, (NONE,), (0.0, TAGS), age, "Tag of the robot in each slot; 0 if empty."),
            Signal("peer_range", size, (LENGTH,), (0.0, math.inf), age, "Range of the robot; +inf if empty."),
            Signal("peer_bearing", size, (ANGLE,), (-math.pi, math.pi), age, "Bearing of the robot, left positive."),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.monitored[0].sensor.name: 3 * self.max_peers}

    def varies(self, sensor: str) -> bool:
        """Whether a robot is in view and a wheel turns; an empty view may repeat."""
        return super().varies(sensor) and bool(self.knowledge.signals.view("peer_tag")[0])

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        values = next(iter(readings.values())).values
        return {"peer_tag": values[0::3], "peer_range": values[1::3], "peer_bearing": values[2::3]}
