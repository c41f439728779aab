"""Renamed keys of content files: one table per format, for the refusal of old files and for `rocs-bt upgrade`."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..document import Table
from ..errors import Fault, InputError
from ..files import is_file
from ..python_content import is_reference
from ..toml_text import Key
from .entry import shipped_root


@dataclass(frozen=True)
class Renamed:
    """Renamed keys of one table.

    Attributes:
        table: Present names of the tables that lead to it; arrays of tables count as one step.
        keys: Present names, by old name.
        where: Key and value that the table must have, such as `driver` and `gyro`; None for any table at this place.
        code: Shipped Python file of a class in `where`, relative to the shipped content; a project's own class of the
            same name keeps its keys.
    """

    table: tuple[str, ...]
    keys: Mapping[str, str]
    where: tuple[str, str] | None = None
    code: str = ""


@dataclass(frozen=True)
class Moved:
    """Keys of one table that belong to another table, or to none, since a format.

    Attributes:
        table: Names of the tables that lead to the old place; arrays of tables count as one step.
        keys: Moved keys.
        where: Key and value that the table must have, such as `class` and `WheelMonitor`; None for any table.
        to: Table of the root that has the keys now; empty if they were removed.
    """

    table: tuple[str, ...]
    keys: tuple[str, ...]
    where: tuple[str, str] | None
    to: str


@dataclass(frozen=True)
class Format:
    """Format of a kind of content file.

    Attributes:
        name: Present format, such as `robot/3`.
        old: Formats that `rocs-bt upgrade` rewrites.
        renamed: Renamed keys.
        moved: Keys that moved to another table, by their present names and places.
    """

    name: str
    old: tuple[str, ...]
    renamed: tuple[Renamed, ...]
    moved: tuple[Moved, ...] = ()


ROBOT = Format(
    "robot/3",
    ("robot/1", "robot/2"),
    (
        Renamed((), {"drive": "locomotion"}),
        Renamed(
            ("locomotion",),
            {
                "track": "wheel_separation",
                "effective_track": "effective_wheel_separation",
                "pivot": "icr_offset",
                "wheel_delay": "delay",
                "wheel_lag": "lag",
            },
        ),
        Renamed(("sensor",), {"reach": "max_range", "slots": "max_peers"}, ("driver", "robot_sensor")),
        Renamed(("sensor",), {"bias": "bias_noise"}, ("driver", "gyro")),
        Renamed(("monitor",), {"slots": "max_peers"}, ("class", "PeerMonitor")),
        Renamed(("monitor",), {"remembered": "max_messages"}, ("class", "MessageMonitor")),
        Renamed(("monitor",), {"vanish": "min_vanish_range"}, ("class", "RangeMonitor")),
        Renamed(
            ("monitor",),
            {
                "vanish": "min_vanish_range",
                "reach": "max_range",
                "memory": "max_echo_age",
                "ground": "max_free_ground_age",
            },
            ("class", "surround_monitor.py:SurroundMonitor"),
            "robots/summit_xl/surround_monitor.py",
        ),
        Renamed(
            ("analyze",),
            {
                "along": "travel_noise",
                "aside": "slip_noise",
                "turning": "turn_noise",
                "gyro": "gyro_noise",
                "bias": "gyro_bias_noise",
                "drift": "drift_noise",
                "position": "fix_position_noise",
                "heading": "fix_heading_noise",
            },
            ("class", "Localise"),
        ),
        Renamed(
            ("analyze",),
            {"reach": "max_range", "horizon": "max_raytrace_range", "cell": "cell_size", "side": "map_size"},
            ("class", "LocalMap"),
        ),
        Renamed(
            ("analyze",),
            {"reach": "max_range", "largest": "max_object_size", "mobility": "speed_noise"},
            ("class", "TrackObjects"),
        ),
    ),
    (
        Moved(("monitor",), ("latency", "deceleration"), ("class", "WheelMonitor"), "locomotion"),
        Moved(("locomotion",), ("wheel_radius",), None, ""),
    ),
)
"""Format of robot.toml."""

SCENARIO = Format(
    "scenario/2",
    ("scenario/1",),
    (
        Renamed((), {"mover": "actor"}),
        Renamed(("agent", "success"), {"shortest": "shortest_path"}),
        Renamed(("fact",), {"told_by": "reported_by"}),
        Renamed(
            ("actor",),
            {
                "max_bend": "max_leg_turn_rate",
                "turn_rate": "in_place_turn_rate",
                "min_leg": "min_leg_duration",
                "max_leg": "max_leg_duration",
            },
            ("script", "random_walk"),
        ),
        Renamed(
            ("actor",),
            {"at": "depart_at", "lasts": "duration", "back_at": "return_at", "yields": "wait_distance"},
            ("script", "slide"),
        ),
        Renamed(("actor",), {"bend": "deviation"}, ("script", "polynomial")),
        Renamed(("actor",), {"sees_robots": "avoids_robots"}, ("script", "social_force")),
    ),
)
"""Format of scenario files."""

FORMATS: Mapping[str, Format] = {name: each for each in (ROBOT, SCENARIO) for name in (each.name, *each.old)}
"""Formats by their present and old names."""


def old_keys(
    data: Mapping[str, Any], form: Format, files: Sequence[Path], base: Mapping[str, Any] | None = None
) -> Iterator[tuple[Key, str]]:
    """Keys of a document that have been renamed: the full key, and its present name.

    Args:
        data: Document.
        form: Format of the document, which may be an old one.
        files: File of the document, then those that it is based on.
        base: Merged content of the bases, with present names; supplies drivers, classes and scripts that the document
            inherits.
    """
    first = {new: old for each in form.renamed if not each.table for old, new in each.keys.items()}
    for renamed in form.renamed:
        for key, row, inherited in _rows(data, base or {}, renamed.table, first, ()):
            found = [old for old in renamed.keys if old in row]
            if found and _holds(renamed, {**inherited, **row}, files):
                yield from (((*key, old), renamed.keys[old]) for old in found)


def moved_keys(
    data: Mapping[str, Any], form: Format, base: Mapping[str, Any] | None = None
) -> Iterator[tuple[Key, str]]:
    """Keys of a document that belong to another table: the full key, and that table; empty if the key was removed.

    Args:
        data: Document with present names.
        form: Format of the document, which may be an old one.
        base: Merged content of the bases, with present names.
    """
    for moved in form.moved:
        for key, row, inherited in _rows(data, base or {}, moved.table, {}, ()):
            if moved.where is None or {**inherited, **row}.get(moved.where[0]) == moved.where[1]:
                yield from (((*key, name), moved.to) for name in moved.keys if name in row)


def foreign_keys(data: Mapping[str, Any], form: Format, files: Sequence[Path]) -> Iterator[tuple[Key, str]]:
    """Keys of a project's own drivers and blocks that a shipped class has renamed: the full key, and the class."""
    renamed = {key for key, _ in old_keys(data, form, files)}
    for field, table in {(each.where[0], each.table) for each in form.renamed if each.where}:
        names = {old for each in form.renamed if each.table == table and each.where for old in each.keys}
        for key, row, _ in _rows(data, {}, table, {}, ()):
            if is_reference(str(row.get(field, ""))):
                yield from (((*key, n), row[field]) for n in row if n in names and (*key, n) not in renamed)


def refuse_old_format(table: Table) -> None:
    """Refuse a document of an old format.

    Raises:
        InputError: The format is old; the message names the command that rewrites the file.
    """
    found = table.data.get("format")
    form = FORMATS.get(found) if isinstance(found, str) else None
    if form is not None and found in form.old:
        message = f"the format '{found}' is old; the present one is '{form.name}'."
        raise InputError(Fault(message, table.file, *table.position("format"), hint=_advice(table)))


def refuse_old_keys(table: Table) -> None:
    """Refuse a document of the present format with keys that have been renamed.

    Args:
        table: Root table, merged with its bases.

    Raises:
        InputError: There are such keys; contains a fault for each.
    """
    form = FORMATS.get(str(table.data.get("format")))
    if form is None:
        return
    faults = []
    for key, new in old_keys(table.data, form, (table.file, *table.bases)):
        line, column = table.position_of(key)
        message = f"the key '{key[-1]}' is called '{new}' since {form.name}."
        faults.append(Fault(message, table.file, line, column, hint=_advice(table)))
    for key, to in moved_keys(table.data, form):
        line, column = table.position_of(key)
        place = f"belongs to [{to}]" if to else "does not exist any more"
        message = f"the key '{key[-1]}' {place} since {form.name}."
        faults.append(Fault(message, table.file, line, column, hint=_advice(table)))
    if faults:
        raise InputError(*sorted(faults, key=lambda fault: (fault.line, fault.column)))


def _advice(table: Table) -> str:
    if not is_file(table.file):
        return ""
    here, file = Path.cwd(), table.file.absolute()
    named = file.relative_to(here) if file.is_relative_to(here) else file
    return f"`rocs-bt upgrade {shlex.quote(str(named))}` rewrites the file."


Row = tuple[Key, Mapping[str, Any], Mapping[str, Any]]
"""Key of a table, the table, and its counterpart in the bases."""


def _rows(
    data: Mapping[str, Any], base: Mapping[str, Any], table: tuple[str, ...], first: Mapping[str, str], key: Key
) -> Iterator[Row]:
    """Tables at a place of a document; `first` contains the old names of tables of the root."""
    if not table:
        yield key, data, base
        return
    name, rest = table[0], table[1:]
    inherited = base.get(name)
    for each in (name, first[name]) if name in first else (name,):
        value, here = data.get(each), (*key, each)
        if isinstance(value, dict):
            yield from _rows(value, inherited if isinstance(inherited, dict) else {}, rest, {}, here)
        for i, row in enumerate(value if isinstance(value, list) else ()):
            if isinstance(row, dict):
                yield from _rows(row, _named(inherited, row.get("name")), rest, {}, (*here, i))


def _named(rows: Any, name: Any) -> Mapping[str, Any]:
    """Table of an array with a name; empty if there is none."""
    found = (row for row in (rows if isinstance(rows, list) else ()) if isinstance(row, dict))
    return next((row for row in found if name is not None and row.get("name") == name), {})


def _holds(renamed: Renamed, row: Mapping[str, Any], files: Sequence[Path]) -> bool:
    if renamed.where is None:
        return True
    field, value = renamed.where
    if row.get(field) != value:
        return False
    if not renamed.code:
        return True
    beside = (file.parent / value.partition(":")[0] for file in files)
    used = next((path for path in beside if is_file(path)), None)
    return used is not None and used.resolve() == (shipped_root() / renamed.code).resolve()
