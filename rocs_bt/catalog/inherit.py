"""Inheritance between TOML files: a file with `base` overrides the file that `base` names.

Tables are merged key by key. In arrays of tables, tables of equal `name` are merged; a table with a new name is
appended. All other values replace those of the base. If a file replaces a mission, it does not inherit the parameters
of the old mission; if it replaces a driver or script, it does not inherit the keys of the old one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..base.toml_table import KnownKey, Table, read_toml
from ..base.toml_text import Key, are_tables
from ..declare import Declared, Open, keys_of
from .device_spec import DEVICES
from .scenario_file import ActorSpec

Positions = dict[Key, tuple[int, int]]
FindBase = Callable[[str], Path]
"""Function that returns the file of a `base`; raises InputError if it does not exist."""

_OWNERS: Mapping[str | int, tuple[type[Declared], str]] = {
    **{kind: (cls, "driver") for kind, cls in DEVICES.items()},
    "actor": (ActorSpec, "script"),
}
"""Tables with keys that belong to the value of another key, by name: their declared class, and that key."""


def overlay_table(overlay: Open) -> Table:
    """The tables of an agent that override those of its robot, as a root table for one reading."""
    table = overlay.opened()
    depth = len(table.key)
    positions = {key[depth:]: at for key, at in table.positions.items() if key[:depth] == table.key}
    return Table(table.file, dict(overlay), (), positions)


def no_base(name: str) -> Path:
    """`FindBase` for a file that is read without a catalog.

    Raises:
        InputError: Always.
    """
    raise InputError(f"the base '{name}' cannot be found without a catalog. Load the file through a Catalog.")


def read_with_base(file: Path, find: FindBase = no_base) -> Table:
    """Read a TOML file and merge it with its chain of bases.

    Faults in an inherited table are reported at the line of `base`.

    Raises:
        InputError: A file cannot be read, a base does not exist, or a file is based on itself.
    """
    return merged_with_base(read_toml(file), find)


def merged_with_base(own: Table, find: FindBase = no_base, readers: tuple[Path, ...] = ()) -> Table:
    """Merge a root table with its chain of bases; see `read_with_base`."""
    own.known["base"] = KnownKey("a text")
    name, file = own.data.get("base"), own.file
    readers = (*readers, file.resolve())
    if "base" not in own:
        return own
    if not isinstance(name, str):
        own.fault("base", f"base must be a text, found {name!r}.")
        raise InputError(*own.faults)
    try:
        path = find(name)
        if path.resolve() in readers:
            raise InputError(f"cyclic inheritance: '{name}' is itself based on this file. Remove one 'base'.")
        base = merged_with_base(read_toml(path), find, readers)
    except InputError as error:
        raise error.at(file, *own.position("base")) from error
    merged = overlaid(own, base, own.position("base"))
    merged.known["base"] = own.known["base"]
    return merged


def overlaid(own: Table, base: Table, at: tuple[int, int]) -> Table:
    """Merge a root table over that of another file; faults in inherited tables are reported at `at`."""
    positions: Positions = {(): at}
    data = _merged(own.data, base.data, (), (), own.positions, positions)
    return Table(own.file, data, (), positions, bases=(base.file, *base.bases))


def _merged(
    own: dict[str, Any], base: dict[str, Any], key: Key, target: Key, positions: Positions, found: Positions
) -> dict[str, Any]:
    """Merge the table `own` over the table `base`, and record the positions of the merged keys in `found`."""
    dropped = _not_inherited(own, base, key)
    merged = {name: value for name, value in base.items() if name not in dropped}
    for name, value in own.items():
        inherited = merged.get(name)
        here, to = (*key, name), (*target, name)
        if isinstance(value, dict) and isinstance(inherited, dict):
            _move(positions, found, here, to, deep=False)
            merged[name] = _merged(value, inherited, here, to, positions, found)
        elif inherited is not None and are_tables(value) and are_tables(inherited):
            merged[name] = _merged_arrays(value, inherited, here, to, positions, found)
        else:
            _move(positions, found, here, to)
            merged[name] = value
    return merged


def _not_inherited(own: dict[str, Any], base: dict[str, Any], key: Key) -> set[str]:
    """Keys of the base that are not inherited: the file replaces the mission, driver or script to which they belong."""
    dropped = set[str]()
    if "mission" in own and own["mission"] != base.get("mission"):
        dropped.add("parameters")
    cls, owner = _OWNERS.get(key[0] if key else "", (None, ""))
    if cls is not None and owner in own and own[owner] != base.get(owner):
        dropped.update(base.keys() - keys_of(cls))
    return dropped


def _merged_arrays(
    own: list[dict[str, Any]], base: list[dict[str, Any]], key: Key, target: Key, positions: Positions, found: Positions
) -> list[dict[str, Any]]:
    merged = list(base)
    for i, table in enumerate(own):
        at = next((j for j, other in enumerate(base) if other.get("name") == table.get("name")), len(merged))
        here, to = (*key, i), (*target, at)
        _move(positions, found, here, to, deep=at == len(merged))
        if at == len(merged):
            merged.append(table)
        else:
            merged[at] = _merged(table, base[at], here, to, positions, found)
    return merged


def _move(positions: Positions, found: Positions, key: Key, to: Key, *, deep: bool = True) -> None:
    for found_key, position in positions.items():
        if found_key == key or (deep and found_key[: len(key)] == key):
            found[(*to, *found_key[len(key) :])] = position
