"""Pages of runs, made by the packages that registered them in the entry points `rocs_bt.report`."""

from __future__ import annotations

import tomllib
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from ..errors import Fault, InputError
from ..files import is_file, read_text
from .recording import Recording
from .summary import Summary

GROUP = "rocs_bt.report"

_PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"  # of a checkout, which may not be installed


def page_maker(name: str) -> Any:
    """What is registered under a name: `report` writes a report, `live` is the class of live pages.

    Raises:
        InputError: Nothing is registered, because rocs_bt is not installed.
    """
    for found in (*entry_points(group=GROUP, name=name), *_of_checkout(name)):
        return found.load()
    hint = "Install rocs_bt, for example with `pip install -e .` in its checkout."
    raise InputError(Fault(f"no package makes the page '{name}'.", hint=hint))


def _of_checkout(name: str) -> tuple[EntryPoint, ...]:
    """Entry point that the project file beside the package declares; none if the package is installed elsewhere."""
    if not is_file(_PROJECT):
        return ()
    project = tomllib.loads(read_text(_PROJECT))["project"]
    declared = project.get("entry-points", {}).get(GROUP, {})
    return (EntryPoint(name, declared[name], GROUP),) if name in declared else ()


def write_report(recording: Recording, summary: Summary | None, path: Path) -> None:
    """Write report.html of a run, with the registered writer.

    Raises:
        InputError: No writer is registered.
        RecordingError: The file cannot be written, or the recording cannot be read.
    """
    page_maker("report")(recording, summary, path)
