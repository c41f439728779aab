"""Joins the checkers that the folders export: every content file, all faults at once.

Imported by the command line and by the pytest plugin.
"""

from .check import Findings, check_content
from .picture import FORMATS, draw_mission
from .rules import fitted_rules
from .scenario import mind_doubts

__all__ = ["FORMATS", "Findings", "check_content", "draw_mission", "fitted_rules", "mind_doubts"]
