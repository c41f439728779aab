"""Server process of a live page: reads a run's events from standard input and serves their state."""

from __future__ import annotations

import signal
import sys
import threading

from ..errors import InputError
from ..record import RunHeader
from . import frames
from .feed import Feed
from .server import Server


def main() -> None:
    """Serve the page until standard input ends, because the run's process has closed it or died."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the run, which then closes the pipe
    stream, feed = sys.stdin.buffer, Feed()
    settings = frames.decode(frames.read(stream) or b"", frames.Settings)
    try:
        server = Server(settings.host, settings.port, settings.token, feed)
    except InputError as error:
        _answer(frames.Answer(error=str(error)))
        return
    threading.Thread(target=server.serve_forever, name="http", daemon=True).start()
    _answer(frames.Answer(port=server.server_port))
    if (header := frames.read(stream)) is not None:
        feed.begin(frames.decode(header, RunHeader))
    while (data := frames.read(stream)) is not None:
        feed.take(frames.decode_events(data))
    server.end()


def _answer(answer: frames.Answer) -> None:
    sys.stdout.buffer.write(frames.encode(answer))
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
