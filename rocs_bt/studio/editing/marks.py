"""Faults of a text, with the span to underline."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ...base.errors import Fault, NameHint
from ...check import check_content

_WORD = re.compile(r"</?[\w.:-]*|[\w.:-]+|\S")


@dataclass(frozen=True)
class Mark:
    """Fault in a text.

    Attributes:
        line: Line, 1-based.
        column: Column of the first character, 1-based.
        end: Column after the last character.
        level: `error`, `warning` or `note`.
        message: One sentence: what was expected and what was found.
        hint: Advice to correct the fault, without lists of names.
        instead: Text to write instead of the span; empty if none is known.
        names: Existing names, if the fault is about an unknown one.
        file: Another file that has the fault, which this text causes; None for the text itself.
    """

    line: int
    column: int
    end: int
    level: str
    message: str
    hint: str = ""
    instead: str = ""
    names: tuple[str, ...] = ()
    file: Path | None = None


def faults(
    path: Path, text: str, *, texts: Mapping[Path, str] = MappingProxyType({}), code: bool = True
) -> tuple[Mark, ...]:
    """Faults of a content file with a text that may not be saved, in the order of the text; those of other files last.

    Args:
        path: File of the text; it need not exist.
        text: Text to check.
        texts: Texts of other open files, by path.
        code: Whether Python content of the project may run.
    """
    found = check_content([path], texts={**texts, path: text}, code=code)
    lines, own = text.split("\n"), path.resolve()
    here = [_mark(f, lines) for f in found.faults if f.file is None or f.file.resolve() == own]
    there = [
        Mark(1, 1, 1, _level(f), f"{f.file.name}:{f.line}: {f.message}", *_hint(f), file=f.file)
        for f in found.faults
        if f.file is not None and f.file.resolve() != own and not f.note
    ]
    return (*here, *there)


def _mark(fault: Fault, lines: list[str]) -> Mark:
    line = min(max(fault.line, 1), len(lines))
    text = lines[line - 1]
    column = fault.column or len(text) - len(text.lstrip()) + 1
    word = _WORD.match(text, column - 1)
    end = column + len(word[0]) if word and fault.column else max(len(text.rstrip()) + 1, column)
    if fault.line == 0:  # about the whole file
        column, end = 1, max(len(text) + 1, 2)
    return Mark(line, column, end, _level(fault), fault.message, *_hint(fault))


def _hint(fault: Fault) -> tuple[str, str, tuple[str, ...]]:
    hint = fault.hint
    return (hint.brief, hint.close, hint.names) if isinstance(hint, NameHint) else (hint, "", ())


def _level(fault: Fault) -> str:
    return "note" if fault.note else "warning" if fault.warning else "error"
