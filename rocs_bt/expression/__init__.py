"""The one expression language of rule guards, tree conditions and run-time monitors."""

from .compiler import Expression, compile_expression, compile_node, joint_function
from .environment import Environment
from .functions import FUNCTIONS
from .interpreter import evaluate
from .kind import PLAIN, TRUTH, Kind
from .node import Node
from .parser import MAX_DEPTH, MAX_LENGTH, MAX_SIZE, parse
from .reading import reading

__all__ = [
    "FUNCTIONS",
    "MAX_DEPTH",
    "MAX_LENGTH",
    "MAX_SIZE",
    "PLAIN",
    "TRUTH",
    "Environment",
    "Expression",
    "Kind",
    "Node",
    "compile_expression",
    "compile_node",
    "evaluate",
    "joint_function",
    "parse",
    "reading",
]
