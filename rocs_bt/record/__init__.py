"""What happened: recording, reading back, comparing, explaining and drawing. It draws recorded data only."""

from .diverge import WORLD_EVENTS, Divergence, compare
from .figures import write_figures
from .header import AgentInfo, Beam, BodyInfo, Outline, Place, RunHeader, TreeNode
from .recorder import Recorder
from .recording import Recording
from .report import write_report
from .why import Why, explain

__all__ = [
    "WORLD_EVENTS",
    "AgentInfo",
    "Beam",
    "BodyInfo",
    "Divergence",
    "Outline",
    "Place",
    "Recorder",
    "Recording",
    "RunHeader",
    "TreeNode",
    "Why",
    "compare",
    "explain",
    "write_figures",
    "write_report",
]
