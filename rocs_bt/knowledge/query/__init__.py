"""Queries: questions to the graph in one small typed language, compiled once (docs/knowledge.md)."""

from .asker import Asker
from .compile import compile_query
from .find import Find, find
from .parameter import Parameter, read_parameters
from .query import Answers, Query

__all__ = ["Answers", "Asker", "Find", "Parameter", "Query", "compile_query", "find", "read_parameters"]
