"""What happened: recording, reading back, comparing, explaining and drawing.

It draws recorded data only and knows no block. Imported by `simulation`, `compare`, the driver that
replays, and the command line.
"""

from .atomic_file import write_whole
from .diverge import WORLD_EVENTS, Divergence, compare
from .figures import write_figures
from .header import AgentInfo, Beam, BodyInfo, Fan, Outline, Place, RequirementInfo, RunHeader, SignalInfo, TreeNode
from .recorder import Recorder
from .recording import Recording
from .report import write_report
from .snapshots import TRUTH, Sample, Snapshots, environment_of, samples_of
from .why import Why, explain

__all__ = [
    "TRUTH",
    "WORLD_EVENTS",
    "AgentInfo",
    "Beam",
    "BodyInfo",
    "Divergence",
    "Fan",
    "Outline",
    "Place",
    "Recorder",
    "Recording",
    "RequirementInfo",
    "RunHeader",
    "Sample",
    "SignalInfo",
    "Snapshots",
    "TreeNode",
    "Why",
    "compare",
    "environment_of",
    "explain",
    "samples_of",
    "write_figures",
    "write_report",
    "write_whole",
]
