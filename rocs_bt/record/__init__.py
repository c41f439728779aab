"""Recordings of runs: writing, reading, comparing, explaining and drawing.

This package uses recorded data only and imports no block of an agent. `simulation`, `compare`, the replay driver and
the command line import it.
"""

from .explanation.diverge import WORLD_EVENTS, Difference, Divergence, compare, first_differences
from .explanation.why import Why, explain
from .explanation.why_not import WhyNot, why_not
from .figures import write_figures
from .file.folder_lock import FolderLock
from .file.header import (
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
from .file.recorder import Recorder
from .file.recording import Recording
from .file.summary import (
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
from .fold.arrays import event_table, signal_table
from .fold.samples import TRUTH, environment_of, samples
from .fold.tracks import Tracks
from .pages import page_maker, write_report

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
