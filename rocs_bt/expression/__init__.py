"""Expression language of rule guards, tree conditions and run-time monitors.

The package depends on signals and units only, so any module that reads a condition from a file may import it.
"""

from .absent import ABSENT, NO_NAME, is_absent, one_for_each_signal
from .compiler import Expression, Values, compile_expression, compile_node, compile_plain
from .environment import Environment, Forms
from .functions import FUNCTIONS, Misuse
from .interpreter import evaluate
from .lower import lower
from .node import PLAIN, TRUTH, Kind, Node
from .parser import MAX_DEPTH, MAX_LENGTH, MAX_SIZE, parse
from .program import Op, Program
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
    "Op",
    "Program",
    "Requirement",
    "Values",
    "blank_texts",
    "compile_expression",
    "compile_node",
    "compile_plain",
    "evaluate",
    "is_absent",
    "lower",
    "one_for_each_signal",
    "parse",
    "parse_requirement",
    "reading",
]
