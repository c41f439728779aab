"""Behaviour trees, reflex rules and a shared knowledge graph for mobile robots (the RoCS architecture, MAPE-K).

Every public name is loaded when it is first used, so `import rocs_bt` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from .action import Action, AtomicAction, Failure, MacroAction, Progress, Reason
    from .agent import Agent
    from .analyze import Analyze
    from .catalog import Catalog
    from .clock import Clock, SimulatedClock, WallClock
    from .device import Actuator, Reading, Sensor
    from .errors import InputError, RocsError
    from .event import Change
    from .execute import Execute
    from .geometry import Pose2, Twist2
    from .knowledge import Knowledge
    from .monitor import Monitor
    from .pipeline import Pipeline, Priority
    from .plan import Mission, Plan
    from .reactive import ReactiveModel
    from .signal import Signal
    from .simulation import run


_HOMES = {
    "Action": "action",
    "Actuator": "device",
    "Agent": "agent",
    "Analyze": "analyze",
    "AtomicAction": "action",
    "Catalog": "catalog",
    "Change": "event",
    "Clock": "clock",
    "Execute": "execute",
    "Failure": "action",
    "InputError": "errors",
    "Knowledge": "knowledge",
    "MacroAction": "action",
    "Mission": "plan",
    "Monitor": "monitor",
    "Pipeline": "pipeline",
    "Plan": "plan",
    "Pose2": "geometry",
    "Priority": "pipeline",
    "Progress": "action",
    "ReactiveModel": "reactive",
    "Reading": "device",
    "Reason": "action",
    "RocsError": "errors",
    "Sensor": "device",
    "Signal": "signal",
    "SimulatedClock": "clock",
    "Twist2": "geometry",
    "WallClock": "clock",
    "run": "simulation",
}

__all__ = [
    "Action",
    "Actuator",
    "Agent",
    "Analyze",
    "AtomicAction",
    "Catalog",
    "Change",
    "Clock",
    "Execute",
    "Failure",
    "InputError",
    "Knowledge",
    "MacroAction",
    "Mission",
    "Monitor",
    "Pipeline",
    "Plan",
    "Pose2",
    "Priority",
    "Progress",
    "ReactiveModel",
    "Reading",
    "Reason",
    "RocsError",
    "Sensor",
    "Signal",
    "SimulatedClock",
    "Twist2",
    "WallClock",
    "run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rocs_bt' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value  # the next use finds it at once
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
