"""HTTP server of the page: loopback only, protected by a secret token in the URL; one request a connection."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import socket
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from http import HTTPStatus

import msgspec

from ..base.errors import Fault, InputError, RocsError
from .requests import MOST_HEAD, Answer, RefusedError, Request, Routes, parse

MOST_CONNECTIONS = 128
"""Maximum number of connections; a further one replaces the oldest that has not shown the token."""

_REQUEST_TIME = 5.0  # [s] time limit of a whole request
_STALLED = 3.0  # [s] time limit of a browser that does not read
_NO_FILES = 0.1  # [s] until the next try to accept a connection
_THREADS = 32  # that answer requests; those about texts wait for another process
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
_FIELDS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Content-Security-Policy": _POLICY,
    "Connection": "close",
}


class Server:
    """Serves a table of routes, in a thread of its own.

    Raises:
        InputError: The host is no loopback address, or the port is in use.
    """

    def __init__(
        self, host: str, port: int, token: str, routes: Routes, report: Callable[[BaseException], None] | None = None
    ) -> None:
        if not ipaddress.ip_address(host).is_loopback:
            raise InputError(
                Fault(
                    f"{host} is no loopback address; other machines could reach the page.",
                    hint="Serve it on 127.0.0.1, and use a tunnel such as ssh -L for access from other machines.",
                )
            )
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._socket = socket.create_server((host, port), family=family, backlog=512)
        except OSError as error:
            hint = "Choose another with --port, or omit it for any free port."
            raise InputError(Fault(f"port {port} is not available: {error.strerror}.", hint=hint)) from error
        self.port: int = self._socket.getsockname()[1]
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self.port}/{token}/"
        self._names = {f"{name}:{self.port}" for name in (shown, "localhost")}
        self._token = token.encode()
        self._routes = routes
        self._report = report
        self._connections: dict[asyncio.Task[None], bool] = {}  # whether each has shown the token, oldest first
        self._threads = ThreadPoolExecutor(_THREADS, "http")
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ending = asyncio.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="http", daemon=True)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()
        self._ready.wait()

    def end(self) -> None:
        """Take no further requests, let the streams end for a few seconds, and stop."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._ending.set)
            self._thread.join()
        self._socket.close()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:  # others cannot watch a socket
            runner.run(self._serve())

    async def _serve(self) -> None:
        self._loop = loop = asyncio.get_running_loop()
        self._socket.setblocking(False)
        loop.add_reader(self._socket, self._accept, loop)
        self._ready.set()
        await self._ending.wait()
        loop.remove_reader(self._socket)
        for task, known in self._connections.items():
            if not known:
                task.cancel()
        await self._finished()
        for task in [*self._connections]:
            task.cancel()
        await self._finished()

    async def _finished(self) -> None:
        if self._connections:
            await asyncio.wait(self._connections, timeout=_STALLED)

    def _accept(self, loop: asyncio.AbstractEventLoop) -> None:
        try:
            client, _ = self._socket.accept()
        except OSError:  # such as too many open files: it waits until the slow ones are dropped
            loop.remove_reader(self._socket)
            loop.call_later(_NO_FILES, self._accept_again, loop)
            return
        client.setblocking(False)
        if len(self._connections) >= MOST_CONNECTIONS:
            oldest = next((each for each, known in self._connections.items() if not known), None)
            if oldest is None:
                client.close()
                return
            del self._connections[oldest]
            oldest.cancel()
        task = loop.create_task(self._connected(client))
        self._connections[task] = False
        task.add_done_callback(partial(self._gone, client))

    def _accept_again(self, loop: asyncio.AbstractEventLoop) -> None:
        if not self._ending.is_set():
            loop.add_reader(self._socket, self._accept, loop)

    def _gone(self, client: socket.socket, task: asyncio.Task[None]) -> None:
        self._connections.pop(task, None)
        client.close()

    async def _connected(self, client: socket.socket) -> None:
        reader, writer = await asyncio.open_connection(sock=client, limit=MOST_HEAD)
        try:
            await self._converse(reader, writer)
        except (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.CancelledError):
            pass  # the browser has gone, is too slow, or has to give way
        finally:
            writer.transport.abort() if writer.transport.get_write_buffer_size() else writer.close()
            with contextlib.suppress(OSError):
                await writer.wait_closed()

    async def _converse(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            async with asyncio.timeout(_REQUEST_TIME):
                request = parse(await reader.readuntil(b"\r\n\r\n"))
                self._check(request)
                if (task := asyncio.current_task()) in self._connections:
                    self._connections[task] = True
                request = msgspec.structs.replace(request, body=await reader.readexactly(request.length))
            answer = await asyncio.get_running_loop().run_in_executor(self._threads, self._answer, request)
        except RefusedError as refused:
            answer = _refusal(refused.status)
        except asyncio.LimitOverrunError:
            answer = _refusal(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE)
        await self._send(writer, answer)

    def _check(self, request: Request) -> None:
        """Refuse a request that does not come from a page of this server, or that has no handler."""
        fields = request.fields
        if fields.get("host") not in self._names:  # DNS rebinding
            raise RefusedError(HTTPStatus.MISDIRECTED_REQUEST)
        if not hmac.compare_digest(request.token.encode(), self._token):
            raise RefusedError(HTTPStatus.FORBIDDEN)
        own = {f"http://{fields['host']}"}
        posts = request.method == "POST"
        if fields.get("origin", "" if posts else next(iter(own))) not in own:
            raise RefusedError(HTTPStatus.FORBIDDEN)
        if fields.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            raise RefusedError(HTTPStatus.FORBIDDEN)
        if (request.method, request.name) not in self._routes:
            known = any(name == request.name for _, name in self._routes)
            raise RefusedError(HTTPStatus.METHOD_NOT_ALLOWED if known else HTTPStatus.NOT_FOUND)
        if posts and fields.get("content-type", "").split(";")[0].strip() != "application/json":
            raise RefusedError(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        if not posts and request.length:
            raise RefusedError(HTTPStatus.BAD_REQUEST)

    def _answer(self, request: Request) -> Answer:
        try:
            return self._routes[request.method, request.name](request)
        except RocsError as error:
            return Answer(msgspec.json.encode({"error": str(error)}), status=HTTPStatus.UNPROCESSABLE_ENTITY)
        except Exception as error:  # noqa: BLE001 - boundary of a request: the server must go on
            if self._report is not None:
                self._report(error)
            return _refusal(HTTPStatus.INTERNAL_SERVER_ERROR)

    async def _send(self, writer: asyncio.StreamWriter, answer: Answer) -> None:
        body, fields = answer.body, {"Content-Type": answer.kind, **_FIELDS}
        if isinstance(body, bytes):
            fields["Content-Length"] = str(len(body))
        lines = [f"HTTP/1.1 {answer.status} {answer.status.phrase}", *(f"{name}: {fields[name]}" for name in fields)]
        writer.write("\r\n".join([*lines, "", ""]).encode())
        if isinstance(body, bytes):
            await _written(writer, body)
            return
        async with contextlib.aclosing(body) as parts:
            async for part in parts:
                await _written(writer, part)


async def _written(writer: asyncio.StreamWriter, data: bytes) -> None:
    """Write data; a browser that does not read, or has gone, ends the connection."""
    writer.write(data)
    while True:
        size = writer.transport.get_write_buffer_size()
        try:
            async with asyncio.timeout(_STALLED):
                await writer.drain()
                return
        except TimeoutError:
            if writer.transport.get_write_buffer_size() >= size:
                raise


def _refusal(status: HTTPStatus) -> Answer:
    return Answer(f"{status.value} {status.phrase}\n".encode(), "text/plain; charset=utf-8", status)
