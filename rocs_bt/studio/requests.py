"""Requests and answers of the server: a strict reader of HTTP/1.1 for which each request has one meaning."""

from __future__ import annotations

import re
from collections.abc import AsyncGenerator, Callable, Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qsl

import msgspec

from ..base.errors import InputError

MOST_HEAD = 16_384
"""Maximum size of the head of a request [bytes]."""

MOST_BODY = 4_000_000
"""Maximum size of the body of a request [bytes]."""

Stream = AsyncGenerator[bytes, None]
"""Server-sent events."""

_LINE = re.compile(r"([A-Z]{1,16}) (/[!-~]*) HTTP/1\.[01]")
_FIELD = re.compile(r"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([\t -~]*)")
_ONCE = frozenset({"host", "origin", "content-length", "content-type", "sec-fetch-site", "expect"})
_MOST_FIELDS = 64
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


class RefusedError(Exception):
    """A request that the server does not take."""

    def __init__(self, status: HTTPStatus) -> None:
        self.status = status
        super().__init__(status.phrase)


class Request(msgspec.Struct, frozen=True):
    """One request."""

    method: str
    token: str  # first part of the path
    name: str  # rest of the path, which names a route
    query: Mapping[str, str]
    fields: Mapping[str, str]  # by name in lower case
    body: bytes = b""  # empty until it has been read

    @property
    def length(self) -> int:
        """Size of the body [bytes]."""
        return int(self.fields.get("content-length", "0"))

    def read(self, kind: type[Any]) -> Any:
        """The body, as JSON of a type.

        Raises:
            InputError: It has another form.
        """
        try:
            return msgspec.json.decode(self.body, type=kind)
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
            raise InputError(f"the request cannot be read: {error}.") from error


class Answer(msgspec.Struct, frozen=True):
    """Answer to a request."""

    body: bytes | Stream  # or the parts of a stream of server-sent events
    kind: str = "application/json"
    status: HTTPStatus = HTTPStatus.OK


Handler = Callable[[Request], Answer]
"""Function that answers a request, in a thread of its own."""

Routes = dict[tuple[str, str], Handler]
"""Handlers by method and path behind the token."""


def as_json(value: object) -> Answer:
    """Answer of a value as JSON."""
    return Answer(msgspec.json.encode(value))


def parse(head: bytes) -> Request:
    """Read the head of a request, with the empty line at its end.

    Raises:
        RefusedError: It is no request in the strict form of HTTP/1.1, or it is too long.
    """
    try:
        lines = head.decode("ascii").removesuffix("\r\n\r\n").split("\r\n")
    except UnicodeDecodeError:
        raise RefusedError(HTTPStatus.BAD_REQUEST) from None
    line = _LINE.fullmatch(lines[0])
    found = [_FIELD.fullmatch(each) for each in lines[1:]]
    if line is None or None in found:
        raise RefusedError(HTTPStatus.BAD_REQUEST)
    if len(found) > _MOST_FIELDS:
        raise RefusedError(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE)
    fields: dict[str, str] = {}
    for each in filter(None, found):
        name = each[1].lower()
        if name in fields and name in _ONCE:
            raise RefusedError(HTTPStatus.BAD_REQUEST)
        fields[name] = each[2].rstrip(" \t")
    _check_length(fields)
    path, _, query = line[2].partition("?")
    token, _, name = path[1:].partition("/")
    return Request(line[1], token, name, _parameters(query), fields)


def _check_length(fields: Mapping[str, str]) -> None:
    """Refuse a body without exactly one number as its length, because others could read another one."""
    if "transfer-encoding" in fields:
        raise RefusedError(HTTPStatus.NOT_IMPLEMENTED)
    if "expect" in fields:
        raise RefusedError(HTTPStatus.EXPECTATION_FAILED)
    length = fields.get("content-length", "0")
    if not re.fullmatch(r"[0-9]{1,12}", length):
        raise RefusedError(HTTPStatus.BAD_REQUEST)
    if int(length) > MOST_BODY:
        raise RefusedError(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)


def _parameters(query: str) -> dict[str, str]:
    if not query:
        return {}
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=True, errors="strict", max_num_fields=16)
    except ValueError:
        raise RefusedError(HTTPStatus.BAD_REQUEST) from None
    if len(dict(pairs)) < len(pairs) or any(_CONTROL.search(text) for pair in pairs for text in pair):
        raise RefusedError(HTTPStatus.BAD_REQUEST)
    return dict(pairs)
