"""Dialect of a mission file: the `nodes` of the scenarios and planners that use it."""

from __future__ import annotations

from ..catalog import Catalog, Entry
from ..errors import InputError


def dialect_of(mission: Entry, catalog: Catalog) -> str:
    """The `nodes` of the scenarios and planners that use a mission: `nav2` if any of them declares it, else empty.

    Args:
        mission: The mission.
        catalog: Catalog of the scenarios and planners; files that do not name Nav2 are not read.
    """
    if mission.path.suffix != ".xml":
        return ""
    entries = [e for kind in ("scenario", "planner") for e in catalog.list(kind) if b"nav2" in e.path.read_bytes()]
    for entry in entries:
        try:
            place = str(entry.path)
            scenario = entry.kind == "scenario"
            users = catalog.load_scenario(place).agents if scenario else [catalog.load_planner(place)]
        except InputError:
            continue  # reported where the scenario or the planner is checked
        if any(a.nodes and catalog.find("mission", a.mission).path.samefile(mission.path) for a in users):
            return "nav2"
    return ""
