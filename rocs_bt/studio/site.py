"""Routes that every server of the page has: its modules, its style, and one run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec

from ..base.files import read_bytes
from ..running.run_command import RunCommand
from .feed import Feed, updates
from .page import WEB, served_page
from .requests import Answer, Handler, Request, Routes

_KINDS = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
}
PACKED = "application/octet-stream"


def web_routes(pages: dict[str, str]) -> Routes:
    """Routes of pages, by the name of each page, and of all modules and styles."""
    files = {("GET", file.name): _file(file) for file in WEB.iterdir() if file.suffix in _KINDS}
    return files | {("GET", name): _served(page) for name, page in pages.items()}


def live_routes(feed: Feed, control: Callable[[RunCommand], object]) -> Routes:
    """Routes of the page of one run that goes on."""

    def command(request: Request) -> Answer:
        control(command_of(request))
        return Answer(b"{}")

    return {
        **web_routes({"": "run"}),
        ("GET", "head"): lambda _: Answer(feed.head()),
        ("GET", "events"): lambda _: stream(feed),
        ("POST", "control"): command,
    }


def command_of(request: Request) -> RunCommand:
    """Command in a request of a browser; its sender is the page, whatever the request says."""
    command: RunCommand = request.read(RunCommand)
    return msgspec.structs.replace(command, by="the page")


def stream(feed: Feed) -> Answer:
    """The updates of a run, as server-sent events."""
    return Answer(updates(feed), "text/event-stream")


def _served(page: str) -> Handler:
    return lambda _: Answer(served_page(page).encode(), "text/html; charset=utf-8")


def _file(path: Path) -> Handler:
    return lambda _: Answer(read_bytes(path), _KINDS[path.suffix])
