"""One run of a scenario, in simulation or on hardware: agents, outcomes, metrics, requirements, files and replay.

Imported by `compare`, `check`, the command line and the pytest plugin.
"""

from ..drivers.host import Host
from .command import Control, RunCommand
from .episode import Episode, Result
from .hardware import drive_robots
from .judge_panel import EpisodeAgent
from .metrics import Metrics
from .options import MODES, Build, LiveView, RunChanges, RunOptions
from .preflight import PreflightReport, SensorState
from .replay import replay
from .requirements import RequirementWatch, check_recorded, requirement_faults, requirements_of
from .run_files import RECORDING, REPORT, SUMMARY
from .run_result import RunResult
from .simulate import simulate
from .sink_thread import SinkThread
from .stop_signals import EndedAtOnce, StopSignals
from .summary import summary_of
from .swaps import read_swap

__all__ = [
    "MODES",
    "RECORDING",
    "REPORT",
    "SUMMARY",
    "Build",
    "Control",
    "EndedAtOnce",
    "Episode",
    "EpisodeAgent",
    "Host",
    "LiveView",
    "Metrics",
    "PreflightReport",
    "RequirementWatch",
    "Result",
    "RunChanges",
    "RunCommand",
    "RunOptions",
    "RunResult",
    "SensorState",
    "SinkThread",
    "StopSignals",
    "check_recorded",
    "drive_robots",
    "read_swap",
    "replay",
    "requirement_faults",
    "requirements_of",
    "simulate",
    "summary_of",
]
