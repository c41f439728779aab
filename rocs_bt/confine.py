"""Files that content names: whether they exist; and inside the project, or what we ship, wherever links lead."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from .errors import Fault, InputError


def confined(named: str | Path, folder: Path, roots: Iterable[Path]) -> Path:
    """The path of a file that content names.

    Args:
        named: The path in the content file, relative or absolute.
        folder: Folder that a relative path begins at.
        roots: Folders of which one must contain the file.

    Returns:
        The absolute path without links; nothing may exist there.

    Raises:
        InputError: The file is outside of all the folders, or the text is no path.
    """
    allowed = [root.resolve() for root in roots]
    try:
        path = (folder / named).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a ring of links, a NUL
        raise InputError(Fault(f"'{named}' is no path: {error}.")) from error
    if not any(path.is_relative_to(root) for root in allowed):
        where = " and ".join(f"'{root}'" for root in allowed)
        leads = "" if str(path) == os.path.normpath(folder.resolve() / named) else f", which leads to '{path}',"
        raise InputError(Fault(f"'{named}'{leads} is outside of {where}.", hint="Put the file into the project."))
    return path


def is_file(path: Path) -> bool:
    """Whether there is a file of this path; False too if its name is too long, for which `Path.is_file` raises."""
    return os.path.isfile(path)
