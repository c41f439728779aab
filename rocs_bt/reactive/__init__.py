"""Reflex route: rules, reactive models in Python, and the reflex arc that runs their actions (paper, 4.2).

Only `agent` and the packages above it import this package.
"""

from .arguments import rule_misfits
from .backend import Backend, Machine, Steps
from .include import included_files
from .kernel_backend import choose_backend
from .reactive_model import ReactiveModel, Reflex
from .reflex_arc import ReflexArc
from .rule import Argument, InactiveRule, OnInvalid, Rule, RuleSet, RuleTest
from .rule_file import load_rules, read_rules, required_signals
from .rule_model import RuleModel
from .rule_table import RuleTable, lower_rules
from .rule_test import RuleTestResult, add_test_files, run_tests, tested_file
from .threshold import Override

__all__ = [
    "Argument",
    "Backend",
    "InactiveRule",
    "Machine",
    "OnInvalid",
    "Override",
    "ReactiveModel",
    "Reflex",
    "ReflexArc",
    "Rule",
    "RuleModel",
    "RuleSet",
    "RuleTable",
    "RuleTest",
    "RuleTestResult",
    "Steps",
    "add_test_files",
    "choose_backend",
    "included_files",
    "load_rules",
    "lower_rules",
    "read_rules",
    "required_signals",
    "rule_misfits",
    "run_tests",
    "tested_file",
]
