"""History of knowledge: the change log, the journal that stores it in a file, and exports."""

from .change_log import ChangeLog, Stretch, log_of
from .exchange import from_json_text, to_json_text
from .history import History, RunEntry
from .journal import Journal, JournalPast, write_state
from .load import LoadResult, load_into, persistent_part
from .state import State

__all__ = [
    "ChangeLog",
    "History",
    "Journal",
    "JournalPast",
    "LoadResult",
    "RunEntry",
    "State",
    "Stretch",
    "from_json_text",
    "load_into",
    "log_of",
    "persistent_part",
    "to_json_text",
    "write_state",
]
