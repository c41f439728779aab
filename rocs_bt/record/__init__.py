"""Recordings of runs: writing, reading, comparing, explaining and drawing.

This package uses recorded data only and imports no block of an agent. `simulation`, `compare`, the replay driver and
the command line import it.
"""

from ..event import TreeNode
from .diverge import WORLD_EVENTS, Divergence, compare
from .figures import write_figures
from .folder_lock import FolderLock
from .header import (
    AgentInfo,
    Beam,
    BodyInfo,
    Fan,
    GuardInfo,
    Outline,
    Place,
    RequirementInfo,
    RunHeader,
    SignalInfo,
    SubtreeSwap,
)
from .pages import page_maker, write_report
from .recorder import Recorder
from .recording import Recording
from .samples import TRUTH, environment_of, samples
from .summary import (
    AgentResult,
    Finding,
    Following,
    KnowledgeFile,
    Localisation,
    Remembered,
    SolveTime,
    Summary,
    TrackingError,
)
from .tables import event_table, signal_table
from .why import Why, explain

__all__ = [
    "TRUTH",
    "WORLD_EVENTS",
    "AgentInfo",
    "AgentResult",
    "Beam",
    "BodyInfo",
    "Divergence",
    "Fan",
    "Finding",
    "FolderLock",
    "Following",
    "GuardInfo",
    "KnowledgeFile",
    "Localisation",
    "Outline",
    "Place",
    "Recorder",
    "Recording",
    "Remembered",
    "RequirementInfo",
    "RunHeader",
    "SignalInfo",
    "SolveTime",
    "SubtreeSwap",
    "Summary",
    "TrackingError",
    "TreeNode",
    "Why",
    "compare",
    "environment_of",
    "event_table",
    "explain",
    "page_maker",
    "samples",
    "signal_table",
    "write_figures",
    "write_report",
]
