"""Checks of content files; each check reports all faults at once.

Used by the command line and by the pytest plugin.
"""

from .check import Findings, check_content, check_run, check_scenario
from .mission import mission_notes
from .picture import FORMATS, draw_mission
from .rules import fitted_rules, inactive_rules

__all__ = [
    "FORMATS",
    "Findings",
    "check_content",
    "check_run",
    "check_scenario",
    "draw_mission",
    "fitted_rules",
    "inactive_rules",
    "mission_notes",
]
