"""HTTP server of the live page: loopback only, protected by a secret token in the URL."""

from __future__ import annotations

import hmac
import ipaddress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from ..errors import Fault, InputError
from ..files import read_bytes
from .feed import Feed, Seen
from .page import WEB, live_page

_PATIENCE = 5.0  # [s] without updates, after which a comment is sent to detect closed connections
_STALLED = 3.0  # [s] time limit of a browser's read or write
_TYPES = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)


class Server(ThreadingHTTPServer):
    """Serves the page and its stream of updates.

    Args:
        host: Loopback address.
        port: Port; 0 for any free port.
        token: Secret that every request must contain.
        feed: Feed to show.

    Raises:
        InputError: The host is no loopback address, or the port is in use.
    """

    daemon_threads = False  # `end` waits for the threads

    def __init__(self, host: str, port: int, token: str, feed: Feed) -> None:
        if not ipaddress.ip_address(host).is_loopback:
            raise InputError(
                Fault(
                    f"{host} is no loopback address; other machines could reach the live page.",
                    hint="Serve it on 127.0.0.1, and use a tunnel such as ssh -L for access from other machines.",
                )
            )
        try:
            super().__init__((host, port), _Handler)
        except OSError as error:
            hint = "Choose another with --port, or omit it for any free port."
            raise InputError(Fault(f"port {port} is not available: {error.strerror}.", hint=hint)) from error
        self.token = token
        self.feed = feed
        self.names = {f"{name}:{self.server_port}" for name in (host, "localhost")}

    def end(self) -> None:
        """Send the remaining messages and stop serving."""
        self.shutdown()
        self.feed.close()
        self.server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore errors of closed connections."""


class _Handler(BaseHTTPRequestHandler):
    """Handler of HTTP requests; each must contain the token and this server's Host header (no DNS rebinding)."""

    server: Server
    timeout = _STALLED
    server_version = "rocs_bt"
    sys_version = ""

    def do_GET(self) -> None:
        _, token, *rest = [*self.path.split("?")[0].split("/"), ""]
        if self.headers.get("Host") not in self.server.names:
            self.send_error(HTTPStatus.MISDIRECTED_REQUEST)
        elif not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.send_error(HTTPStatus.FORBIDDEN)
        elif rest == ["", ""]:
            self._answer("text/html; charset=utf-8", live_page().encode())
        elif rest == ["head", ""]:
            self._answer("application/json", self.server.feed.head())
        elif rest == ["events", ""]:
            self._events()
        elif rest[1:] == [""] and (file := self._module(rest[0])) is not None:
            self._answer(_TYPES[file.suffix], read_bytes(file))
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log."""

    def _module(self, name: str) -> Path | None:
        """A module or style of the page; only names that exist are looked up."""
        return next((file for file in WEB.iterdir() if file.name == name and file.suffix in _TYPES), None)

    def _events(self) -> None:
        self._begin("text/event-stream")
        seen, feed = Seen(), self.server.feed
        try:
            while True:
                closed = feed.closed
                fresh = feed.fresh(seen, _PATIENCE)
                if fresh is None and closed:
                    break
                self.wfile.write(b":\n\n" if fresh is None else b"data: %b\n\n" % fresh)
                self.wfile.flush()
        except OSError:  # the browser closed the connection
            pass

    def _answer(self, kind: str, body: bytes) -> None:
        self._begin(kind)
        self.wfile.write(body)

    def _begin(self, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {
            "Content-Type": kind,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Content-Security-Policy": _POLICY,
        }.items():
            self.send_header(name, value)
        self.end_headers()
