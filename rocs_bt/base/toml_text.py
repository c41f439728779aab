"""TOML text: a parser that gives the position of each key, and a writer.

`tomllib`, which parses the values, reports no positions. Its run time grows with the square of the number of parts of a
dotted key. Keys, nesting and integers are therefore limited, so that any file is read or refused in a time proportional
to its size.
"""

from __future__ import annotations

import functools
import itertools
import json
import math
import re
import tomllib
from collections.abc import Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from .errors import Fault, InputError

Key = tuple[str | int, ...]
"""Path of a value from the root: names of tables, indices into arrays of tables, and the name of the value."""

MAX_PARTS = 100
"""Maximum number of parts of a dotted key."""

MAX_DEPTH = 100
"""Maximum nesting depth of tables and lists."""

_SHORT = 100_000  # maximum length of a text to be cached [characters]
_INTEGERS = range(-(2**63), 2**63)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_PART = re.compile(r"""[A-Za-z0-9_-]+|"[^"]*"|'[^']*'""")
_KEY_PART = re.compile(r"""[ \t]*([A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*')[ \t]*""")
_BLANK = re.compile(r"(?:\s|#[^\n]*)*")
_BARE_VALUE = re.compile(r"[^,\]}#\n]+")
_LONG_NUMBER = re.compile(r"(?<![0-9_])[0-9_]{4301,}")  # digits that int() refuses
_STRING = re.compile(r"""'[^']*'|"(?:[^"\\]|\\.)*\"""")
_MARK = re.compile(r"""[#"'\[\]{}]""")  # characters that change the parsing of the rest of a line


def parse_toml(text: str, file: Path) -> tuple[dict[str, Any], dict[Key, tuple[int, int]]]:
    """Parse a TOML text: data; line and column of each header, and of each key at the beginning of a line.

    Raises:
        InputError: The text is not valid TOML, or exceeds a limit of this module.
    """
    if len(text) > _SHORT:
        return _parse(text, file)
    data, positions = _parse_short(text, file)
    return _copied(data), dict(positions)


def _parse(text: str, file: Path) -> tuple[dict[str, Any], dict[Key, tuple[int, int]]]:
    lines = list(_lines(text))
    _refuse_long_keys(lines, file)
    _refuse_deep(lines, file)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        line, column = (int(found[1]), int(found[2])) if found else (len(text.splitlines()), 0)
        message = re.sub(r" \(at .*\)$", "", str(error))
        raise InputError(Fault(f"not valid TOML: {message}.", file, line, column)) from error
    except ValueError as error:  # int() refuses thousands of digits
        number = _LONG_NUMBER.search(text)
        at = 0 if number is None else number.start()
        line, column = text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)
        raise InputError(_not_64_bits(file, line, column)) from error
    positions = _positions(lines)
    _refuse_values(data, positions, file)
    return data, positions


_parse_short = functools.lru_cache(maxsize=256)(_parse)  # a check reads a robot's file once for each use of the robot


def _copied(value: Any) -> Any:
    """Deep copy of tables and lists."""
    if isinstance(value, dict):
        return {name: _copied(each) for name, each in value.items()}
    return [_copied(each) for each in value] if isinstance(value, list) else value


def as_toml(document: Mapping[str, Any], levels: int = 0) -> str:
    """Write a document as TOML text: first the keys of the root, then lists of tables as `[[name]]`, without None.

    Args:
        document: Data of the document.
        levels: Number of levels of tables that are written as `[name]`; deeper ones are written in a line.
    """
    arrays = {name: value for name, value in document.items() if are_tables(value)}
    lines = [*_sections({name: value for name, value in document.items() if name not in arrays}, "", levels)]
    for name, each in arrays.items():
        for table in each:
            lines += ["", f"[[{_as_key(name)}]]", *_assignments(table)]
    return "\n".join([*lines, ""])


def _sections(table: Mapping[str, Any], path: str, levels: int) -> Iterator[str]:
    inner = {name: value for name, value in table.items() if levels and isinstance(value, Mapping)}
    own = _assignments({name: value for name, value in table.items() if name not in inner})
    yield from ["", f"[{path}]"] if path and (own or not inner) else []
    yield from own
    for name, value in inner.items():
        yield from _sections(value, f"{path}.{_as_key(name)}" if path else _as_key(name), levels - 1)


def as_data(value: Any) -> Any:
    """Convert a value to the form that writing it to TOML and parsing it again gives: dicts without None, and lists."""
    if isinstance(value, Mapping):
        return {name: as_data(each) for name, each in value.items() if each is not None}
    return [as_data(each) for each in value] if isinstance(value, (list, tuple)) else value


def are_tables(value: object) -> bool:
    """Whether a value is a list of tables, such as `[[sensor]]`."""
    return isinstance(value, list) and bool(value) and all(isinstance(each, dict) for each in value)


def _assignments(table: Mapping[str, Any]) -> list[str]:
    return [f"{_as_key(name)} = {_as_value(value)}" for name, value in table.items() if value is not None]


def _as_key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _as_value(name)


def _as_value(value: object) -> str:
    if isinstance(value, Mapping):
        inner = ", ".join(_assignments(value))
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_as_value, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    # TOML writes strings, numbers and booleans as JSON does, except surrogate pairs and the character DEL.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _refuse_deep(lines: Sequence[_Line], file: Path) -> None:
    """Refuse deep nesting before parsing, because the depth that tomllib can parse depends on the process."""
    for line in lines:
        if line.too_deep:
            raise InputError(_too_deep(file, line.number, line.too_deep))


def _refuse_long_keys(lines: Sequence[_Line], file: Path) -> None:
    for number, line, _, _ in lines:
        if line.count(".") < MAX_PARTS:
            continue
        count, begin, end = 0, 0, 0
        for part in _PART.finditer(line):
            joined = count > 0 and line[end : part.start()].strip() == "."
            count, begin, end = (count + 1, begin, part.end()) if joined else (1, part.start(), part.end())
            if count > MAX_PARTS:
                raise InputError(Fault(f"a key has more than {MAX_PARTS} parts.", file, number, begin + 1))


def _refuse_values(data: Mapping[str, Any], positions: Mapping[Key, tuple[int, int]], file: Path) -> None:
    """Refuse integers of more than 64 bits, which TOML does not allow, and values that are nested too deeply."""
    faults: list[Fault] = []
    rest: list[tuple[Key, Any]] = [((), data)]
    while rest:
        key, value = rest.pop()
        if isinstance(value, (dict, list)):
            if len(key) > MAX_DEPTH:
                raise InputError(_too_deep(file, *_nearest(key, positions)))
            parts = value.items() if isinstance(value, dict) else enumerate(value)
            rest.extend(((*key, name), part) for name, part in parts if isinstance(part, (dict, list, int)))
        elif value not in _INTEGERS:
            faults.append(_not_64_bits(file, *_nearest(key, positions)))
    if faults:
        raise InputError(*sorted(faults, key=lambda fault: (fault.line, fault.column)))


def _not_64_bits(file: Path, line: int = 0, column: int = 0) -> Fault:
    return Fault("an integer has more than 64 bits.", file, line, column, hint="Write at most 18 digits.")


def _too_deep(file: Path, line: int = 0, column: int = 0) -> Fault:
    return Fault(f"tables and lists nest too deep: {MAX_DEPTH} levels at most.", file, line, column)


def _nearest(key: Key, positions: Mapping[Key, tuple[int, int]]) -> tuple[int, int]:
    """Line and column of a key, or of the innermost table or list with a known position around the key."""
    while key and key not in positions:
        key = key[:-1]
    return positions.get(key, (0, 0))


class KeyPart(NamedTuple):
    """One part of a key as written, in a header, an assignment or an inline table."""

    key: Key  # full key up to and including this part, from the root
    start: int
    end: int  # index after its last character


def key_parts(text: str) -> Iterator[KeyPart]:
    """Every part of every key of a valid TOML text, in the order of the text."""
    counts: dict[Key, int] = {}
    here: Key = ()
    at = _next_item(text, 0)
    while at < len(text):
        brackets = 2 if text.startswith("[[", at) else int(text[at] == "[")
        parts, at = _parts(text, at + brackets)
        names = [name for name, _, _ in parts]
        if brackets:
            for i, (_, start, end) in enumerate(parts, 1):
                yield KeyPart(_resolve(names[:i], counts), start, end)
            here = _resolve(names, counts)
            if brackets == 2:
                counts[here] = counts.get(here, -1) + 1
                here = (*here, counts[here])
            at += brackets
        else:
            for i, (_, start, end) in enumerate(parts, 1):
                yield KeyPart((*here, *names[:i]), start, end)
            at = yield from _inner_parts(text, at + 1, (*here, *names))
        at = _next_item(text, at)


def comment_starts(text: str) -> list[int]:
    """Indices of the comments at the ends of lines of a valid TOML text."""
    begins = [0, *itertools.accumulate(len(line) for line in text.splitlines(keepends=True))]
    ends = (begins[number - 1] + len(line) for number, line, _, _ in _lines(text))
    return [end for end in ends if text.startswith("#", end)]


def value_end(text: str, at: int) -> int:
    """Index after the value at an index of a valid TOML text; spaces after a number or a truth value are included."""
    parts = _inner_parts(text, at, ())
    while True:
        try:
            next(parts)
        except StopIteration as end:
            return int(end.value)


def _inner_parts(text: str, at: int, key: Key) -> Generator[KeyPart, None, int]:
    """Key parts inside the value at an index; returns the index after the value."""
    at = _next_item(text, at)
    opening = text[at]
    if opening in "\"'":
        quote = opening * 3 if text.startswith(opening * 3, at) else opening
        return _long_string_end(text, at, quote) if len(quote) == 3 else _string_end(text, at)
    if opening not in "[{":
        found = _BARE_VALUE.match(text, at)
        return at + 1 if found is None else found.end()
    index, at = 0, _next_item(text, at + 1)
    while text[at] not in "]}":
        if opening == "[":
            at = yield from _inner_parts(text, at, (*key, index))
        else:
            parts, at = _parts(text, at)
            names = [name for name, _, _ in parts]
            for i, (_, start, end) in enumerate(parts, 1):
                yield KeyPart((*key, *names[:i]), start, end)
            at = yield from _inner_parts(text, at + 1, (*key, *names))
        index += 1
        at = _next_item(text, at)
        at = _next_item(text, at + 1) if text[at] == "," else at
    return at + 1


def _next_item(text: str, at: int) -> int:
    """Index of the next character that is neither space nor in a comment."""
    found = _BLANK.match(text, at)
    return at if found is None else found.end()


def _parts(text: str, at: int) -> tuple[list[tuple[str, int, int]], int]:
    """Parts of a dotted key at an index, each with its span, and the index after the key."""
    parts: list[tuple[str, int, int]] = []
    while (found := _KEY_PART.match(text, at)) is not None:
        parts.append((found[1].strip("\"'"), *found.span(1)))
        at = found.end()
        if not text.startswith(".", at):
            break
        at += 1
    return parts, at


def _long_string_end(text: str, at: int, quote: str) -> int:
    """Index after a multi-line string, which may end in up to two further quotes."""
    at += 3
    while not text.startswith(quote, at):
        at += 2 if text[at] == "\\" and quote == '"""' else 1
    at += 3
    while text.startswith(quote[0], at):
        at += 1
    return at


def _positions(lines: Sequence[_Line]) -> dict[Key, tuple[int, int]]:
    """Line and column of each key at the beginning of a line, and of each table header."""
    positions: dict[Key, tuple[int, int]] = {}
    counts: dict[Key, int] = {}
    here: Key = ()
    for number, line, depth, _ in lines:
        if depth:
            continue
        start = len(line) - len(line.lstrip(" \t"))
        brackets = 2 if line.startswith("[[", start) else int(line.startswith("[", start))
        name, end = _dotted(line, start + brackets)
        if brackets and line.startswith("]", end):
            here = _resolve(name, counts)
            if brackets == 2:
                index = counts[here] = counts.get(here, -1) + 1
                here = (*here, index)
            positions.setdefault(here, (number, start + 1))
        elif name and not brackets and line.startswith("=", end):
            positions.setdefault((*here, *name), (number, start + 1))
    return positions


def _dotted(line: str, at: int) -> tuple[list[str], int]:
    """Parse the dotted key at an index of a line; returns the parts of the key, and the index after the key."""
    parts, end = _parts(line, at)
    return [name for name, _, _ in parts], end


def _resolve(name: Sequence[str], counts: dict[Key, int]) -> Key:
    """Full key of a table header: each array of tables in its path is followed by the index of its newest element."""
    key: Key = ()
    for i, part in enumerate(name):
        key = (*key, part)
        if i < len(name) - 1 and key in counts:
            key = (*key, counts[key])
    return key


class _Line(NamedTuple):
    """Line of a TOML text that does not begin inside a multi-line string."""

    number: int  # 1-based
    text: str  # without its comment
    depth: int  # number of inline tables and lists that are open at its beginning
    too_deep: int  # column of the first bracket beyond MAX_DEPTH, 1-based; 0 for none


def _lines(text: str) -> Iterator[_Line]:
    inside, depth = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        begins, before, too_deep, end = not inside, depth, 0, len(line)
        at = 0
        while at < len(line):
            if inside:
                close = line.find(inside, at)
                if close < 0:
                    break
                at, inside = close + len(inside), ""
            elif (mark := _MARK.search(line, at)) is None:
                break
            elif line[at := mark.start()] == "#":
                end = at
                break
            elif line[at] in "\"'":
                quote = line[at] * 3 if line.startswith(line[at] * 3, at) else line[at]
                if len(quote) == 3:
                    inside, at = quote, at + 3
                else:
                    at = _string_end(line, at)
            else:
                # Brackets of a header close on the same line, so they cancel out.
                depth += (line[at] in "[{") - (line[at] in "]}")
                at += 1
                if depth > MAX_DEPTH:
                    too_deep = at
                    break
        depth = max(depth, 0)
        if begins:
            yield _Line(number, line[:end], before, too_deep)


def _string_end(line: str, at: int) -> int:
    """Index after the string that begins at an index of a line."""
    found = _STRING.match(line, at)
    return len(line) if found is None else found.end()
