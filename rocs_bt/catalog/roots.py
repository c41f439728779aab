"""Where content is: the folder that we ship, and the project around a folder."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path

from ..confine import confined
from ..errors import RocsError
from ..python_content import is_reference
from .entry import KINDS


def shipped_root() -> Path:
    """The folder that holds the content we ship: inside a wheel's package, or a checkout's root.

    Raises:
        RocsError: This installation has no content.
    """
    package = Path(__file__).resolve().parent.parent
    if (inside := package / "_content").is_dir():
        return inside
    # Never trust what lies beside the package before its pyproject says that this is our checkout.
    pyproject = package.parent / "pyproject.toml"
    if pyproject.is_file() and tomllib.loads(pyproject.read_text("utf-8")).get("project", {}).get("name") == "rocs_bt":
        return package.parent
    raise RocsError(f"no content was found in {inside}, and {package.parent} is no checkout. Install rocs_bt again.")


def find_project(start: Path) -> Path | None:
    """The nearest folder, from `start` upwards, that has content of its own; None where there is none."""
    start = start.resolve()
    for folder in (start, *start.parents):
        if any(next(folder.glob(pattern), None) for patterns in KINDS.values() for pattern in patterns):
            return folder
    return None


def is_path(name: str) -> bool:
    """Whether a person means a file by this rather than a name."""
    return "/" in name or name.endswith((".toml", ".xml", ".py"))


def confine_name(name: str, roots: tuple[Path, ...], own: Path) -> None:
    """Refuse the path of other content in a content file, unless it is inside the project.

    Args:
        name: A path, or `file.py:Class`, which is looked for in the folders' `planners` first.
        roots: The folders whose content may be named.
        own: The folder of the project of the naming file.

    Raises:
        InputError: It is outside.
    """
    path = name.partition(":")[0]
    if is_reference(name) and not Path(path).is_absolute():
        for root in roots:
            if os.path.isfile(root / "planners" / path):
                confined(path, root / "planners", (root,))
                return
    confined(path, Path(), (*roots, own))
