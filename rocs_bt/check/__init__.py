"""Joins the checkers that the rooms export: every content file, all faults at once."""

from .check import Findings, check_content
from .mission import draw_mission
from .scenario import mind_doubts

__all__ = ["Findings", "check_content", "draw_mission", "mind_doubts"]
