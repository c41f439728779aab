"""HTTP server of the live page: loopback only, protected by a secret token in the URL."""

from __future__ import annotations

import hmac
import ipaddress
import queue
import secrets
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from ...errors import Fault, InputError
from ..page import render_page
from .picture import Picture

_PATIENCE = 5.0  # [s] without updates, after which a comment is sent to detect closed connections
_STALLED = 3.0  # [s] time limit of a browser's read or write
_BEHIND = 100  # maximum number of queued messages; a slower browser is dropped, and gets all when it reconnects


class Feed:
    """Thread-safe state of the live page: one thread updates it, and a thread per browser waits for messages."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._picture = Picture()
        self._listeners: list[queue.Queue[bytes | None]] = []

    def update(self, change: Callable[[Picture], None], *, whole: bool = False) -> None:
        """Update the state, and send all browsers the changes or, with `whole`, the whole state."""
        with self._lock:
            change(self._picture)
            message = _message(self._picture.whole(), "whole") if whole else _message(self._picture.delta())
            for listener in tuple(self._listeners):
                self._tell(listener, message)

    def join(self) -> queue.Queue[bytes | None]:
        """Add a browser; returns its queue of messages, which begins with the whole state and ends with None."""
        listener: queue.Queue[bytes | None] = queue.Queue(_BEHIND)
        with self._lock:
            listener.put(_message(self._picture.whole(), "whole"))
            self._listeners.append(listener)
        return listener

    def leave(self, listener: queue.Queue[bytes | None]) -> None:
        """Remove the queue of a browser that has disconnected."""
        with self._lock:
            if listener in self._listeners:
                self._listeners.remove(listener)

    def close(self) -> None:
        """End the message queues of all browsers."""
        with self._lock:
            for listener in tuple(self._listeners):
                self._tell(listener, None)

    def _tell(self, listener: queue.Queue[bytes | None], message: bytes | None) -> None:
        try:
            listener.put_nowait(message)
        except queue.Full:
            self._listeners.remove(listener)
            listener.get_nowait()
            listener.put_nowait(None)


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
            self._page()
        elif rest == ["events", ""]:
            self._events()
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log."""

    def _page(self) -> None:
        nonce = secrets.token_urlsafe(12)
        page = render_page("live.html", nonce=nonce).encode()
        self._begin("text/html; charset=utf-8", f"script-src 'nonce-{nonce}'; ")
        self.wfile.write(page)

    def _events(self) -> None:
        self._begin("text/event-stream")
        listener = self.server.feed.join()
        try:
            while True:
                try:
                    message = listener.get(timeout=_PATIENCE)
                except queue.Empty:
                    message = b":\n\n"
                if message is None:
                    break
                self.wfile.write(message)
                self.wfile.flush()
        except OSError:  # the browser closed the connection
            pass
        finally:
            self.server.feed.leave(listener)

    def _begin(self, kind: str, scripts: str = "") -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {
            "Content-Type": kind,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Content-Security-Policy": f"default-src 'none'; {scripts}style-src 'unsafe-inline'; img-src data:; "
            "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        }.items():
            self.send_header(name, value)
        self.end_headers()


def _message(data: bytes, event: str = "message") -> bytes:
    """Encode a server-sent event; JSON data has no line breaks."""
    return b"event: %b\ndata: %b\n\n" % (event.encode(), data)
