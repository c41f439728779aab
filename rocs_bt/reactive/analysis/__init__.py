"""Static analysis of rules that load without errors, with an example for each finding."""

from .examine import Examined, analyse_fit, analyse_rules, examine_rules

__all__ = ["Examined", "analyse_fit", "analyse_rules", "examine_rules"]
