"""Agents: build, connect and run the MAPE-K blocks of one robot.

Only this package imports monitors, analysers, planners, Execute and reflexes together. `simulation` and the packages
above it import this package.
"""

from .agent import Agent
from .build import Controller, build_agent
from .facts import add_facts
from .parts import AgentRuntime, Blocks, Rates, RobotDevices
from .reloadable_rules import ReloadableRules, RuleWatch
from .threaded import ThreadedRunner

__all__ = [
    "Agent",
    "AgentRuntime",
    "Blocks",
    "Controller",
    "Rates",
    "ReloadableRules",
    "RobotDevices",
    "RuleWatch",
    "ThreadedRunner",
    "add_facts",
    "build_agent",
]
