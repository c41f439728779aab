"""One robot's mind: builds, wires and runs its blocks. The only composer (docs/architecture.md)."""

from ..catalog import robot_drive
from .agent import Agent, Rates
from .build import Mind, build_agent
from .facts import tell_facts
from .rule_files import RuleFile, RuleWatch
from .threaded import ThreadedRunner

__all__ = [
    "Agent",
    "Mind",
    "Rates",
    "RuleFile",
    "RuleWatch",
    "ThreadedRunner",
    "build_agent",
    "robot_drive",
    "tell_facts",
]
