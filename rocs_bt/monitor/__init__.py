"""Monitor block of MAPE-K: monitors read sensors, write signals to Knowledge and publish them (paper, 4.2).

Only `agent` and the packages above it import this package.
"""

from collections.abc import Mapping

from .battery_monitor import BatteryMonitor
from .message_monitor import MessageMonitor
from .monitor import Monitor, MonitoredSensor
from .motion_monitor import MotionMonitor
from .odometry_monitor import OdometryMonitor
from .peer_monitor import PeerMonitor
from .pose_monitor import FixMonitor, PoseMonitor
from .range_monitor import RangeMonitor
from .scan_monitor import ScanMonitor
from .wheel_monitor import WheelMonitor

__all__ = [
    "MONITORS",
    "BatteryMonitor",
    "FixMonitor",
    "MessageMonitor",
    "Monitor",
    "MonitoredSensor",
    "MotionMonitor",
    "OdometryMonitor",
    "PeerMonitor",
    "PoseMonitor",
    "RangeMonitor",
    "ScanMonitor",
    "WheelMonitor",
]

_SHIPPED = (
    BatteryMonitor,
    FixMonitor,
    MessageMonitor,
    MotionMonitor,
    OdometryMonitor,
    PeerMonitor,
    PoseMonitor,
    RangeMonitor,
    ScanMonitor,
    WheelMonitor,
)

MONITORS: Mapping[str, type[Monitor]] = {m.__name__: m for m in _SHIPPED}
"""Monitors available in robot.toml, keyed by class name."""
