"""M: monitors read sensors, interpret what they say, write signals to Knowledge and publish them (paper, 4.2)."""

from .monitor import Monitor, Watched
from .peer_monitor import PeerMonitor
from .pose_monitor import PoseMonitor
from .range_monitor import RangeMonitor
from .table import MONITORS
from .wheel_monitor import WheelMonitor

__all__ = ["MONITORS", "Monitor", "PeerMonitor", "PoseMonitor", "RangeMonitor", "Watched", "WheelMonitor"]
