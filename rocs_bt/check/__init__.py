"""Checks of content files; each check reports all faults at once.

Used by the command line and by the pytest plugin.
"""

from .check import Findings, check_content
from .picture import FORMATS, draw_mission
from .rules import fitted_rules, inactive_rules
from .scenario import run_warnings

__all__ = ["FORMATS", "Findings", "check_content", "draw_mission", "fitted_rules", "inactive_rules", "run_warnings"]
