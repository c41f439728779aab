"""Files that are written as a whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a text file in one step: until the text is complete, an earlier file of that name stays as it is.

    Args:
        path: The file; its folder must exist.
        text: Its text, written as UTF-8.

    Raises:
        OSError: It cannot be written, as on a full disk; nothing is left behind.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except BaseException:  # raised again, after the file is removed
        part.unlink(missing_ok=True)
        raise
