"""Static analysis of rules that load without errors, with an example for each finding."""

from .examine import analyse_fit, analyse_rules, examine_rules

__all__ = ["analyse_fit", "analyse_rules", "examine_rules"]
