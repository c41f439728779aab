"""Scripting language of BehaviorTree.CPP: parser, and compiler to Python functions that work on a blackboard."""

from .arithmetic import Refused, truth
from .compiler import compile_condition, compile_script
from .form import Script, parse_script
from .parser import Assignment, Comparison, Conditional, Expression, Literal, Name, ScriptError, parts, walk
from .reading import script_reading

__all__ = [
    "Assignment",
    "Comparison",
    "Conditional",
    "Expression",
    "Literal",
    "Name",
    "Refused",
    "Script",
    "ScriptError",
    "compile_condition",
    "compile_script",
    "parse_script",
    "parts",
    "script_reading",
    "truth",
    "walk",
]
