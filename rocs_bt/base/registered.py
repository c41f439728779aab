"""Objects that packages register in groups of entry points: commands, pages … of wings and of other packages."""

from __future__ import annotations

import tomllib
from collections.abc import Container, Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Final

from .errors import Fault, InputError, unknown
from .files import is_file, read_text

GROUPS: Final[Mapping[str, str]] = {
    "rocs_bt.checks": "check",
    "rocs_bt.commands": "command",
    "rocs_bt.devices": "driver",
    "rocs_bt.nodes": "vocabulary of nodes",
    "rocs_bt.report": "page of a run",
    "rocs_bt.tables": "table of a file",
    "rocs_bt.services": "service beside runs",
}
"""What a name in each group is, for messages."""

FILES_WITH_TABLES: Final = ("robot", "scenario")
"""Kinds of files to which packages add tables: in `rocs_bt.tables` these have names such as `robot.NAME`."""

_PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"  # of a checkout, which may not be installed


@cache
def registered(group: str) -> Mapping[str, EntryPoint]:
    """Entry points of a group by name; a name that rocs_bt has is its own in every installation.

    Nothing is imported until an entry point is loaded.
    """
    others = (found for found in entry_points(group=group) if not _is_own(found))
    return {found.name: found for found in sorted([*others, *_own(group)], key=lambda found: found.name)}


def unused(group: str, core: Container[str] = ()) -> Iterator[EntryPoint]:
    """Entry points of other packages that have names of rocs_bt.

    Args:
        group: Group of the entry points.
        core: Names that rocs_bt has without registering them.
    """
    for found in entry_points(group=group):
        if not _is_own(found) and (found.name in core or _is_own(registered(group)[found.name])):
            yield found


def load(group: str, name: str) -> Any:
    """Object that is registered under a name.

    Raises:
        InputError: Nothing has this name, or several packages have it; it cannot be loaded, or is a table of no kind of
            file.
    """
    if (found := registered(group).get(name)) is None:
        raise InputError(unknown(GROUPS[group], name, registered(group)))
    hint = f"It is registered as {found.value}{f' by the package {found.dist.name}' if found.dist else ''}."
    packages = {each.dist.name for each in entry_points(group=group) if each.name == name and each.dist}
    if len(packages) > 1 and not _is_own(found):
        names = " and ".join(sorted(packages))
        raise InputError(
            Fault(f"the {GROUPS[group]} '{name}' is registered by the packages {names}.", hint="Remove one.")
        )
    kind, _, table = name.rpartition(".")
    if group == "rocs_bt.tables" and kind not in FILES_WITH_TABLES:
        names = " or ".join(f"'{kind}.{table}'" for kind in FILES_WITH_TABLES)
        raise InputError(Fault(f"a table of a file must have the name {names}, found '{name}'.", hint=hint))
    try:
        return found.load()
    except Exception as error:  # a package of another author must not break what does not need it
        raise InputError(Fault(f"the {GROUPS[group]} '{name}' cannot be loaded: {error}.", hint=hint)) from error


def all_of(group: str) -> Iterator[tuple[str, Any]]:
    """Name and object of each registration; what cannot be loaded is left out, and `rocs-bt doctor` lists it."""
    for name in registered(group):
        with suppress(InputError):
            yield name, load(group, name)


def _is_own(found: EntryPoint) -> bool:
    return found.value.startswith("rocs_bt.")


def _own(group: str) -> list[EntryPoint]:
    """Entry points of rocs_bt."""
    if not is_file(_PROJECT):
        return [found for found in entry_points(group=group) if _is_own(found)]
    # The code beside the project file is what runs, also if an older state of it is installed.
    declared = tomllib.loads(read_text(_PROJECT))["project"].get("entry-points", {}).get(group, {})
    return [EntryPoint(name, value, group) for name, value in declared.items()]
