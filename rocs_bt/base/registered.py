"""Objects that packages register in groups of entry points, such as `rocs_bt.commands`."""

from __future__ import annotations

import tomllib
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from .files import is_file, read_text

_PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"  # of a checkout, which may not be installed


def registered(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group by name: those of the installed packages, and those of the checkout of rocs_bt.

    Nothing is imported until an entry point is loaded.

    Args:
        group: Name of the group, such as `rocs_bt.report`.
    """
    return {**_of_checkout(group), **{found.name: found for found in entry_points(group=group)}}


def _of_checkout(group: str) -> dict[str, EntryPoint]:
    """Entry points that the project file beside the package declares; none if the package is installed elsewhere."""
    if not is_file(_PROJECT):
        return {}
    project = tomllib.loads(read_text(_PROJECT))["project"]
    declared = project.get("entry-points", {}).get(group, {})
    return {name: EntryPoint(name, value, group) for name, value in declared.items()}
