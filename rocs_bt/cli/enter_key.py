"""The Enter key as the go of `rocs-bt drive`, read from stdin without waiting."""

from __future__ import annotations

import os
import select
import sys


class EnterKey:
    """Function that returns whether a line was entered since its last call; False if stdin cannot be read."""

    def __init__(self) -> None:
        try:
            self._stdin = sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):  # no stdin, a stub, or closed
            self._stdin = -1

    def __call__(self) -> bool:
        """Read what was typed."""
        try:
            if self._stdin < 0 or not self._foreground or not select.select([self._stdin], [], [], 0.0)[0]:
                return False
            typed = os.read(self._stdin, 4096)
        except OSError:  # the terminal was closed; Windows can select sockets only
            typed = b""
        if not typed:
            self._stdin = -1
        return b"\n" in typed

    @property
    def _foreground(self) -> bool:
        """Whether this process may read its terminal; the system would stop a background process that reads it."""
        return not os.isatty(self._stdin) or os.tcgetpgrp(self._stdin) == os.getpgrp()
