"""Reading of robot files; their tables are declared in `robot_spec` (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from pathlib import Path

from ..analyze import ANALYZERS
from ..base.errors import Fault, did_you_mean
from ..base.files import is_file
from ..base.python_content import is_reference, lacks_class
from ..base.registered import registered
from ..base.toml_table import Table
from ..declare import Open, Scope, location_of, names_of, read_root, replaced, rows_in
from ..devices.simulated import ACTUATORS, SENSORS
from ..monitor import MONITORS
from .inherit import FindBase, no_base, overlaid, overlay_table, read_with_base
from .robot_spec import RobotSpec


def load_robot(file: Path, find_base: FindBase = no_base, overlay: Open | None = None) -> RobotSpec:
    """Read a robot.toml.

    Args:
        file: The robot.toml.
        find_base: Returns the robot.toml of the robot that a `base` names.
        overlay: Tables that override those of the file.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    root = read_with_base(file, find_base)
    if overlay:
        root = overlaid(overlay_table(overlay), root, location_of(overlay)[1:])
    known: dict[str, Collection[str]] = {
        "driver": (*SENSORS, *ACTUATORS, *registered("rocs_bt.devices")),
        "monitor": (*MONITORS, *names_of(rows_in(root, "monitor"))),
        "monitor class": MONITORS,
        "analyze class": ANALYZERS,
    }
    found = read_root(RobotSpec, root, Scope(missing=partial(_missing, root, known)))
    return replaced(found, name=file.parent.name, file=file, bases=root.bases)


def _missing(root: Table, known: dict[str, Collection[str]], kind: str, name: str) -> Fault | None:
    """Fault of the name of a shipped class, of `file.py:Class`, or of a model file; files must be beside robot.toml."""
    if kind != "model file" and not is_reference(name):
        hint = did_you_mean(name, known[kind], "rocs_bt").and_also("Or name your own: 'file.py:Class'.")
        return None if name in known[kind] else Fault(f"no {kind} is named '{name}'.", hint=hint)
    file, _, cls = name.partition(":")
    path = root.beside(file)
    # Content hashes cover no files elsewhere.
    if not any(path.resolve().is_relative_to(each.parent.resolve()) for each in (root.file, *root.bases)):
        there = "Move it there: all files of a robot are beside robot.toml."
        return Fault(f"'{file}' is not in the robot's folder.", hint=there)
    if not is_file(path):
        return Fault(f"there is no file '{file}' beside robot.toml.")
    return lacks_class(path, cls) if cls else None
