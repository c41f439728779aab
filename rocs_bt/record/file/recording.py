"""Reader of recordings: header, events in exact order, and the summary if the run completed."""

from __future__ import annotations

import os
import struct
import weakref
import zlib
from collections.abc import Collection, Generator, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple, TypeVar

import lz4.frame
import msgspec
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from ...base.errors import InputError, KnowledgeError, RecordingError, unknown
from ...base.files import open_regular
from ...base.nesting import check_nesting
from ...event import Event, SensorRead, SignalsWritten
from . import codec
from .header import RunHeader
from .recorder import FORMAT, HEADER, SUMMARY
from .summary import Summary
from .wire import Incoming

R = TypeVar("R")

_RECORD = struct.Struct("<BQ")  # opcode, length
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_LARGEST = 1 << 28  # maximum size of a chunk [bytes]; chunks of the recorder have about 1 << 20 bytes


class _Span(NamedTuple):
    """Part of a file: first byte, and length [bytes]."""

    at: int
    length: int


@dataclass
class _Contents:
    """Records found in a recording file."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    chunks: list[_Span] = field(default_factory=list)
    complete: bool = False
    summary: Summary | None = None
    damage: str = ""
    end: float = 0.0
    read: int = len(MCAP0_MAGIC)  # number of bytes that were read


def _near(path: Path) -> set[str]:
    """Run folders to suggest for a path without a recording: inside it, beside it and in runs/."""
    return {str(file.parent) for folder in (path, path.parent, Path("runs")) for file in folder.glob("*/run.mcap")}


class Recording:
    """Recording of a run. A file that is cut off or damaged is read up to there.

    Attributes:
        path: Recording file.
        header: Header, written before the run started.
        summary: Summary of the run; None if the run did not complete.
    """

    def __init__(self, path: Path, file: BinaryIO, header: RunHeader, contents: _Contents) -> None:
        self.path = path
        self._file = file  # open, because another run may replace the file
        weakref.finalize(self, file.close)
        self.header = header
        self.summary = contents.summary
        self._contents = contents
        self._fresh = _Decoder(path, codec.KINDS)
        self._taken = 0  # chunks that `fresh` has read

    @classmethod
    def open(cls, path: str | Path) -> Recording:
        """Open a recording.

        Args:
            path: Recording file, or a folder that contains `run.mcap`.

        Raises:
            RecordingError: The file does not exist, was not written by rocs_bt, or is damaged in its header.
        """
        path = Path(path)
        file = path / "run.mcap" if path.is_dir() else path
        try:
            opened = open_regular(file)
        except FileNotFoundError as error:
            raise RecordingError(str(unknown("recording", str(path), _near(path)))) from error
        except OSError as error:
            raise RecordingError(f"the recording '{file}' cannot be read: {error.strerror}.") from error
        try:
            header, contents = _opened(opened, file)
        except BaseException:  # raised again, after the file is closed
            opened.close()
            raise
        return cls(file, opened, header, contents)

    @property
    def complete(self) -> bool:
        """Whether the file is complete, and no damage has been found in it; that of a killed run is not complete."""
        return self._contents.complete and not self.damage

    @property
    def damage(self) -> str:
        """Fault of the file behind its readable part; empty if none has been found so far."""
        return self._contents.damage

    @property
    def missing(self) -> str:
        """Sentence about the end of a file that is not complete; empty for a complete one."""
        if self.complete:
            return ""
        fault = self.damage.rstrip(".") or f"the recording '{self.path}' was cut off"
        return f"{fault}; it is read up to t = {max(self._contents.end, self.header.start):.2f} s."

    def events(self, only: Collection[type[Event]] = ()) -> Iterator[Event]:
        """Events in the order of emission, up to the end or the damage.

        Args:
            only: Kinds of events to read; all kinds by default.
        """
        decoder = _Decoder(self.path, only or codec.KINDS)
        for span in self._contents.chunks:
            if not (yield from self._of_chunk(span, decoder)):
                return

    def fresh(self) -> list[Event]:
        """Events since the last call, with those that the process of the run has written meanwhile."""
        contents = self._contents
        if self._taken == len(contents.chunks) and not contents.complete and not self.damage:
            _walk(self._file, self.path, contents)
        spans, self._taken = contents.chunks[self._taken :], len(contents.chunks)
        return [event for span in spans for event in self._of_chunk(span, self._fresh)]

    def _of_chunk(self, span: _Span, decoder: _Decoder) -> Generator[Event, None, bool]:
        """Events of a chunk up to its end or damage; returns whether it is not damaged."""
        try:
            yield from decoder.events(_chunk(_read(self._file, span, self.path), self.path, span.at)[1])
        except RecordingError as error:
            self._contents.damage, self._contents.end = str(error), decoder.time / 1e9
            return False
        return True


class _Decoder:
    """Decodes the events of chunks, in their order.

    Attributes:
        time: Time of the last message [ns].
    """

    def __init__(self, path: Path, only: Collection[type[Event]]) -> None:
        self._path = path
        self._kinds = frozenset(only)
        # Signals repeat readings.
        read = self._kinds | {SensorRead} if SignalsWritten in self._kinds else self._kinds
        self._known = {codec.SCHEMA_PREFIX + kind.__name__ for kind in read}
        self._schemas: dict[int, str] = {}
        self._wanted = set[int]()
        self._incoming = Incoming()
        self.time = 0

    def events(self, chunk: bytes) -> Iterator[Event]:
        """Events of the next chunk; raises RecordingError."""
        for opcode, body in _records(chunk):
            if opcode == Opcode.MESSAGE and len(body) >= _MESSAGE.size:
                channel_id, _, self.time, _ = _MESSAGE.unpack_from(body)
                # Others are messages for viewers, and events of kinds that a user added.
                if channel_id in self._wanted:
                    try:
                        event = self._incoming.event(codec.decode(body[_MESSAGE.size :]))
                    except RecordingError as error:
                        raise RecordingError(f"'{self._path}' is damaged: {error}") from error
                    if type(event) in self._kinds:
                        yield event
            elif opcode == Opcode.SCHEMA:
                schema = _parsed(Schema, body, self._path)
                self._schemas[schema.id] = schema.name
            elif opcode == Opcode.CHANNEL:
                channel = _parsed(Channel, body, self._path)
                if _kind(self._schemas.get(channel.schema_id, "")) in self._known:
                    self._wanted.add(channel.id)


def _kind(schema: str) -> str:
    """Name of a schema without the agent and the device for which it names the numbers."""
    return ".".join(schema.split(".")[:2])


def _opened(opened: BinaryIO, file: Path) -> tuple[RunHeader, _Contents]:
    """Header and records of a file; raises RecordingError."""
    begin = _read(opened, _Span(0, len(MCAP0_MAGIC)), file)
    if begin != MCAP0_MAGIC:
        found = "it is empty" if not begin else f"it begins with {begin!r}"
        raise RecordingError(f"'{file}' is not an MCAP recording: {found}. Give the run.mcap of a run.")
    contents = _Contents()
    _walk(opened, file, contents)
    version = contents.metadata.get("rocs_bt", {}).get("format")
    if version is not None and version != FORMAT:
        raise RecordingError(f"'{file}' has format {version}; this version of rocs_bt reads format {FORMAT}.")
    if version is None or HEADER not in contents.attachments:
        if contents.damage:
            raise RecordingError(contents.damage)
        cut = "is cut off within its header" if not contents.complete else "was not written by rocs_bt"
        raise RecordingError(f"'{file}' {cut} and cannot be read. Run the scenario again.")
    try:
        header = _decoded(contents.attachments[HEADER], RunHeader)
        header.check()
    except (msgspec.MsgspecError, ValueError, InputError, KnowledgeError) as error:
        raise RecordingError(f"the header of '{file}' cannot be read: {str(error).rstrip('.')}.") from error
    try:
        if SUMMARY in contents.attachments:
            contents.summary = _decoded(contents.attachments[SUMMARY], Summary)
    except (msgspec.MsgspecError, ValueError, InputError) as error:
        contents.damage = f"the summary in '{file}' cannot be read: {str(error).rstrip('.')}."
    return header, contents


def _decoded(attachment: bytes, kind: type[R]) -> R:
    check_nesting(attachment)
    return msgspec.json.decode(attachment, type=kind)


def _read(opened: BinaryIO, span: _Span, file: Path) -> bytes:
    """Bytes of a part of a file; raises RecordingError."""
    try:
        opened.seek(span.at)
        return opened.read(span.length)
    except (OSError, MemoryError) as error:
        why = getattr(error, "strerror", None) or "out of memory"
        raise RecordingError(f"the recording '{file}' cannot be read: {why}.") from error


def _walk(opened: BinaryIO, file: Path, contents: _Contents) -> None:
    """Read the next records of a file, up to the damage if there is any."""
    try:
        while not contents.complete and _record(opened, file, contents):
            pass
    except RecordingError as error:
        contents.damage = str(error)


def _record(opened: BinaryIO, file: Path, contents: _Contents) -> bool:
    """Read the next record of a file; returns whether there was one. Raises RecordingError.

    Of chunks it notes only the places, because a long run does not fit into memory.
    """
    size, at = os.fstat(opened.fileno()).st_size, contents.read
    if at + _RECORD.size > size:
        return False
    opcode, length = _RECORD.unpack(_read(opened, _Span(at, _RECORD.size), file))
    span = _Span(at + _RECORD.size, length)
    if opcode > max(Opcode):
        raise RecordingError(f"'{file}' is damaged: byte {at} is {opcode}, which is no MCAP opcode.")
    if opcode == 0 or span.at + length > size:
        return False  # zeros, left by a power failure; or cut off, or not yet written
    if opcode == Opcode.CHUNK:
        contents.end = _chunk(_read(opened, span, file), file, at)[0]
        contents.chunks.append(span)
    elif opcode == Opcode.ATTACHMENT:
        body = _read(opened, span, file)
        attachment = _parsed(Attachment, body, file)
        if zlib.crc32(body[:-4]) != struct.unpack("<I", body[-4:])[0]:
            raise RecordingError(f"'{file}' is damaged: the attachment at byte {at} has a wrong checksum.")
        contents.attachments[attachment.name] = attachment.data
    elif opcode == Opcode.METADATA:
        metadata = _parsed(Metadata, _read(opened, span, file), file)
        contents.metadata[metadata.name] = metadata.metadata
    elif opcode == Opcode.FOOTER:
        contents.complete = _read(opened, _Span(span.at + length, len(MCAP0_MAGIC) + 1), file) == MCAP0_MAGIC
        return contents.complete
    contents.read = span.at + length
    return True


def _chunk(body: bytes, file: Path, at: int) -> tuple[float, bytes]:
    """Time of the last event of a chunk [s], and its records, verified; raises RecordingError."""
    chunk = _parsed(Chunk, body, file)
    if chunk.compression not in ("", "lz4"):
        raise RecordingError(f"'{file}' has chunks compressed by '{chunk.compression}'; only lz4 is read here.")
    try:
        content = _content(chunk)
    except RuntimeError as error:
        raise RecordingError(f"'{file}' is damaged: the chunk at byte {at} cannot be decompressed.") from error
    if len(content) != chunk.uncompressed_size or zlib.crc32(content) != chunk.uncompressed_crc:
        raise RecordingError(f"'{file}' is damaged: the chunk at byte {at} has a wrong size or checksum.")
    return chunk.message_end_time / 1e9, content


def _content(chunk: Chunk) -> bytes:
    """Decompress the records of a chunk, up to the declared size; raises RuntimeError."""
    if not chunk.compression:
        return bytes(chunk.data)
    size = min(chunk.uncompressed_size, _LARGEST)
    content: bytes = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size)
    return content


def _records(chunk: bytes) -> Iterator[tuple[int, bytes]]:
    at, size = 0, len(chunk)
    while at + _RECORD.size <= size:
        opcode, length = _RECORD.unpack_from(chunk, at)
        at += _RECORD.size + length
        if at > size:
            return
        yield opcode, chunk[at - length : at]


def _parsed(kind: type[R], body: bytes, file: Path) -> R:
    """Parse a record of the MCAP container; raises RecordingError."""
    try:
        record: R = kind.read(ReadDataStream(BytesIO(body)))  # type: ignore[attr-defined]  # mcap's record types share no base class
    except (McapError, ValueError, struct.error) as error:
        raise RecordingError(f"'{file}' is damaged: a {kind.__name__} record cannot be read.") from error
    return record
