"""History of knowledge: the change log of a run, the state at any time, and files of knowledge."""

from .change_log import ChangeLog
from .exchange import from_json_text, read_knowledge, to_json_text
from .load import LoadResult, load_into, persistent_part
from .state import GraphState

__all__ = [
    "ChangeLog",
    "GraphState",
    "LoadResult",
    "from_json_text",
    "load_into",
    "persistent_part",
    "read_knowledge",
    "to_json_text",
]
