"""The monitors that robot.toml may name."""

from __future__ import annotations

from collections.abc import Mapping

from .fix_monitor import FixMonitor
from .message_monitor import MessageMonitor
from .monitor import Monitor
from .odometry_monitor import OdometryMonitor
from .peer_monitor import PeerMonitor
from .pose_monitor import PoseMonitor
from .range_monitor import RangeMonitor
from .scan_monitor import ScanMonitor
from .surround_monitor import SurroundMonitor
from .wheel_monitor import WheelMonitor

_SHIPPED = (
    FixMonitor,
    MessageMonitor,
    OdometryMonitor,
    PeerMonitor,
    PoseMonitor,
    RangeMonitor,
    ScanMonitor,
    SurroundMonitor,
    WheelMonitor,
)

MONITORS: Mapping[str, type[Monitor]] = {m.__name__: m for m in _SHIPPED}
