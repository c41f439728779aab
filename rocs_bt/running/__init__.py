"""One run of a scenario, in simulation or on hardware: agents, outcomes, metrics, requirements, files and replay.

Imported by `compare`, `check`, the command line and the pytest plugin.
"""

from ..devices.host import Host
from .metrics import Metrics
from .preflight import PreflightReport, SensorState
from .replay import replay
from .requirements import RequirementWatch, check_recorded, requirement_faults, requirements_of
from .run import Run
from .run_command import CommandSource, RunCommand
from .run_files import RECORDING, REPORT, SUMMARY
from .run_loop import LoopAgent, LoopResult, RunLoop, Stage
from .run_options import Build, LiveView, RunOptions
from .run_result import RunResult
from .simulated_stage import SimulatedStage
from .sink_thread import SinkThread
from .stop_signals import EndedAtOnce, StopSignals
from .summary import summary_of

__all__ = [
    "RECORDING",
    "REPORT",
    "SUMMARY",
    "Build",
    "CommandSource",
    "EndedAtOnce",
    "Host",
    "LiveView",
    "LoopAgent",
    "LoopResult",
    "Metrics",
    "PreflightReport",
    "RequirementWatch",
    "Run",
    "RunCommand",
    "RunLoop",
    "RunOptions",
    "RunResult",
    "SensorState",
    "SimulatedStage",
    "SinkThread",
    "Stage",
    "StopSignals",
    "check_recorded",
    "replay",
    "requirement_faults",
    "requirements_of",
    "summary_of",
]
