"""Behaviour trees, reflex rules and a shared knowledge graph for mobile robots (RoCS architecture, MAPE-K).

Public names are loaded on first use, so `import rocs_bt` is fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .base.version import __version__ as __version__

if TYPE_CHECKING:
    from ._run import drive, report, run
    from .agent import Agent, Rates, build_agent
    from .analyze import Analyze
    from .base.clock import Clock, SimulatedClock, WallClock
    from .base.errors import DeviceError, Fault, InputError, KnowledgeError, RocsError
    from .base.geometry import Pose2, Pose3, Twist2, Twist3
    from .base.signal import Signal
    from .base.units import (
        Count,
        Joules,
        Kilograms,
        Metres,
        MetresPerSecond,
        MetresPerSecondSquared,
        PositiveCount,
        PositiveMetres,
        PositiveMetresPerSecond,
        PositiveRadians,
        PositiveRadiansPerSecond,
        PositiveSeconds,
        Radians,
        RadiansPerSecond,
        Seconds,
        Watts,
    )
    from .catalog import Catalog
    from .compare import Comparison
    from .compare.run_sweep import sweep
    from .event import Change, Event, ListSink
    from .execute import Execute
    from .interfaces.action import Action, AtomicAction, Failure, MacroAction, Progress, Reason
    from .interfaces.device import Actuator, Reading, Sensor
    from .interfaces.pipeline import Pipeline, Priority
    from .knowledge import Knowledge
    from .monitor import Monitor
    from .plan import Mission, Plan
    from .reactive import ReactiveModel
    from .record import AgentResult, Recording, Summary
    from .running import RunOptions, RunResult
    from .running.replay import replay


_NAMES = {
    "_run": "drive report run",
    "agent": "Agent Rates build_agent",
    "analyze": "Analyze",
    "base.clock": "Clock SimulatedClock WallClock",
    "base.errors": "DeviceError Fault InputError KnowledgeError RocsError",
    "base.geometry": "Pose2 Pose3 Twist2 Twist3",
    "base.signal": "Signal",
    "base.units": (
        "Count Joules Kilograms Metres MetresPerSecond MetresPerSecondSquared PositiveCount PositiveMetres "
        "PositiveMetresPerSecond PositiveRadians PositiveRadiansPerSecond PositiveSeconds Radians "
        "RadiansPerSecond Seconds Watts"
    ),
    "catalog": "Catalog",
    "compare": "Comparison sweep",
    "event": "Change Event ListSink",
    "execute": "Execute",
    "interfaces.action": "Action AtomicAction Failure MacroAction Progress Reason",
    "interfaces.device": "Actuator Reading Sensor",
    "interfaces.pipeline": "Pipeline Priority",
    "knowledge": "Knowledge",
    "monitor": "Monitor",
    "plan": "Mission Plan",
    "reactive": "ReactiveModel",
    "record": "AgentResult Recording Summary",
    "running": "RunOptions RunResult replay",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}

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
    "Count",
    "DeviceError",
    "Event",
    "Execute",
    "Failure",
    "Fault",
    "InputError",
    "Joules",
    "Kilograms",
    "Knowledge",
    "KnowledgeError",
    "ListSink",
    "MacroAction",
    "Metres",
    "MetresPerSecond",
    "MetresPerSecondSquared",
    "Mission",
    "Monitor",
    "Pipeline",
    "Plan",
    "Pose2",
    "Pose3",
    "PositiveCount",
    "PositiveMetres",
    "PositiveMetresPerSecond",
    "PositiveRadians",
    "PositiveRadiansPerSecond",
    "PositiveSeconds",
    "Priority",
    "Progress",
    "Radians",
    "RadiansPerSecond",
    "Rates",
    "ReactiveModel",
    "Reading",
    "Reason",
    "Recording",
    "RocsError",
    "RunOptions",
    "RunResult",
    "Seconds",
    "Sensor",
    "Signal",
    "SimulatedClock",
    "Summary",
    "Twist2",
    "Twist3",
    "WallClock",
    "Watts",
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
