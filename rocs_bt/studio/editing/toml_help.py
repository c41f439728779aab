"""Completion, descriptions and definitions in rule files, robots, scenarios and planners.

The readers of these files ask for the keys that they know. So the keys of a table are those that its reader asked for.
"""

from __future__ import annotations

import re
from pathlib import Path

from ...base.errors import InputError
from ...base.toml_table import KnownKey, observed_tables
from ...base.toml_text import Key, parse_toml
from ...catalog import Catalog, classes_in, kind_of
from ...declare import Location
from .help import Description, Item, names_instead
from .marks import faults

_HEADER = re.compile(r"[ \t]*\[\[?[ \t]*([^\]\n]*?)[ \t]*\]")
_VALUE = re.compile(r"""^[ \t]*([\w."'-]+)[ \t]*=[ \t]*(.*)$""")
_STRING = re.compile(r"""(["'])([^"']*)$""")
_INLINE = re.compile(r"""([A-Za-z_][\w-]*)[ \t]*=[ \t]*\{(?:[^{}]*,)?[ \t]*([\w-]*)$""")
_INNER = re.compile(r"""([A-Za-z_][\w-]*)[ \t]*=[ \t]*\{(?:[^{}]*,)?[ \t]*([\w-]+)[ \t]*=[ \t]*[^,{}]*$""")
_NAME = re.compile(r"[A-Za-z_][\w.]*$")
_CONTENT = {"include": "rules", **{kind: kind for kind in ("robot", "mission", "rules", "world", "family")}}
"""Kind of the content that the value of a key names."""


def complete_toml(path: Path, text: str, at: int, *, code: bool = True) -> list[Item]:
    """Keys of the table, names of tables after `[`, and values in quotes."""
    begin = text.rfind("\n", 0, at) + 1
    before, end = text[begin:at], text.find("\n", at)
    end = len(text) if end < 0 else end
    if "#" in re.sub(r""""[^"]*"|'[^']*'""", "", before):
        return []
    blank = text[:begin] + text[end:]
    if header := re.match(r"[ \t]*\[\[?[ \t]*([\w.-]*)$", before):
        tables = {n: k for n, k in _known(path, blank, (), code).items() if "table" in k.kind}
        return [Item(n, "table", k.kind, k.doc, n, at - len(header[1]), at) for n, k in tables.items()]
    table, value = _table_at(path, blank, text.count("\n", 0, at)), _VALUE.match(before)
    if inline := _INLINE.search(before):
        open_line = before.removesuffix(inline[2]).rstrip(" \t,")
        rests = (text[at:end].lstrip("\"' ,"), "", " }")  # what makes a valid text of it
        tried = [f"{text[:begin]}{open_line}{rest}{text[end:]}" for rest in rests]
        whole = next((each for each in tried if _is_valid(each, path)), blank)
        return _keys(path, whole, (*table, *_key(inline[1])), inline[2], at, code)
    if value is None:
        word = re.search(r"[\w.-]*$", before)
        return _keys(path, blank, table, word[0] if word else "", at, code)
    inner = _INNER.search(before)
    key = (*table, *_key(inner[1]), *_key(inner[2])) if inner else (*table, *_key(value[1]))
    return _values(path, text, at, end, key, value[2], code)


def describe_toml(path: Path, text: str, at: int, *, code: bool = True) -> Description | None:
    """Description, type, unit, default and valid values of the key at an offset."""
    begin = text.rfind("\n", 0, at) + 1
    line = text[begin:].partition("\n")[0]
    if not (found := re.match(r"[ \t]*([\w.-]+)[ \t]*=", line)) or found.start(1) > at - begin:
        return None
    key = (*_table_at(path, text, text.count("\n", 0, at)), *_key(found[1]))
    known = _known(path, text, key[:-1], code).get(str(key[-1]))
    if known is None:
        return None
    return Description(found[1], _detail(known), known.doc, (), begin + found.start(1), begin + found.end(1))


def define_toml(path: Path, text: str, at: int, *, code: bool = True) -> Location | None:
    """File of the content that a value names; line of the threshold, alias or place that it names."""
    begin = text.rfind("\n", 0, at) + 1
    line = text[begin:].partition("\n")[0]
    words = [w for w in re.finditer(r"[\w./:-]+", line) if w.start() <= at - begin <= w.end()]
    if not words:
        return None
    word, key = words[0][0], re.match(r"[ \t]*([\w-]+)", line)
    kind = kind_of(path) if key and key[1] == "base" else _CONTENT.get(key[1] if key else "")
    try:
        if kind is not None:
            return Location(Catalog.here(path.parent, code=code).find(kind, word, named_in=path).path, 1, 1)
        file, _, cls = word.partition(":")
        if file.endswith(".py"):
            return Location(path.parent / file, classes_in(path.parent / file).get(cls, 1), 1)
    except InputError:
        return None
    name = re.escape(word)
    own = re.search(rf"""^[ \t]*(?:{name}[ \t]*=|name[ \t]*=[ \t]*["']{name}["'])""", text, re.MULTILINE)
    return None if own is None else Location(path, text.count("\n", 0, own.start()) + 1, 1)


def _key(written: str) -> Key:
    return tuple(part.strip("\"' ") for part in written.split("."))


def _is_valid(text: str, path: Path) -> bool:
    try:
        parse_toml(text, path)
    except InputError:
        return False
    return True


def _table_at(path: Path, text: str, row: int) -> Key:
    """Key of the table that a line is in; its header may have an index, as that of an array of tables."""
    try:
        positions = parse_toml(text, path)[1]
    except InputError:
        positions = {}
    lines = text.split("\n")
    headers = {line: key for key, (line, _) in positions.items() if _HEADER.match(lines[line - 1])}
    above = [line for line in headers if line <= row + 1]
    return headers[max(above)] if above else ()


def _known(path: Path, text: str, table: Key, code: bool) -> dict[str, KnownKey]:
    """Keys that the readers of a table asked for; those of a similar table if this one was not read."""
    with observed_tables() as tables:
        faults(path, text, code=code)
    own = [t for t in tables if t.file.resolve() == path.resolve()]
    names = _names(table)
    exact = [t for t in own if t.key == table] or [t for t in own if _names(t.key) == names]
    found: dict[str, KnownKey] = {}
    for each in exact:
        for name, key in each.known.items():
            if name not in found or (key.kind and not found[name].kind):
                found[name] = key
    return found


def _names(key: Key) -> tuple[str, ...]:
    """Names in a key without indices; names that a user chooses are equal to any other."""
    names = tuple(part for part in key if isinstance(part, str))
    return tuple("*" if i and names[0] in ("rule", "threshold") and i == 1 else name for i, name in enumerate(names))


def _keys(path: Path, blank: str, table: Key, typed: str, at: int, code: bool) -> list[Item]:
    try:
        given = parse_toml(blank, path)[0]
        for part in table:
            given = given[part]  # type: ignore[index]  # a key leads through tables and lists
    except (InputError, KeyError, IndexError, TypeError):
        given = {}
    known = [(name, key) for name, key in _known(path, blank, table, code).items() if name not in given]
    items = []
    for name, key in sorted(known, key=lambda pair: not pair[1].required):
        table_like = key.kind in ("a list of tables", "a table of tables")
        if not table_like:
            items.append(Item(name, "key", _detail(key), key.doc, f"{name} = {_pattern(key)}", at - len(typed), at))
    return items


def _pattern(key: KnownKey) -> str:
    """Value to fill in, with `$1` where the cursor goes."""
    if key.kind.startswith("a quantity"):
        unit = key.kind.partition("[")[2].rstrip("]")  # none if another key of the table names it
        return f'"$1 {unit}"' if unit not in ("", "1") else '"$1"'
    brackets = {"a text": '"$1"', "true or false": "$1", "a whole number": "$1", "a table": "{ $1 }"}
    return brackets.get(key.kind, "[$1]" if key.kind.startswith("a list") else '"$1"')


def _detail(key: KnownKey) -> str:
    default = str(key.default).lower() if isinstance(key.default, bool) else str(key.default)
    need = "required" if key.required else "" if key.default in (None, "") else f"default {default}"
    options = f"one of {', '.join(key.options)}" if key.options else ""
    return ", ".join(filter(None, (key.kind or "any value", options, need)))


def _values(path: Path, text: str, at: int, end: int, key: Key, written: str, code: bool) -> list[Item]:
    opened = _STRING.search(written)
    if written.count('"') % 2 == 0 and written.count("'") % 2 == 0:
        known = _known(path, text[: text.rfind("\n", 0, at) + 1] + text[end:], key[:-1], code)
        flag = known.get(str(key[-1]), KnownKey()).kind == "true or false"
        word = re.search(r"\w*$", written)
        return [Item(v, "value", "", "", v, at - len(word[0] if word else ""), at) for v in ("true", "false") if flag]
    if opened is None:
        return []
    start = at - len(opened[2])
    close = text.find(opened[1], at, end)
    stop = end if close < 0 else close
    missing = "".join(")]}"["([{".index(c)] for c in written if c in "[{" and close < 0)
    whole = text[:stop] + ("" if close >= 0 else opened[1] + missing) + text[stop:]
    names = names_instead(path, whole, start, stop, code=code)
    word = _NAME.search(opened[2])
    if set(opened[2]) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:-"):  # an expression
        start, stop = at - len(word[0] if word else ""), at
    known = _known(path, text[: text.rfind("\n", 0, at) + 1] + text[end:], key[:-1], code)
    options = known.get(str(key[-1]), KnownKey()).options
    return [Item(name, "value", "", "", name, start, stop) for name in dict.fromkeys((*options, *names))]
