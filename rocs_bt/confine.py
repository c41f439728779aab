"""Check that file paths in missions, robots and other content do not lead out of the allowed folders."""

from __future__ import annotations

import os
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
        where = " and ".join(f"'{root}'" for root in dict.fromkeys(allowed))
        leads = "" if str(path) == os.path.normpath(folder.resolve() / named) else f", which leads to '{path}',"
        raise InputError(Fault(f"'{named}'{leads} is outside of {where}.", hint="Move the file into the project."))
    return path
