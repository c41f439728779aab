"""Check that file paths in missions, robots and other content do not lead out of the allowed folders."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterable
from pathlib import Path

from .errors import Fault, InputError


def confined(named: str | Path, folder: Path, roots: Iterable[Path]) -> Path:
    """Resolve a path in a content file and check that it is inside one of the roots.

    Args:
        named: Path in the content file, relative or absolute.
        folder: Base folder of a relative path.
        roots: Allowed folders.

    Returns:
        Absolute path with links resolved; the file need not exist.

    Raises:
        InputError: The file is outside all roots, or the text is not a valid path.
    """
    allowed = [root.resolve() for root in roots]
    try:
        path = (folder / named).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a cycle of links, a NUL
        raise InputError(Fault(f"'{named}' is not a valid path: {error}.")) from error
    if not any(path.is_relative_to(root) for root in allowed):
        where = " and ".join(f"'{root}'" for root in allowed)
        leads = "" if str(path) == os.path.normpath(folder.resolve() / named) else f", which leads to '{path}',"
        raise InputError(Fault(f"'{named}'{leads} is outside of {where}.", hint="Move the file into the project."))
    return path


def file_bytes(path: Path) -> bytes:
    """Content of a regular file; others, such as a named pipe, could block for ever.

    Raises:
        OSError: The file cannot be read, or is not a regular file.
    """
    if not stat.S_ISREG(path.stat().st_mode) and not path.is_dir():
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    return path.read_bytes()


def file_text(path: Path) -> str:
    """Text of a regular file in UTF-8, with line ends as in Python.

    Raises:
        OSError: The file cannot be read, or is not a regular file.
        UnicodeDecodeError: The file is not UTF-8.
    """
    return file_bytes(path).decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")


def is_file(path: Path) -> bool:
    """Whether a file exists. Unlike `Path.is_file`, this does not raise an error if the name is too long."""
    return os.path.isfile(path)
