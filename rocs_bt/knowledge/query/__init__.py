"""Queries: questions to the graph in one small typed language, compiled once (docs/knowledge.md)."""

from .compile import compile_query
from .context import QueryContext
from .find import Find, find
from .parameter import Parameter, read_parameters
from .query import Answers, Query

__all__ = ["Answers", "Find", "Parameter", "Query", "QueryContext", "compile_query", "find", "read_parameters"]
