"""What was known when: a journal that survives the process, the history read from it, and files for others."""

from .exchange import from_json_text, to_json_text
from .glance import Glance
from .graphml import from_graphml, to_graphml
from .history import History, RunEntry, Stretch
from .journal import Journal, write_state
from .load import Loaded, lasting, load_into
from .past import JournalPast
from .state import State

__all__ = [
    "Glance",
    "History",
    "Journal",
    "JournalPast",
    "Loaded",
    "RunEntry",
    "State",
    "Stretch",
    "from_graphml",
    "from_json_text",
    "lasting",
    "load_into",
    "to_graphml",
    "to_json_text",
    "write_state",
]
