"""The monitors that robot.toml may name."""

from __future__ import annotations

from collections.abc import Mapping

from .monitor import Monitor
from .peer_monitor import PeerMonitor
from .pose_monitor import PoseMonitor
from .range_monitor import RangeMonitor
from .wheel_monitor import WheelMonitor

MONITORS: Mapping[str, type[Monitor]] = {m.__name__: m for m in (PeerMonitor, PoseMonitor, RangeMonitor, WheelMonitor)}
