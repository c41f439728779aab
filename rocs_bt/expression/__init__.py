"""Expression language of rule guards, tree conditions and run-time monitors.

The package depends on signals and units only, so any module that reads a condition from a file may import it.
"""

from .absent import ABSENT, NO_NAME, is_absent, one_for_each_signal
from .argument_kinds import Misuse
from .environment import Environment, Forms
from .evaluator import Expression, Steady, Values, evaluate
from .kernel import kernel_missing
from .lower import lower
from .node import PLAIN, TRUTH, Kind, Node
from .operators import FUNCTIONS
from .parser import MAX_DEPTH, MAX_LENGTH, MAX_SIZE, compile_expression, parse
from .program import Program
from .quantities import blank_texts
from .reading import reading
from .requirement import Requirement, parse_requirement

__all__ = [
    "ABSENT",
    "FUNCTIONS",
    "MAX_DEPTH",
    "MAX_LENGTH",
    "MAX_SIZE",
    "NO_NAME",
    "PLAIN",
    "TRUTH",
    "Environment",
    "Expression",
    "Forms",
    "Kind",
    "Misuse",
    "Node",
    "Program",
    "Requirement",
    "Steady",
    "Values",
    "blank_texts",
    "compile_expression",
    "evaluate",
    "is_absent",
    "kernel_missing",
    "lower",
    "one_for_each_signal",
    "parse",
    "parse_requirement",
    "reading",
]
