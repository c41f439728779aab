"""The values that the nodes of a tree share."""

from .board import Board, type_name
from .convert import Enums, from_string, to_string
from .entry import Entry

__all__ = ["Board", "Entry", "Enums", "from_string", "to_string", "type_name"]
