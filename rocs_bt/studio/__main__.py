"""Server process of a live page: reads a run's events from standard input, and sends it the browsers' commands."""

from __future__ import annotations

import signal
import sys

from ..base.errors import InputError
from . import frames
from .feed import Feed
from .server import Server
from .site import live_routes


def main() -> None:
    """Serve the page until standard input ends, because the run's process has closed it or died."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the run, which then closes the pipe
    stream, feed, back = sys.stdin.buffer, Feed(control=True), frames.Sender(sys.stdout.buffer)
    settings = frames.decode(frames.read(stream) or b"", frames.Settings)
    routes = live_routes(feed, lambda command: back.send(frames.encode(command)))
    try:
        server = Server(settings.host, settings.port, settings.token, routes)
    except InputError as error:
        back.send(frames.encode(frames.PageReply(error=str(error))))
        return
    server.start()
    back.send(frames.encode(frames.PageReply(url=server.url)))
    frames.receive(stream, feed)
    feed.close()
    server.end()


if __name__ == "__main__":
    main()
