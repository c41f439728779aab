"""Copies of shipped content in a project."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from ..base.errors import Fault, InputError
from ..base.files import confined, new_folder, read_bytes, write_whole
from .catalog import Catalog


def copy_content(catalog: Catalog, kind: str, name: str) -> Path:
    """Copy shipped content into the project, where it hides the shipped content of this name.

    What the copy names, such as the world of a scenario, stays shipped.

    Returns:
        File of the copy.

    Raises:
        InputError: There is no project, no such content, or the project has a file of this name.
        OSError: A file cannot be written.
    """
    project, entry = catalog.project, catalog.find(kind, name)
    if project is None:
        hint = "Create a project with `rocs-bt new my_project`, and do this inside it."
        raise InputError(Fault("there is no project to copy content into.", hint=hint))
    if entry.origin != "shipped":
        raise InputError(Fault(f"the {kind} '{name}' is not shipped with rocs_bt.", entry.path))
    tests = catalog.shipped / "rules/tests" / entry.path.name
    sources = [*entry.files(), *([tests] if kind == "rules" and tests.is_file() else [])]
    files = {file: confined(file.relative_to(catalog.shipped), project, (project,)) for file in sources}
    own = files[entry.path]
    if taken := [path for path in files.values() if path.exists()]:
        raise InputError(Fault(f"the project has a file '{taken[0]}' already.", hint="Rename it first."))
    with ExitStack() as stack:
        own.parent.mkdir(parents=True, exist_ok=True)
        if kind == "robot":
            stack.enter_context(new_folder(own.parent))
        for source, target in files.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, read_bytes(source))
    return own
