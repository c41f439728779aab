"""Whose meaning the nodes of a mission file have: what the scenarios that play it say."""

from __future__ import annotations

from ..catalog import Catalog, Entry
from ..errors import InputError


def dialect_of(mission: Entry, catalog: Catalog) -> str:
    """The `nodes` of the scenarios that play a mission: `nav2` if any of them says so, else empty.

    Args:
        mission: The mission.
        catalog: Where the scenarios are; files that do not name Nav2 are not read.
    """
    if mission.path.suffix != ".xml":
        return ""
    entries = [entry for entry in catalog.list("scenario") if b"nav2" in entry.path.read_bytes()]
    for entry in entries:
        try:
            agents = catalog.load_scenario(str(entry.path)).agents
        except InputError:
            continue  # reported where the scenario is checked
        if any(a.nodes and catalog.find("mission", a.mission).path.samefile(mission.path) for a in agents):
            return "nav2"
    return ""
