"""Behaviour trees, reflex rules and a shared knowledge graph for mobile robots (RoCS architecture, MAPE-K).

Public names are loaded on first use, so `import rocs_bt` is fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from ._run import drive, report, run
    from .action import Action, AtomicAction, Failure, MacroAction, Progress, Reason
    from .agent import Agent, Rates, build_agent
    from .analyze import Analyze
    from .catalog import Catalog
    from .clock import Clock, SimulatedClock, WallClock
    from .compare import Comparison
    from .compare.run_sweep import sweep
    from .device import Actuator, Reading, Sensor
    from .errors import InputError, RocsError
    from .event import Change, Event, ListSink
    from .execute import Execute
    from .geometry import Pose2, Pose3, Twist2, Twist3
    from .knowledge import Knowledge
    from .monitor import Monitor
    from .pipeline import Pipeline, Priority
    from .plan import Mission, Plan
    from .reactive import ReactiveModel
    from .record import AgentResult, Recording, Summary
    from .running import RunOptions, RunResult
    from .running.replay import replay
    from .signal import Signal


_HOMES = {
    "Action": "action",
    "Actuator": "device",
    "Agent": "agent",
    "AgentResult": "record",
    "Analyze": "analyze",
    "AtomicAction": "action",
    "Catalog": "catalog",
    "Change": "event",
    "Clock": "clock",
    "Comparison": "compare",
    "Event": "event",
    "Execute": "execute",
    "Failure": "action",
    "InputError": "errors",
    "Knowledge": "knowledge",
    "ListSink": "event",
    "MacroAction": "action",
    "Mission": "plan",
    "Monitor": "monitor",
    "Pipeline": "pipeline",
    "Plan": "plan",
    "Pose2": "geometry",
    "Pose3": "geometry",
    "Priority": "pipeline",
    "Progress": "action",
    "Rates": "agent",
    "ReactiveModel": "reactive",
    "Reading": "device",
    "Reason": "action",
    "Recording": "record",
    "RocsError": "errors",
    "RunOptions": "running",
    "RunResult": "running",
    "Sensor": "device",
    "Signal": "signal",
    "SimulatedClock": "clock",
    "Summary": "record",
    "Twist2": "geometry",
    "Twist3": "geometry",
    "WallClock": "clock",
    "build_agent": "agent",
    "drive": "_run",
    "replay": "running",
    "report": "_run",
    "run": "_run",
    "sweep": "compare",
}

__all__ = [
    "Action",
    "Actuator",
    "Agent",
    "AgentResult",
    "Analyze",
    "AtomicAction",
    "Catalog",
    "Change",
    "Clock",
    "Comparison",
    "Event",
    "Execute",
    "Failure",
    "InputError",
    "Knowledge",
    "ListSink",
    "MacroAction",
    "Mission",
    "Monitor",
    "Pipeline",
    "Plan",
    "Pose2",
    "Pose3",
    "Priority",
    "Progress",
    "Rates",
    "ReactiveModel",
    "Reading",
    "Reason",
    "Recording",
    "RocsError",
    "RunOptions",
    "RunResult",
    "Sensor",
    "Signal",
    "SimulatedClock",
    "Summary",
    "Twist2",
    "Twist3",
    "WallClock",
    "build_agent",
    "drive",
    "replay",
    "report",
    "run",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rocs_bt' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value  # later uses do not call this function
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
