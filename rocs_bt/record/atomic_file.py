"""Atomic writing of files."""

from __future__ import annotations

import os
import shutil
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a text file atomically: an existing file is replaced only when the new one is complete; its mode stays.

    Args:
        path: File to write; its folder must exist.
        text: Text, written as UTF-8.

    Raises:
        OSError: The file cannot be written, as on a full disk; no partial file remains.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8")
        if path.exists():
            shutil.copymode(path, part)
        part.replace(path)
    except BaseException:  # remove the partial file, then raise again
        part.unlink(missing_ok=True)
        raise
