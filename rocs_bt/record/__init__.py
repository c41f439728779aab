"""Recordings of runs: writing, reading, comparing, explaining and drawing.

This package uses recorded data only and imports no block of an agent. `simulation`, `compare`, the replay driver and
the command line import it.
"""

from .diverge import WORLD_EVENTS, Difference, Divergence, compare, first_differences
from .figures import write_figures
from .folder_lock import FolderLock
from .header import (
    AgentInfo,
    Beam,
    BodyInfo,
    Fan,
    Outline,
    Place,
    RequirementInfo,
    RunHeader,
    SensorInfo,
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
from .tracks import Tracks
from .why import Why, explain
from .why_not import WhyNot, why_not

__all__ = [
    "TRUTH",
    "WORLD_EVENTS",
    "AgentInfo",
    "AgentResult",
    "Beam",
    "BodyInfo",
    "Difference",
    "Divergence",
    "Fan",
    "Finding",
    "FolderLock",
    "Following",
    "KnowledgeFile",
    "Localisation",
    "Outline",
    "Place",
    "Recorder",
    "Recording",
    "Remembered",
    "RequirementInfo",
    "RunHeader",
    "SensorInfo",
    "SignalInfo",
    "SolveTime",
    "SubtreeSwap",
    "Summary",
    "TrackingError",
    "Tracks",
    "Why",
    "WhyNot",
    "compare",
    "environment_of",
    "event_table",
    "explain",
    "first_differences",
    "page_maker",
    "samples",
    "signal_table",
    "why_not",
    "write_figures",
    "write_report",
]
