"""Writing an MCAP file, fast and always readable: messages in uncompressed chunks, each written in one piece.

The records are those of the `mcap` package; only messages, which come by the thousand, are packed here, many at once.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_CHUNK = struct.Struct("<BQQQQIIQ")  # opcode, length, first and last time, size, its sum, no compression, size
_OPCODE = int(Opcode.MESSAGE)  # a plain number packs several times faster than an enumeration's
_HEAD = _MESSAGE.size
_OVERHEAD = _HEAD - 9  # what the length counts besides the data
_LATEST = 2**64 - 1  # [ns]

Message = tuple[int, int, int, bytes]
"""Channel, sequence, time [ns], data."""


class Container:
    """One MCAP file being written.

    Nothing is buffered but the chunk in progress, so what was flushed survives the death of the process.

    Args:
        path: The file; replaced if it exists.
        library: Who writes it.

    Attributes:
        size: How many bytes the chunk in progress holds.

    Raises:
        OSError: It cannot be written; so does each method that writes.
    """

    def __init__(self, path: Path, library: str) -> None:
        self._file = path.open("wb", buffering=0)
        self._offset = 0
        self._chunk: list[bytes] = []
        self._messages: list[Message] = []  # that come after it
        self._place = 0  # where they do
        self.size = 0
        self._index: dict[int, list[int]] = {}
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        try:
            self._write(MAGIC + _bytes(Header("", library)))
        except OSError:
            self._file.close()
            raise

    def schema(self, name: str, data: bytes) -> int:
        """Declare a JSON schema; returns its number."""
        self._schemas.append(Schema(id=len(self._schemas) + 1, name=name, encoding="jsonschema", data=data))
        self._append(_bytes(self._schemas[-1]))
        return len(self._schemas)

    def channel(self, topic: str, schema: int) -> int:
        """Declare a channel of JSON messages; returns its number."""
        number = len(self._channels) + 1
        self._channels.append(Channel(id=number, topic=topic, message_encoding="json", metadata={}, schema_id=schema))
        self._append(_bytes(self._channels[-1]))
        self._index[number] = []
        self._counts[number] = 0
        return number

    def message(self, channel: int, sequence: int, time: int, data: bytes) -> None:
        """Add a message to the chunk in progress.

        Args:
            channel: The number that `channel` gave.
            sequence: Its number in the whole run.
            time: When it happened [ns].
            data: JSON.

        Raises:
            ValueError: The time is one that no recording can hold.
        """
        if not 0 <= time <= _LATEST:
            raise ValueError(f"its time is {time * 1e-9:g} s, which a recording cannot hold")
        self._messages.append((channel, sequence, time, data))
        self.size += len(data) + _HEAD

    def attach(self, name: str, data: bytes, time: int) -> None:
        """Write a JSON attachment, after all messages so far."""
        self.flush()
        record = Attachment(create_time=0, log_time=time, name=name, media_type="application/json", data=data)
        written = _bytes(record)
        self._attachments.append(
            AttachmentIndex(self._offset, len(written), time, 0, len(data), name, record.media_type)
        )
        self._write(written)

    def note(self, name: str, entries: Mapping[str, str]) -> None:
        """Write a metadata record, after all messages so far."""
        self.flush()
        written = _bytes(Metadata(name=name, metadata=dict(entries)))
        self._metadata.append(MetadataIndex(self._offset, len(written), name))
        self._write(written)

    def flush(self) -> None:
        """Hand the chunk in progress to the operating system."""
        self._settle()
        times = [time for entries in self._index.values() for time in entries[::2]]
        if not times:
            return
        data = b"".join(self._chunk)
        first, last = min(times), max(times)
        # Uncompressed, as mcap writes it, but without the copies that it makes of the data on the way.
        whole, begin = _CHUNK.size + len(data), self._offset
        head = _CHUNK.pack(Opcode.CHUNK, whole - 9, first, last, len(data), zlib.crc32(data), 0, len(data))
        at, offsets, indexes = begin + whole, {}, []
        for channel, entries in self._index.items():
            if entries:
                offsets[channel] = at
                size = 8 * len(entries)
                indexes.append(
                    struct.pack(f"<BQHI{len(entries)}Q", Opcode.MESSAGE_INDEX, 6 + size, channel, size, *entries)
                )
                at += len(indexes[-1])
                self._counts[channel] += len(entries) // 2
                self._index[channel] = []
        length = at - begin - whole
        self._chunks.append(ChunkIndex(whole, begin, "", len(data), last, length, offsets, first, len(data)))
        self._chunk, self._place, self.size = [], 0, 0
        self._write(b"".join((head, data, *indexes)))

    def finish(self) -> None:
        """Write the summary section and close the file."""
        self.flush()
        self._write(_bytes(DataEnd(0)))
        groups: tuple[tuple[Opcode, list[bytes]], ...] = (
            (Opcode.SCHEMA, [_bytes(r) for r in self._schemas]),
            (Opcode.CHANNEL, [_bytes(r) for r in self._channels]),
            (Opcode.STATISTICS, [_bytes(self._statistics())]),
            (Opcode.CHUNK_INDEX, [_bytes(r) for r in self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [_bytes(r) for r in self._attachments]),
            (Opcode.METADATA_INDEX, [_bytes(r) for r in self._metadata]),
        )
        start, summary, offsets = self._offset, b"", b""
        for opcode, records in groups:
            data = b"".join(records)
            offsets += _bytes(SummaryOffset(opcode, start + len(summary), len(data))) if data else b""
            summary += data
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, start + len(summary))
        crc = zlib.crc32(footer, zlib.crc32(summary + offsets))
        self._write(summary + offsets + _bytes(Footer(start, start + len(summary), crc)) + MAGIC)
        self._file.close()

    def abandon(self) -> None:
        """Close the file as it is; what was flushed stays readable."""
        self._file.close()

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_end_time=max((c.message_end_time for c in self._chunks), default=0),
            message_start_time=min((c.message_start_time for c in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _settle(self) -> None:
        """Put the messages into the chunk, and into its index."""
        if self._messages:
            data = chunked(self._messages, self._place, self._index)
            self._chunk.append(data)
            self._place += len(data)
            self._messages = []

    def _append(self, data: bytes) -> None:
        self._settle()
        self._chunk.append(data)
        self._place += len(data)
        self.size += len(data)

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            # An unbuffered file may take less than all, as on a disk that is nearly full.
            written = self._file.write(view) or 0
            view = view[written:]
            self._offset += written


def chunked(messages: Sequence[Message], begin: int, index: dict[int, list[int]]) -> bytes:
    """Messages as they stand in a chunk, one after the other.

    Args:
        messages: What they are.
        begin: Where in the chunk the first one begins.
        index: By channel, to which the time and the place of each message are added.
    """
    parts: list[bytes] = []
    place = begin
    for channel, sequence, time, data in messages:
        index[channel] += (time, place)
        parts += (_MESSAGE.pack(_OPCODE, len(data) + _OVERHEAD, channel, sequence, time, time), data)
        place += len(data) + _HEAD
    return b"".join(parts)


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap has no types
