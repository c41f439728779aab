"""`rocs-bt language-server`: faults as typed, completion, descriptions and definitions in any editor, over stdio."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import unquote, urlparse

import click

from ..base.errors import InputError, RocsError
from ..cli.terminal import own_stdout
from .utf16 import from_units, units

if TYPE_CHECKING:
    from pygls.lsp.server import LanguageServer

    from .editing.worker import Worker

T = TypeVar("T")

_THREADS = 32  # that wait for the worker
_KINDS = {"key": 6, "value": 12, "port": 10, "Action": 3, "Condition": 3, "Control": 7, "Decorator": 8, "SubTree": 9}
"""`CompletionItemKind` of the kinds of items; 22, a structure, for others."""

_LEVELS = {"error": 1, "warning": 2, "note": 3}


@click.command()
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
def command(no_code: bool) -> None:
    """Serve an editor with faults, completion, descriptions and definitions of content files.

    The editor starts it and speaks with it on its standard input and output, by the Language Server Protocol.
    """
    from .editing.worker import Worker

    worker = Worker()
    server = make_server(worker, code=not no_code)
    with closing(worker), own_stdout() as stdout:  # the protocol's: content may print
        server.start_io(stdout=stdout.buffer)


def make_server(worker: Worker, *, code: bool = True) -> LanguageServer:
    """Language server for missions in XML, rule files, robots, scenarios and planners.

    Raises:
        InputError: pygls is not installed.
    """
    try:
        from lsprotocol import types
        from pygls.lsp.server import LanguageServer
    except ImportError as error:
        raise InputError("the language server needs pygls. Install it: pip install 'rocs_bt[editor]'.") from error
    server = LanguageServer("rocs-bt", "1")
    _Features(server, types, worker, code).add()
    return server


class _Features:
    """Requests of an editor, answered by `rocs_bt.studio.editing` in a process of its own."""

    def __init__(self, server: LanguageServer, types: Any, worker: Worker, code: bool) -> None:
        self.server, self.types, self.code = server, types, code
        self._worker, self._threads = worker, ThreadPoolExecutor(_THREADS)
        self.open: dict[Path, str] = {}  # addresses of the open files, as the editor writes them

    def add(self) -> None:
        """Add the features to the server."""
        t = self.types

        def feature(name: str, options: Any = None) -> Any:
            def add(method: Any) -> None:
                async def handle(params: Any) -> Any:  # pygls writes attributes to it, which a method does not take
                    return await method(params)

                self.server.feature(name, options)(handle)

            return add

        for name in (t.TEXT_DOCUMENT_DID_OPEN, t.TEXT_DOCUMENT_DID_CHANGE, t.TEXT_DOCUMENT_DID_SAVE):
            feature(name)(self.check)
        feature(t.TEXT_DOCUMENT_DID_CLOSE)(self.closed)
        triggers = t.CompletionOptions(trigger_characters=["<", " ", '"', "'", "{", "[", "="])
        feature(t.TEXT_DOCUMENT_COMPLETION, triggers)(self.complete)
        feature(t.TEXT_DOCUMENT_HOVER)(self.hover)
        feature(t.TEXT_DOCUMENT_DEFINITION)(self.definition)
        feature(t.TEXT_DOCUMENT_CODE_ACTION)(self.actions)

    async def check(self, params: Any) -> None:
        """Publish the faults of every open file: a change of one may be a fault of another."""
        self.open[_path(params.text_document.uri)] = params.text_document.uri
        texts = {path: self.server.workspace.get_text_document(uri).source for path, uri in self.open.items()}
        await asyncio.gather(*(self._publish(path, texts) for path in texts if path.suffix in (".xml", ".toml")))

    async def closed(self, params: Any) -> None:
        """Remove the faults of a closed file."""
        self.open.pop(_path(params.text_document.uri), None)
        self._send(params.text_document.uri, [])

    async def complete(self, params: Any) -> list[Any]:
        """Proposals at a position."""
        from .editing import complete

        t, (path, text, at) = self.types, self._place(params)
        items = []
        for order, item in enumerate(await self._ask(path, complete, path, text, at, code=self.code)):
            kind = t.CompletionItemKind(_KINDS.get(item.kind, 22))
            edit = t.TextEdit(self._span(text, item.start, item.end), _snippet(item.new))
            items.append(
                t.CompletionItem(
                    item.label,
                    kind=kind,
                    detail=item.detail,
                    documentation=item.doc,
                    text_edit=edit,
                    filter_text=item.label,
                    sort_text=f"{order:04}",
                    insert_text_format=t.InsertTextFormat.Snippet,
                )
            )
        return items

    async def hover(self, params: Any) -> Any:
        """Description of what is at a position, or None."""
        from .editing import describe

        t, (path, text, at) = self.types, self._place(params)
        found = await self._ask(path, describe, path, text, at, code=self.code)
        if found is None:
            return None
        rows = "".join(f"\n- {row}" for row in found.rows)
        value = f"**{found.title}** {found.detail}\n\n{found.doc}\n{rows}".strip()
        return t.Hover(t.MarkupContent(t.MarkupKind.Markdown, value), self._span(text, found.start, found.end))

    async def definition(self, params: Any) -> Any:
        """Definition of the name at a position, or None."""
        from .editing import define

        t, (path, text, at) = self.types, self._place(params)
        found = await self._ask(path, define, path, text, at, code=self.code)
        if found is None or found.file is None:
            return None
        position = t.Position(found.line - 1, found.column - 1)
        return t.Location(found.file.resolve().as_uri(), t.Range(position, position))

    async def actions(self, params: Any) -> list[Any]:
        """Corrections of the faults in a range: the existing name that is closest."""
        t, uri = self.types, params.text_document.uri
        found = []
        for diagnostic in params.context.diagnostics:
            if new := (diagnostic.data or {}).get("instead"):
                edit = t.WorkspaceEdit(changes={uri: [t.TextEdit(self._written(uri, diagnostic), new)]})
                kind = t.CodeActionKind.QuickFix
                found.append(t.CodeAction(f"Replace by '{new}'", kind=kind, diagnostics=[diagnostic], edit=edit))
        return found

    async def _ask(self, path: Path, function: Callable[..., T], *args: Any, **kwargs: Any) -> T:
        ask = partial(self._worker.ask, (function.__name__, path), function, *args, **kwargs)
        return await asyncio.get_running_loop().run_in_executor(self._threads, ask)

    async def _publish(self, path: Path, texts: Mapping[Path, str]) -> None:
        from .editing import Mark, faults
        from .editing.worker import Superseded

        t, text, uri = self.types, texts[path], self.open[path]
        version = self.server.workspace.get_text_document(uri).version
        try:
            marks = await self._ask(path, faults, path, text, texts=texts, code=self.code)
        except Superseded:
            return
        except RocsError as error:
            marks = (Mark(1, 1, 1, "warning", str(error)),)
        if self.open.get(path) != uri or self.server.workspace.get_text_document(uri).version != version:
            return
        lines = text.split("\n")
        found = []
        for mark in marks:
            line = lines[mark.line - 1] if mark.line <= len(lines) else ""
            span = t.Range(
                t.Position(mark.line - 1, units(line[: mark.column - 1])),
                t.Position(mark.line - 1, units(line[: mark.end - 1])),
            )
            level, message = t.DiagnosticSeverity(_LEVELS[mark.level]), f"{mark.message} {mark.hint}".strip()
            data = {"instead": mark.instead, "message": mark.message}
            found.append(t.Diagnostic(span, message, severity=level, source="rocs-bt", data=data))
        self._send(uri, found, version)

    def _send(self, uri: str, found: list[Any], version: int | None = None) -> None:
        self.server.text_document_publish_diagnostics(self.types.PublishDiagnosticsParams(uri, found, version))

    def _place(self, params: Any) -> tuple[Path, str, int]:
        """Path, text and offset of a position."""
        text = self.server.workspace.get_text_document(params.text_document.uri).source
        return _path(params.text_document.uri), text, _offset(text, params.position.line, params.position.character)

    def _span(self, text: str, start: int, end: int) -> Any:
        return self.types.Range(self._position(text, start), self._position(text, end))

    def _position(self, text: str, at: int) -> Any:
        begin = text.rfind("\n", 0, at) + 1
        return self.types.Position(text.count("\n", 0, at), units(text[begin:at]))

    def _written(self, uri: str, diagnostic: Any) -> Any:
        """Span of the wrong name that a diagnostic quotes; its own span if the name is not on the line."""
        text = self.server.workspace.get_text_document(uri).source
        _, quote, rest = (diagnostic.data or {}).get("message", "").partition("'")
        name = rest.partition("'")[0]
        begin = _offset(text, diagnostic.range.start.line, 0)
        line = text[begin:].partition("\n")[0]
        at = line.find(name, _offset(line, 0, diagnostic.range.start.character)) if quote and name else -1
        return diagnostic.range if at < 0 else self._span(text, begin + at, begin + at + len(name))


def _snippet(new: str) -> str:
    """Text with one place for the cursor, in which the protocol's own signs are plain text."""
    before, cursor, after = new.partition("$1")
    return "".join(["\\" + c if c in "\\$}" else c for c in before]) + cursor + after.replace("}", "\\}")


def _path(uri: str) -> Path:
    return Path(unquote(urlparse(uri).path))


def _offset(text: str, line: int, character: int) -> int:
    """Offset of a position that counts in UTF-16 code units."""
    begin = 0
    for _ in range(line):
        begin = text.find("\n", begin) + 1
    row = text[begin:].partition("\n")[0]
    return begin + from_units(row, character)
