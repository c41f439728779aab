"""Help for editors: faults, completion, descriptions, definitions and edits of the texts of content files.

The language server and the page of the studio use it. Every function takes the path of a file, a text of it that may
not be saved, and an offset into the text.
"""

from __future__ import annotations

from pathlib import Path

from ...declare import Location
from .edits import edit, insert, move, remove, set_attribute
from .elements import Element, parse
from .help import Description, Item
from .marks import Mark, faults
from .toml_help import complete_toml, define_toml, describe_toml
from .vocabulary import NodeInfo, PortInfo, vocabulary
from .xml_help import complete_xml, define_xml, describe_xml, form, keys_in

__all__ = [
    "Description",
    "Element",
    "Item",
    "Location",
    "Mark",
    "NodeInfo",
    "PortInfo",
    "complete",
    "define",
    "describe",
    "edit",
    "faults",
    "form",
    "insert",
    "keys_in",
    "move",
    "parse",
    "remove",
    "set_attribute",
    "vocabulary",
]


def complete(path: Path, text: str, at: int, *, code: bool = True) -> list[Item]:
    """Proposals for the text at an offset; empty where none is known.

    Args:
        path: File of the text.
        text: Text up to now.
        at: Offset of the cursor.
        code: Whether Python content of the project may run.
    """
    if path.suffix == ".toml":
        return complete_toml(path, text, at, code=code)
    return complete_xml(path, text, at, code=code) if path.suffix == ".xml" else []


def describe(path: Path, text: str, at: int, *, code: bool = True) -> Description | None:
    """Description of the node, port or key at an offset; None where nothing is known. Arguments as of `complete`."""
    if path.suffix == ".toml":
        return describe_toml(path, text, at, code=code)
    return describe_xml(path, text, at, code=code) if path.suffix == ".xml" else None


def define(path: Path, text: str, at: int, *, code: bool = True) -> Location | None:
    """Definition of the name at an offset; None where nothing is known. Arguments as of `complete`."""
    if path.suffix == ".toml":
        return define_toml(path, text, at, code=code)
    return define_xml(path, text, at, code=code) if path.suffix == ".xml" else None
