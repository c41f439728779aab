"""Static checks: what is wrong with rules that load, with an example for each finding."""

from .examine import analyse_fit, analyse_rules, examine_fit, examine_rules

__all__ = ["analyse_fit", "analyse_rules", "examine_fit", "examine_rules"]
