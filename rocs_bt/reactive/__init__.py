"""The reflex route: rules, whoever else may ask for a reflex, and the arc that acts on them."""

from .arc import ReflexArc
from .reactive_model import ReactiveModel, Reflex
from .rule import Argument, OnInvalid, Rule, RuleSet
from .rule_file import check_rules, load_rules
from .rule_model import RuleModel

__all__ = [
    "Argument",
    "OnInvalid",
    "ReactiveModel",
    "Reflex",
    "ReflexArc",
    "Rule",
    "RuleModel",
    "RuleSet",
    "check_rules",
    "load_rules",
]
