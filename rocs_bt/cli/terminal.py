"""Output to a terminal that may have been closed meanwhile, as where an ssh session breaks off."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def perhaps_closed() -> Iterator[None]:
    """What is printed in here, and what stdout still holds, goes nowhere if the terminal is gone."""
    try:
        yield
    except OSError as error:
        if error.errno != errno.EIO:
            raise
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        os.close(nowhere)
