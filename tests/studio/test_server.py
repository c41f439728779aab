"""The server of the page: who is refused, with what, and that slow connections cost nobody anything."""

import asyncio
import gc
import socket
import threading
import time
from contextlib import suppress

import pytest

from rocs_bt.studio.requests import MOST_BODY, MOST_HEAD, Answer, Request, as_json
from rocs_bt.studio.server import MOST_CONNECTIONS, Server

from ..waiting import GUARD, until

TOKEN = "a-token_0123456789"


async def endless():
    yield b"data: 1\n\n"


def broken(request: Request) -> Answer:
    raise ZeroDivisionError("a defect")


ROUTES = {
    ("GET", ""): lambda _: Answer(b"<p>page", "text/html"),
    ("GET", "app.js"): lambda _: Answer(b"1", "text/javascript"),
    ("GET", "events"): lambda _: Answer(endless(), "text/event-stream"),
    ("GET", "echo"): lambda request: as_json(request.query),
    ("GET", "big"): lambda _: Answer(b"x" * 30_000_000, "text/plain"),
    ("GET", "broken"): broken,
    ("POST", "control"): lambda request: as_json(request.read(dict[str, str])),
}


@pytest.fixture(scope="module")
def server():
    told = []
    server = Server("127.0.0.1", 0, TOKEN, ROUTES, told.append)
    server.told = told
    server.start()
    yield server
    server.end()


def raw(server, data: bytes, *, close: bool = False) -> bytes:
    """Everything that the server answers to some bytes."""
    with socket.create_connection(("127.0.0.1", server.port), GUARD) as client:
        client.sendall(data)
        if close:
            client.shutdown(socket.SHUT_WR)
        found = b""
        try:
            while part := client.recv(1 << 16):
                found += part
        except ConnectionResetError:  # it does not read to the end what it refuses
            pass
        return found


def status(answer: bytes) -> int:
    return int(answer.split(b" ", 2)[1]) if answer else 0


def request(line="GET /{token}/ HTTP/1.1", *fields, host="127.0.0.1:{port}", body=b"", token=TOKEN):
    """Bytes of a request, with placeholders for port and token."""
    lines = [line, *([] if host is None else [f"Host: {host}"]), *fields, "", ""]
    return "\r\n".join(lines), body, token


POST = "POST /{token}/control HTTP/1.1"
OWN = "Origin: http://127.0.0.1:{port}"
JSON = "Content-Type: application/json"
TWO = "Content-Length: 2"

HOSTILE = {
    "another host": (421, request(host="evil.example")),
    "another host with this port (DNS rebinding)": (421, request(host="evil.example:{port}")),
    "host without port": (421, request(host="127.0.0.1")),
    "any address": (421, request(host="0.0.0.0:{port}")),
    "an empty host": (421, request(host="")),
    "no host": (421, request(host=None)),
    "a host with user": (421, request(host="me@127.0.0.1:{port}")),
    "a host of another port": (421, request(host="127.0.0.1:1")),
    "two hosts": (400, request("GET /{token}/ HTTP/1.1", "Host: evil.example")),
    "no token": (403, request("GET / HTTP/1.1")),
    "a shorter token": (403, request(token=TOKEN[:-1])),
    "a longer token": (403, request(token=TOKEN + "x")),
    "a token in the query": (403, request("GET /?token={token} HTTP/1.1")),
    "a name without token": (403, request("GET /app.js HTTP/1.1")),
    "two slashes": (403, request("GET //{token}/ HTTP/1.1")),
    "an encoded token": (403, request("GET /%61-token_0123456789/ HTTP/1.1")),
    "up": (404, request("GET /{token}/../events HTTP/1.1")),
    "up, encoded": (404, request("GET /{token}/%2e%2e/events HTTP/1.1")),
    "a file of the machine": (404, request("GET /{token}//etc/passwd HTTP/1.1")),
    "a module of Python": (404, request("GET /{token}/__init__.py HTTP/1.1")),
    "a NUL in the name": (404, request("GET /{token}/app.js%00 HTTP/1.1")),
    "a folder": (404, request("GET /{token}/web/app.js HTTP/1.1")),
    "a name that goes on": (404, request("GET /{token}/app.js/x HTTP/1.1")),
    "a backslash": (404, request("GET /{token}/..\\app.js HTTP/1.1")),
    "an absolute address": (400, request("GET http://evil.example/{token}/ HTTP/1.1")),
    "a tunnel": (400, request("CONNECT evil.example:80 HTTP/1.1")),
    "all": (400, request("OPTIONS * HTTP/1.1")),
    "a raw NUL": (400, request("GET /{token}/\0 HTTP/1.1")),
    "text that is no ASCII": (400, request("GET /{token}/é HTTP/1.1")),
    "HTTP/0.9": (400, request("GET /{token}/", host=None)),
    "HTTP/2": (400, request("GET /{token}/ HTTP/2.0")),
    "a tab in the line": (400, request("GET\t/{token}/ HTTP/1.1")),
    "a space before a colon": (400, request("GET /{token}/ HTTP/1.1", "Origin : x")),
    "a continued field": (400, request("GET /{token}/ HTTP/1.1", "X: a", " b")),
    "a bare newline in a field": (400, request("GET /{token}/ HTTP/1.1", "X: a\nHost: evil.example")),
    "a bare return in a field": (400, request("GET /{token}/ HTTP/1.1", "X: a\rb")),
    "many fields": (431, request("GET /{token}/ HTTP/1.1", *[f"X{i}: a" for i in range(100)])),
    "a huge field": (431, request("GET /{token}/ HTTP/1.1", "X: " + "a" * 2 * MOST_HEAD)),
    "a huge name": (431, request("GET /{token}/" + "a" * 2 * MOST_HEAD + " HTTP/1.1")),
    "another origin": (403, request("GET /{token}/ HTTP/1.1", "Origin: http://evil.example")),
    "a page of another site": (403, request("GET /{token}/ HTTP/1.1", "Sec-Fetch-Site: cross-site")),
    "a page of another port": (403, request("GET /{token}/ HTTP/1.1", "Sec-Fetch-Site: same-site")),
    "another method": (405, request("PUT /{token}/control HTTP/1.1", OWN)),
    "HEAD": (405, request("HEAD /{token}/ HTTP/1.1")),
    "a preflight of another site": (405, request("OPTIONS /{token}/control HTTP/1.1")),
    "TRACE": (405, request("TRACE /{token}/ HTTP/1.1")),
    "a post to a page": (405, request("POST /{token}/ HTTP/1.1", OWN, JSON, TWO, body=b"{}")),
    "a post without origin": (403, request(POST, JSON, TWO, body=b"{}")),
    "a post of another origin": (403, request(POST, "Origin: http://evil.example", JSON, TWO, body=b"{}")),
    "a post of no origin": (403, request(POST, "Origin: null", JSON, TWO, body=b"{}")),
    "a post of the other name": (403, request(POST, "Origin: http://localhost:{port}", JSON, TWO, body=b"{}")),
    "a post of a secure origin": (403, request(POST, "Origin: https://127.0.0.1:{port}", JSON, TWO, body=b"{}")),
    "a form": (415, request(POST, OWN, "Content-Type: application/x-www-form-urlencoded", TWO, body=b"{}")),
    "plain text": (415, request(POST, OWN, "Content-Type: text/plain", TWO, body=b"{}")),
    "a post without type": (415, request(POST, OWN, TWO, body=b"{}")),
    "two types": (400, request(POST, OWN, JSON, "Content-Type: text/plain", TWO, body=b"{}")),
    "chunks": (501, request(POST, OWN, JSON, "Transfer-Encoding: chunked", body=b"2\r\n{}\r\n0\r\n\r\n")),
    "chunks and length": (501, request(POST, OWN, JSON, TWO, "Transfer-Encoding: chunked", body=b"0\r\n\r\n")),
    "two lengths": (400, request(POST, OWN, JSON, TWO, "Content-Length: 20", body=b"{}")),
    "a list of lengths": (400, request(POST, OWN, JSON, "Content-Length: 2, 2", body=b"{}")),
    "a negative length": (400, request(POST, OWN, JSON, "Content-Length: -1")),
    "a signed length": (400, request(POST, OWN, JSON, "Content-Length: +2", body=b"{}")),
    "a length in another digit": (400, request(POST, OWN, JSON, "Content-Length: 0x2", body=b"{}")),
    "a huge body": (413, request(POST, OWN, JSON, f"Content-Length: {MOST_BODY + 1}")),
    "an enormous length": (400, request(POST, OWN, JSON, "Content-Length: " + "9" * 40)),
    "a body that waits": (417, request(POST, OWN, JSON, TWO, "Expect: 100-continue")),
    "a body of a GET": (400, request("GET /{token}/ HTTP/1.1", TWO, body=b"{}")),
    "no JSON": (422, request(POST, OWN, JSON, TWO, body=b"{[")),
    "other JSON": (422, request(POST, OWN, JSON, TWO, body=b"[]")),
    "deep JSON": (422, request(POST, OWN, JSON, "Content-Length: 100000", body=b"[" * 100_000)),
    "a query without value": (400, request("GET /{token}/echo?name HTTP/1.1")),
    "a parameter twice": (400, request("GET /{token}/echo?name=a&name=b HTTP/1.1")),
    "a NUL in a parameter": (400, request("GET /{token}/echo?name=a%00 HTTP/1.1")),
    "a line in a parameter": (400, request("GET /{token}/echo?name=a%0d%0aSet-Cookie: HTTP/1.1")),
    "a parameter that is no text": (400, request("GET /{token}/echo?name=%ff HTTP/1.1")),
    "many parameters": (400, request("GET /{token}/echo?" + "&".join(f"a{i}=1" for i in range(100)) + " HTTP/1.1")),
    "TLS": (0, ("\x16\x03\x01\x02\x00\x01", b"", TOKEN)),
    "nothing": (0, ("", b"", TOKEN)),
    "half a line": (0, ("GET /", b"", TOKEN)),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_request_is_refused(server, name):
    wanted, (head, body, token) = HOSTILE[name]
    text = head.replace("{port}", str(server.port)).replace("{token}", token)
    answer = raw(server, text.encode("latin-1") + body, close=wanted == 0)
    assert status(answer) == wanted, answer[:300]
    assert b"Access-Control" not in answer
    assert b"evil" not in answer
    assert answer.count(b"HTTP/1.1 ") <= 1


def ask(server, line="GET /{token}/ HTTP/1.1", *fields, host="127.0.0.1:{port}", body=b""):
    head, body, token = request(line, *fields, host=host, body=body)
    return raw(server, head.replace("{port}", str(server.port)).replace("{token}", token).encode() + body)


def test_a_browser_gets_what_it_asks_for(server):
    answer = ask(server)
    assert (status(answer), answer.endswith(b"\r\n\r\n<p>page")) == (200, True)
    for field in (b"frame-ancestors 'none'", b"nosniff", b"no-referrer", b"no-store", b"same-origin"):
        assert field in answer
    assert status(ask(server, host="localhost:{port}")) == 200
    assert ask(server, "GET /{token}/events HTTP/1.1").endswith(b"data: 1\n\n")
    assert ask(server, "GET /{token}/echo?name=a%20b HTTP/1.1").endswith(b'{"name":"a b"}')
    assert ask(server, POST, OWN, JSON, TWO, body=b"{}").endswith(b"\r\n\r\n{}")


def test_one_connection_has_one_request(server):
    smuggled = b"GET /" + TOKEN.encode() + b"/echo HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    answer = ask(server, POST, OWN, JSON, TWO, body=b"{}" + smuggled)
    assert answer.count(b"HTTP/1.1 ") == 1


def test_a_defect_is_told_to_the_person_not_to_the_browser(server):
    answer = ask(server, "GET /{token}/broken HTTP/1.1")
    assert status(answer) == 500
    assert b"defect" not in answer
    assert [str(error) for error in server.told] == ["a defect"]


def test_a_thousand_slow_connections_do_not_stop_a_browser(server):
    slow = []
    try:
        for i in range(1000):
            client = socket.create_connection(("127.0.0.1", server.port), GUARD)
            client.sendall(b"GET /"[: 1 + i % 5])
            slow.append(client)
            if len(slow) > 400:  # of the limit of open files of this process
                slow.pop(0).close()
            if i % 200 == 0:
                assert status(ask(server)) == 200
        assert status(ask(server)) == 200
        assert len(server._connections) <= MOST_CONNECTIONS
    finally:
        for client in slow:
            client.close()


def test_known_browsers_are_not_replaced_by_strangers(server):
    """A browser that reads its answer slowly keeps its connection, however many others knock."""
    line = f"GET /{TOKEN}/big HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode()
    with socket.create_connection(("127.0.0.1", server.port), GUARD) as browser:
        browser.sendall(line)
        assert browser.recv(9) == b"HTTP/1.1 "
        strangers = [socket.create_connection(("127.0.0.1", server.port), GUARD) for _ in range(MOST_CONNECTIONS + 20)]
        size = 9
        while part := browser.recv(1 << 20):
            size += len(part)
        for stranger in strangers:
            stranger.close()
    assert size > 30_000_000


def test_a_request_that_never_ends_is_dropped(monkeypatch):
    monkeypatch.setattr("rocs_bt.studio.server._REQUEST_TIME", 0.1)
    server = Server("127.0.0.1", 0, TOKEN, ROUTES)
    server.start()
    with socket.create_connection(("127.0.0.1", server.port), GUARD) as slow:
        stop = threading.Event()

        def drip():
            while not stop.wait(0.02):
                try:
                    slow.sendall(b"X: a\r\n")
                except OSError:
                    return

        slow.sendall(b"GET / HTTP/1.1\r\n")
        threading.Thread(target=drip).start()
        with suppress(ConnectionResetError):
            assert slow.recv(1) == b""
        stop.set()
    server.end()


def test_a_browser_that_does_not_read_is_dropped(monkeypatch):
    monkeypatch.setattr("rocs_bt.studio.server._STALLED", 0.1)
    server = Server("127.0.0.1", 0, TOKEN, ROUTES)
    server.start()
    with socket.create_connection(("127.0.0.1", server.port), GUARD) as deaf:
        deaf.sendall(f"GET /{TOKEN}/big HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
        assert deaf.recv(1)
        until(lambda: not server._connections)
    server.end()


def test_the_end_does_not_wait_for_strangers():
    server = Server("127.0.0.1", 0, TOKEN, ROUTES)
    server.start()
    with socket.create_connection(("127.0.0.1", server.port), GUARD):
        begin = time.monotonic()
        server.end()
        assert time.monotonic() - begin < GUARD


def test_a_stream_ends_when_its_browser_has_gone():
    ended = threading.Event()

    async def forever():
        try:
            while True:
                yield b"data: 1\n\n"
                await asyncio.sleep(0.001)
        finally:
            ended.set()

    server = Server("127.0.0.1", 0, TOKEN, {("GET", "events"): lambda _: Answer(forever(), "text/event-stream")})
    server.start()
    with socket.create_connection(("127.0.0.1", server.port), GUARD) as client:
        client.sendall(f"GET /{TOKEN}/events HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
        assert client.recv(100)
    assert ended.wait(GUARD)
    server.end()


@pytest.mark.filterwarnings("error")
def test_the_end_closes_connections_in_every_state():
    """Also those that were accepted in the moment of the end: a connection that is left open is an error here."""
    for sent in (b"", b"GET /", f"GET /{TOKEN}/ HTTP/1.1\r\nHost: 127.0.0.1:{{}}\r\n\r\n".encode()) * 3:
        server = Server("127.0.0.1", 0, TOKEN, ROUTES)
        server.start()
        clients = [socket.create_connection(("127.0.0.1", server.port), GUARD) for _ in range(20)]
        for client in clients[::2]:
            client.sendall(sent.replace(b"{}", str(server.port).encode()))
        for client in clients[1::2]:
            client.close()
        for client in clients[::4]:
            client.close()
        server.end()
        for client in clients:
            client.close()
        del server
        gc.collect()
