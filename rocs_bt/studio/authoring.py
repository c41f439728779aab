"""Editor of the page: opens, checks, completes, edits and saves the content files of a project.

Each function takes the object of a request and returns that of the answer. The text is the truth: the page sends it
with each question, and nothing of it is kept here.
"""

from __future__ import annotations

import hashlib
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..base.errors import Fault, InputError
from ..base.files import confined, is_file, read_bytes, unsaved, write_whole
from ..base.nesting import descendants
from ..catalog import TREES, Catalog, kind_of, make_entry
from ..check import fitted_rules
from ..reactive import run_tests, tested_file
from .editing import complete, define, describe, edit, faults, form, keys_in, parse, vocabulary
from .editing.worker import Superseded, Worker
from .pack import Json
from .requests import Answer, Handler, Request, Routes, as_json
from .site import web_routes
from .utf16 import from_units, units

MOST = 2_000_000
"""Maximum size of a file that is edited [bytes]."""

Asked = Mapping[str, Any]
"""Object of a request."""

_saving = threading.Lock()
_VIEWS = ("look", "complete", "describe", "form")  # of which only the newest question of a page counts
_EDITED = (".xml", ".toml", ".py")


def edit_routes(catalog: Catalog, worker: Worker, *, allow_code: bool = False) -> Routes:
    """Routes of the editor of a project's files."""
    table = Authoring(catalog, allow_code=allow_code).table()
    answers = {("POST", f"edit/{name}"): _answer(function, worker) for name, function in table.items()}
    return {**web_routes({"edit": "edit"}), **answers}


def _answer(function: Callable[[Asked], Json], worker: Worker) -> Handler:
    def answer(request: Request) -> Answer:
        asked = request.read(dict)
        if function.__name__ == "save":
            return as_json(function(asked))
        last = (str(asked.get("file")), str(asked.get("page"))) if function.__name__ in _VIEWS else object()
        try:
            return as_json(worker.ask((function.__name__, last), function, asked))
        except Superseded:
            return as_json(None)

    return answer


class Authoring:
    """Requests of the editor for the files of a project."""

    def __init__(self, catalog: Catalog, *, allow_code: bool = False) -> None:
        self.catalog = catalog
        self.allow_code = allow_code

    def table(self) -> dict[str, Callable[[Asked], Json]]:
        """Functions by the name of the request."""
        own = (self.open, self.look, self.complete, self.describe, self.form, self.edit, self.palette, self.save)
        return {function.__name__: function for function in own}

    def open(self, asked: Asked) -> Json:
        """Text of a file with its hash; `reason` says why it cannot be changed, `shipped` names what is of rocs_bt."""
        path, own = self._file(asked)
        raw = _read(path)
        kind = kind_of(tested_file(path)) or ""
        return {
            "file": _text(asked, "file"),
            "kind": kind,
            "text": _page_text(raw),
            "hash": _hash(raw),
            "reason": self._reason(path, own),
            "shipped": "" if own or not kind else make_entry(tested_file(path), kind, "file").name,
            "scenarios": self._scenarios(path, kind),
        }

    def look(self, asked: Asked) -> Json:
        """Faults of a text, the tree of a mission, and the results of the tests of a rule file."""
        path, text = self._file(asked)[0], _text(asked, "text")
        if path.suffix not in (".xml", ".toml"):
            return {"marks": [], "tree": None, "tests": []}
        rows = text.split("\n")
        found = [_mark(asdict(mark), rows) for mark in faults(path, text, code=self.catalog.code)]
        return {"marks": found, "tree": _tree(text) if path.suffix in TREES else None, "tests": self._tests(path, text)}

    def complete(self, asked: Asked) -> Json:
        """Proposals at an offset."""
        text = _text(asked, "text")
        items = complete(self._file(asked)[0], text, _offset(asked), code=self.catalog.code)
        spans = {at: units(text[:at]) for item in items for at in (item.start, item.end)}
        return {"items": [{**item._asdict(), "start": spans[item.start], "end": spans[item.end]} for item in items]}

    def describe(self, asked: Asked) -> Json:
        """Description and definition of what is at an offset; null where there is none."""
        path, text, at = self._file(asked)[0], _text(asked, "text"), _offset(asked)
        found = describe(path, text, at, code=self.catalog.code)
        place = define(path, text, at, code=self.catalog.code)
        name = None if place is None or place.file is None else self._name(place.file)
        where = None if place is None or name is None else {"file": name, "line": place.line}
        return {"about": found._asdict() if found else None, "definition": where}

    def form(self, asked: Asked) -> Json:
        """Ports of the node at an offset with their values; null where no node is."""
        path, text = self._file(asked)[0], _text(asked, "text")
        found = form(path, text, _offset(asked), code=self.catalog.code) if path.suffix in TREES else None
        if found is None:
            return {"node": None}
        info, element = found
        known = {port.name: asdict(port) for port in info.ports}
        values = {a.name: a.value for a in element.attributes}
        ports = [
            known.get(name, {"name": name, "direction": "", "type": "", "default": "", "doc": ""})
            for name in dict.fromkeys([*values, *known])
        ]
        rows = [{**port, "value": values.get(port["name"])} for port in ports]
        place = "/".join(map(str, element.path))
        return {
            "node": info.name,
            "kind": info.kind,
            "doc": info.doc,
            "path": place,
            "ports": rows,
            "keys": keys_in(text),
        }

    def edit(self, asked: Asked) -> Json:
        """Text and tree after an edit of a mission: `insert`, `remove`, `move` or `set`."""
        changed, path = edit(_text(asked, "text"), asked)
        return {"text": changed, "path": "/".join(map(str, path)), "tree": _tree(changed)}

    def palette(self, asked: Asked) -> Json:
        """Nodes and trees that a mission may use, with the text of a new one."""
        path, text = self._file(asked)[0], _text(asked, "text")
        if path.suffix not in TREES:
            return {"nodes": []}
        nodes = vocabulary(path, text, code=self.catalog.code).values()
        return {"nodes": [{"name": n.name, "kind": n.kind, "doc": n.doc, "text": n.text} for n in nodes]}

    def save(self, asked: Asked) -> Json:
        """Write a file whole; one that has changed on disk since it was opened is shown instead.

        Raises:
            InputError: The file may not be changed.
        """
        path, own = self._file(asked, new=True)
        if reason := self._reason(path, own):
            raise InputError(Fault(reason, path))
        with _saving:
            before = _read(path) if is_file(path) else b""
            if _hash(before) != _text(asked, "hash"):
                return {"conflict": {"text": _page_text(before), "hash": _hash(before)}}
            after = _file_bytes(_text(asked, "text"), before)
            write_whole(path, after)
        return {"hash": _hash(after)}

    def _file(self, asked: Asked, *, new: bool = False) -> tuple[Path, bool]:
        """File of a request, and whether it is of the project; raises InputError."""
        name = _text(asked, "file")
        _require_content(name, Path(name))
        for root in self.catalog.roots:
            path = confined(name, root, (root,))
            _require_content(name, path.relative_to(root.resolve()))  # a link may lead to any file
            if is_file(path):
                return path, root == self.catalog.project
        if new and self.catalog.project is not None:
            path = confined(name, self.catalog.project, (self.catalog.project,))
            if path.parent.is_dir():
                return path, True
        raise InputError(Fault(f"there is no file '{name}' in this project."))

    def _name(self, path: Path) -> str | None:
        """Name of a file for `open`; None if the page does not show it."""
        for root in self.catalog.roots:
            if path.resolve().is_relative_to(root.resolve()):
                name = path.resolve().relative_to(root.resolve())
                return name.as_posix() if kind_of(tested_file(name)) else None
        return None

    def _reason(self, path: Path, own: bool) -> str:
        """Reason why a file cannot be changed; empty if it can."""
        if not own:
            return "It is content of rocs_bt: copy it into your project to change it."
        if path.suffix == ".py" and not self.allow_code:
            return "Python files are changed only if the studio was started with --allow-code."
        return ""

    def _tests(self, path: Path, text: str) -> list[Json]:
        """Results of the tests of a rule file, one for each test and robot; none while the file has errors."""
        rules = tested_file(path)
        if kind_of(rules) != "rules":
            return []
        with unsaved({path: text}):
            try:
                fitted = fitted_rules(make_entry(rules, "rules", "file"), self.catalog)
            except InputError:
                return []  # the faults say it
            return [
                {
                    "rule": result.rule,
                    "test": result.test,
                    "robot": name,
                    "passed": result.passed,
                    "message": result.message,
                    "line": result.position.line if result.position.file == path else 0,
                }
                for name, found in fitted
                for result in run_tests(found)
            ]

    def _scenarios(self, path: Path, kind: str) -> list[str]:
        """Scenarios that use a file, by name."""
        found = []
        for entry in self.catalog.list("scenario"):
            try:
                scenario = self.catalog.read_scenario(str(entry.path))
                names = {
                    "mission": {a.mission for a in scenario.agents},
                    "rules": {name for a in scenario.agents for name in a.rules},
                    "robot": set(scenario.robots),
                    "scenario": {entry.name},
                }
            except InputError:
                continue
            if make_entry(tested_file(path), kind, "file").name in names.get(kind, ()) if kind else False:
                found.append(entry.name)
        return found


def _require_content(name: str, path: Path) -> None:
    """Check that a path in a project is one of content; raises InputError."""
    if path.suffix not in _EDITED or kind_of(tested_file(path)) is None:
        leads = "" if path == Path(name) else f", which leads to '{path}',"
        raise InputError(
            Fault(f"'{name}'{leads} is no content file.", hint="Open a mission, rule file, robot or scenario.")
        )


def _text(asked: Asked, name: str) -> str:
    value = asked.get(name)
    if not isinstance(value, str) or len(value) > MOST:
        raise InputError(f"the request needs '{name}', a text of at most {MOST} characters.")
    return value


def _offset(asked: Asked) -> int:
    """Offset into the text, from one that counts UTF-16 code units, as a browser does."""
    at = asked.get("at")
    if not isinstance(at, int) or at < 0:
        raise InputError("the request needs 'at', an offset into the text.")
    return from_units(_text(asked, "text"), at)


def _read(path: Path) -> bytes:
    try:
        return read_bytes(path, MOST)
    except OSError as error:
        raise InputError(Fault(f"cannot read the file: {error.strerror}.", path)) from error


def _hash(raw: bytes) -> str:
    return hashlib.sha256(raw).hexdigest()


def _page_text(raw: bytes) -> str:
    """Text for the page, which knows line feeds only."""
    try:
        return raw.decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise InputError("the file is not UTF-8 text.") from error


def _file_bytes(text: str, before: bytes) -> bytes:
    """Bytes of a text; lines that are in the file already keep their line ends."""
    old = before.decode("utf-8", "replace").splitlines(keepends=True) if b"\r" in before else []
    if not old:
        return text.encode()
    usual = "\r\n" if sum(line.endswith("\r\n") for line in old) * 2 > len(old) else "\n"
    new = text.splitlines(keepends=True)
    plain = [line.replace("\r\n", "\n") for line in old]
    first = _same(plain, new)
    last = _same(plain[first:][::-1], new[first:][::-1])
    left: dict[str, deque[str]] = {}  # lines between the first and the last that are the same, by their text
    for line, written in zip(plain[first : len(plain) - last], old[first : len(old) - last], strict=True):
        left.setdefault(line, deque()).append(written)
    between = [
        left[line].popleft() if left.get(line) else line.replace("\n", usual) for line in new[first : len(new) - last]
    ]
    return "".join([*old[:first], *between, *old[len(old) - last :]]).encode()


def _same(old: Sequence[str], new: Sequence[str]) -> int:
    """Number of lines at the beginning that are the same."""
    pairs = zip(old, new, strict=False)
    return next((i for i, (a, b) in enumerate(pairs) if a != b), min(len(old), len(new)))


def _mark(mark: Json, rows: list[str]) -> Json:
    """A mark for the page, with columns in UTF-16 code units; the name of another file without its folder."""
    row = rows[mark["line"] - 1]
    columns = {name: units(row[: mark[name] - 1]) + 1 for name in ("column", "end")}
    del mark["names"]  # many, and `instead` has the nearest
    return {**mark, **columns, "file": mark["file"].name if mark["file"] else ""}


def _tree(text: str) -> Json:
    """Elements of a mission in the order of the text, also while it is not well-formed."""
    document = parse(text, tolerant=True)
    rows = []
    for element in descendants(document) if document else ():
        if not element.tag:
            continue
        path = element.path
        rows.append(
            {
                "path": "/".join(map(str, path)),
                "tag": element.tag,
                "ports": [[a.name, a.value] for a in element.attributes],
                "children": len(element.children),
                "start": units(text[: element.start]),
                "inner": units(text[: element.inner]),
                "line": text.count("\n", 0, element.start) + 1,
                "last": text.count("\n", 0, element.end) + 1,
            }
        )
    return {"rows": rows, "whole": parse(text) is not None}
