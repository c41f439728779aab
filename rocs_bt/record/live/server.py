"""The live page's server: loopback only, behind a secret in the address, in the standard library's HTTP."""

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

_PATIENCE = 5.0  # [s] without news, after which a comment finds out whether a browser still listens
_STALLED = 3.0  # [s] that a browser may take for a read or a write
_BEHIND = 100  # messages; a browser that is further behind is dropped, and gets everything when it comes back


class Feed:
    """A picture that several threads look at: one gives it news, each browser's own waits for them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._picture = Picture()
        self._listeners: list[queue.Queue[bytes | None]] = []

    def update(self, change: Callable[[Picture], None], *, anew: bool = False) -> None:
        """Change the picture, and tell all listeners: what is new, or everything `anew`."""
        with self._lock:
            change(self._picture)
            message = _message(self._picture.whole(), "whole") if anew else _message(self._picture.news())
            for listener in tuple(self._listeners):
                self._tell(listener, message)

    def join(self) -> queue.Queue[bytes | None]:
        """A queue of messages that begins with everything; None ends it."""
        listener: queue.Queue[bytes | None] = queue.Queue(_BEHIND)
        with self._lock:
            listener.put(_message(self._picture.whole(), "whole"))
            self._listeners.append(listener)
        return listener

    def leave(self, listener: queue.Queue[bytes | None]) -> None:
        """Listen no more."""
        with self._lock:
            if listener in self._listeners:
                self._listeners.remove(listener)

    def close(self) -> None:
        """Let all listeners go."""
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
    """Serves the page and its stream of news.

    Args:
        host: Where; a loopback address.
        port: Its port; 0 for any that is free.
        token: The secret without which nothing is served.
        feed: What is shown.

    Raises:
        InputError: The address is not of this machine alone, or the port is taken.
    """

    daemon_threads = False  # `end` waits for them

    def __init__(self, host: str, port: int, token: str, feed: Feed) -> None:
        if not ipaddress.ip_address(host).is_loopback:
            raise InputError(
                Fault(
                    f"the live page was to be served on {host}, where others than this machine can reach it.",
                    hint="Serve it on 127.0.0.1, and let others in through a tunnel, such as ssh -L.",
                )
            )
        try:
            super().__init__((host, port), _Handler)
        except OSError as error:
            hint = "Name another with --port, or leave it out for any that is free."
            raise InputError(Fault(f"port {port} cannot be had: {error.strerror}.", hint=hint)) from error
        self.token = token
        self.feed = feed
        self.names = {f"{name}:{self.server_port}" for name in (host, "localhost")}

    def end(self) -> None:
        """Say what is left to say, and serve no more."""
        self.shutdown()
        self.feed.close()
        self.server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away is no news."""


class _Handler(BaseHTTPRequestHandler):
    """One request. Who knows the token is answered; a foreign Host is a name that was bent to this machine."""

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
        """Nobody reads it."""

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
        except OSError:  # the browser went away
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
    """A server-sent event; JSON has no line breaks."""
    return b"event: %b\ndata: %b\n\n" % (event.encode(), data)
