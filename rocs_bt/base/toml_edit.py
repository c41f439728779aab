"""Edits of TOML texts that keep comments, order and spacing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from .errors import Fault, InputError
from .toml_text import Key, as_toml, comment_starts, key_parts, parse_toml, value_end

_COMMENT_COLUMN = 34
_SPACE = " \t"
_MARK = re.compile(r"[ \t]*([]=])[ \t]*")  # after the last part of a key: the end of a header, or an assignment


def with_values(text: str, values: Mapping[Key, str], file: Path, comment: str) -> str:
    """Set values in a TOML text: replace those that exist, and add the others to their tables.

    Keys are paths such as `("locomotion", "lag")`; none is inside an array of tables.

    Raises:
        InputError: The text is written so that a value cannot be set; the error has the value.
    """
    for key, value in values.items():
        expected = _with(parse_toml(text, file)[0], key, value)
        text = _replaced(text, *_edit(text, key, value, comment))
        if expected is None or _parsed(text, file) != expected:
            name, assignment = ".".join(map(str, key[:-1])), _assignment(key[-1:], value)
            raise InputError(Fault(f"cannot write {assignment} into [{name}].", file, hint="Write it by hand."))
    return text


def _replaced(text: str, start: int, end: int, new: str) -> str:
    """The text with `new` in place of a span; a comment at the end of the line keeps its column where there is room."""
    rest, line_end = text[end:], _line_end(text, end)
    if comment := next((at for at in comment_starts(text) if end <= at < line_end), 0):
        body = text[end:comment].rstrip(" ")
        spaces = comment - end - len(body)
        rest = body + " " * max(spaces - len(new) + (end - start), min(spaces, 2)) + text[comment:]
    return text[:start] + new + rest


def _parsed(text: str, file: Path) -> dict[str, Any] | None:
    try:
        return parse_toml(text, file)[0]
    except InputError:
        return None


def _with(document: dict[str, Any], key: Key, value: str) -> dict[str, Any] | None:
    """The document with a value; None if it has something else than tables on the way there."""
    table = document
    for name in key[:-1]:
        if not isinstance(table := table.setdefault(str(name), {}), dict):
            return None
    table[str(key[-1])] = value
    return document


class _Assignment(NamedTuple):
    """Assignment of a value in a text."""

    key: Key
    table: Key  # key of the table header above it
    start: int
    end: int  # index after the value


def _edit(text: str, key: Key, value: str, comment: str) -> tuple[int, int, str]:
    """Edit that sets one value: the span to replace, and the text in its place."""
    headers, assignments = _items(text)
    quoted = _assignment(("x",), value).partition(" = ")[2]
    if own := next((a for a in assignments if a.key == key), None):
        return own.start, own.end, quoted
    newline = "\r\n" if "\r\n" in text else "\n"
    for n in range(len(key) - 1, 0, -1):
        table, rest = key[:n], key[n:]
        inline = next((a for a in assignments if a.key == table and text[a.start] == "{"), None)
        if inline is not None:
            inside = text[inline.start + 1 : inline.end - 1].rstrip(_SPACE)
            at = inline.start + 1 + len(inside)
            return at, inline.end - 1, f"{',' if inside.strip() else ''} {_assignment(rest, value)} "
        inside_table = [a for a in assignments if a.table == table]
        dotted = [a for a in assignments if a.key[:n] == table and len(a.table) < n]
        if table in headers:
            last = max([headers[table], *(a.end for a in inside_table)])
        elif dotted:
            last, rest = dotted[-1].end, key[len(dotted[-1].table) :]
        else:
            continue
        at = _line_end(text, last)
        at -= text.endswith("\r", 0, at)
        return at, at, newline + _line(rest, value, comment)
    header = ".".join(_assignment((name,), "").partition(" = ")[0] for name in key[:-1])
    before = "" if text.endswith("\n") or not text else newline
    lines = f"{newline}[{header}]{newline}{_line(key[-1:], value, comment)}{newline}"
    return len(text), len(text), before + lines


def _items(text: str) -> tuple[dict[Key, int], list[_Assignment]]:
    """Index after the key of each table header, and all assignments, also those in inline tables."""
    headers, assignments = dict[Key, int](), list[_Assignment]()
    table: Key = ()
    for part in key_parts(text):
        found = _MARK.match(text, part.end)
        if found is not None and found[1] == "=":
            start = found.end()
            written = text[start : value_end(text, start)]
            assignments.append(_Assignment(part.key, table, start, start + len(written.rstrip())))
        elif found is not None:
            table = part.key
            headers[table] = part.end
    return headers, assignments


def _assignment(key: Key, value: str) -> str:
    names = [as_toml({str(name): ""}).partition(" = ")[0] for name in key]
    return ".".join(names) + " = " + as_toml({"x": value}).partition(" = ")[2].rstrip("\n")


def _line(key: Key, value: str, comment: str) -> str:
    return f"{_assignment(key, value):{_COMMENT_COLUMN - 2}}  # {comment}"


def _line_end(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end
