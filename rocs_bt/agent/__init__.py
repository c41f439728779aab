"""One robot's MAPE-K loop: builds, connects and runs its blocks.

It is the only composer, so it alone imports monitors, analysers, planners, Execute and reflexes together. `simulation`
and the layers above import it.
"""

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
