"""Recorder: event sink that writes run.mcap."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import msgspec
from mcap.writer import CompressionType, Writer

from ...base.errors import RecordingError
from ...base.files import create
from ...event import Event
from . import codec, foxglove
from .foxglove_messages import Draw, FoxgloveMessages, Message
from .header import RunHeader
from .summary import Summary
from .wire import FORMS, Outgoing, device_of

FORMAT = "1"
HEADER, SUMMARY = "header.json", "summary.json"
_FLUSH_EVERY = 500_000_000  # [ns] flush period in run time; a killed run may lose the events of one period
_BATCH = 256  # events encoded together, at half the cost of encoding them one by one
_LATEST = 2**64 - 1  # [ns]


class Recorder:
    """Writes events to an MCAP file, stamped with run time, together with messages for viewers.

    Thread-safe. Equal events give equal bytes. The file of a killed process can be read up to at most half a second
    of run time before its last event.

    Args:
        path: File to write; its folder must exist.
        header: Header of the run.

    Raises:
        RecordingError: The file cannot be written.
    """

    def __init__(self, path: Path, header: RunHeader) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._viewer = FoxgloveMessages(header)
        self._channels: dict[tuple[type, str, str], tuple[int, Draw | None]] = {}
        self._drawn: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._waiting: deque[Event] = deque()
        self._outgoing = Outgoing({agent.name: agent.axes for agent in header.agents})
        self._signals = {agent.name: [(s.name, s.size) for s in agent.signals] for agent in header.agents}
        self._sequence = 0
        self._last = self._flush_at = round(header.start * 1e9)  # [ns]
        self._disk = ""
        self._unfit: list[str] = []
        self._closed = False
        try:
            self._file = create(path)
            self._writer = Writer(self._file, compression=CompressionType.LZ4)
            self._begin(header)
        except OSError as error:
            raise RecordingError(f"the recording '{path}' cannot be written: {error.strerror}.") from error

    def emit(self, event: Event) -> None:
        """Record one event. Never raises; errors are reported by `close`."""
        self._waiting.append(event)  # thread-safe without a lock
        self._encode_if_due(event)

    def take(self, events: Sequence[Event]) -> None:
        """Record several events in order. Never raises; errors are reported by `close`."""
        self._waiting.extend(events)
        self._encode_if_due(events[-1])

    def close(self, summary: Summary | None = None) -> None:
        """End the recording; the second call does nothing.

        Args:
            summary: Summary of the run, stored in the recording.

        Raises:
            RecordingError: Some events could not be recorded; the file contains all others.
        """
        with self._lock:
            if self._closed:
                return
            self._encode()
            self._closed = True
            if not self._disk:
                try:
                    self._finish(summary)
                except OSError as error:
                    self._give_up(error)
        if self._disk:
            raise RecordingError(
                f"the recording '{self.path}' ends early, at t = {self._last * 1e-9:.3f} s: {self._disk}."
            )
        if self._unfit:
            first, count = self._unfit[0], len(self._unfit)
            raise RecordingError(f"{count} events could not be recorded in '{self.path}'; the first: {first}.")

    def _begin(self, header: RunHeader) -> None:
        run = {"format": FORMAT, "scenario": header.scenario, "seed": str(header.seed), "mode": header.mode}
        try:
            self._writer.start(library="rocs_bt")
            self._writer.add_metadata("rocs_bt", run)
            self._attach(HEADER, msgspec.json.encode(header))
            self._show(self._viewer.scene(self._last), self._last)
            self._writer.flush()
        except OSError as error:
            self._give_up(error)
            raise

    def _encode_if_due(self, newest: Event) -> None:
        """Record the waiting events if the batch is full or a flush is due."""
        try:
            due = newest.t * 1e9 + 0.5 >= self._flush_at
        except TypeError:  # the time is no number; reported by `_encode`
            due = True
        if due or len(self._waiting) >= _BATCH:
            with self._lock:
                self._encode()

    def _encode(self) -> None:
        """Record the waiting events. The caller holds the lock; other threads may append further events."""
        waiting = [self._waiting.popleft() for _ in range(len(self._waiting))]
        if self._closed or self._disk or not waiting:
            return
        for event, form, data in self._encoded(waiting):
            try:
                self._write(event, form, data or codec.encode(form))
                # Checked after each event, so that chunks do not depend on the size of batches.
                if self._last >= self._flush_at:
                    self._flush_at = self._last + _FLUSH_EVERY
                    self._writer.flush()
            except codec.UNFIT as error:
                self._unfit.append(f"{type(event).__name__} at t = {event.t} s: {error}")
            except OSError as error:
                self._give_up(error)
                return

    def _encoded(self, events: list[Event]) -> Iterator[tuple[Event, Event | FORMS, bytes | None]]:
        """Events, their forms, and the encoded forms; None for each that must be encoded alone."""
        try:
            forms = [self._outgoing.form(event) for event in events]
        except codec.UNFIT:  # an event with unsupported values, which is found when it is encoded
            forms = [*events]
        lines = codec.encode_all(forms)
        if not any(lines):  # some event is unfit, and may be the reading that others repeat
            self._outgoing.forget()
            forms = [*events]
        return zip(events, forms, lines, strict=True)

    def _write(self, event: Event, form: Event | FORMS, data: bytes) -> None:
        time = int(event.t * 1e9 + 0.5)
        if not 0 <= time <= _LATEST:
            raise ValueError(f"its time, {time * 1e-9:g} s, is out of range")
        part = device_of(form)
        channel, draw = self._channels.get((type(form), event.agent, part)) or self._open(event, form, part)
        self._writer.add_message(channel, time, data, time, self._sequence)
        self._sequence += 1
        self._last = max(self._last, time)
        if draw is not None:
            for message in draw(event, time):
                self._show(message, time)

    def _attach(self, name: str, data: bytes) -> None:
        self._writer.flush()
        self._writer.add_attachment(0, self._last, name, "application/json", data)

    def _finish(self, summary: Summary | None) -> None:
        if summary is not None:
            self._attach(SUMMARY, msgspec.json.encode(summary, enc_hook=codec.plain))
        self._writer.finish()
        self._file.close()

    def _give_up(self, error: OSError) -> None:
        """Stop recording after a write error; the part that is on disk stays readable."""
        self._disk = error.strerror or str(error)
        self._file.raw.close()  # drops the buffer, for which there is no space

    def _open(self, event: Event, form: Event | FORMS, part: str) -> tuple[int, Draw | None]:
        kind = type(event)
        name = codec.SCHEMA_PREFIX + kind.__name__
        if isinstance(form, FORMS):
            name += f".{event.agent}" + (f".{part}" if part else "")
        described = partial(codec.schema_of, form, self._signals.get(event.agent, ()))
        channel = self._channel(codec.topic_of(kind, event.agent) + (f"/{part}" if part else ""), name, described)
        found = self._channels[type(form), event.agent, part] = channel, self._viewer.converter(kind)
        return found

    def _show(self, message: Message, time: int) -> None:
        topic, schema, data = message
        if topic not in self._drawn:
            self._drawn[topic] = self._channel(topic, schema, lambda: foxglove.schema(schema))
        self._writer.add_message(self._drawn[topic], time, data, time, self._sequence)

    def _channel(self, topic: str, schema: str, described: Callable[[], bytes]) -> int:
        """Declare a channel of JSON messages, and its schema if it is new; returns the channel's number."""
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", described())
        number: int = self._writer.register_channel(topic, "json", self._schemas[schema])
        return number
