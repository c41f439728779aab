"""Where nodes stand in a drawing: the agent in the middle, what it is related to around it, ring by ring."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

Point = tuple[float, float]
RING = 110.0  # [px] from one ring to the next
ROOM = 62.0  # [px] along a ring for each node
STRETCH = 1.45  # names are wider than high


def layout(kinds: Mapping[str, str], edges: Iterable[tuple[str, str]], root: str) -> dict[str, Point]:
    """A place for every node, the same whenever the nodes and edges are the same.

    Args:
        kinds: The nodes and their kinds; those of a kind stand together, as far as they are related to the same node.
        edges: Which are related, in whichever direction.
        root: The node in the middle.

    Returns:
        x to the right and y down, around (0, 0) [px].
    """
    near: dict[str, list[str]] = {name: [] for name in kinds}
    for one, other in edges:
        near[one].append(other)
        near[other].append(one)
    places: dict[str, Point] = {}
    radius = 0.0
    for ring in _rings(kinds, near, root):
        if ring == [root]:
            places[root] = (0.0, 0.0)
            continue
        while ring:
            radius += RING
            fit = max(6, int(math.tau * radius / ROOM))
            row, ring = (ring, []) if len(ring) <= fit else (ring[:fit], ring[fit:])
            for place, name in enumerate(row):
                angle = math.tau * (place / len(row)) - math.pi / 2.0
                places[name] = (STRETCH * radius * math.cos(angle), radius * math.sin(angle))
    return places


def _rings(kinds: Mapping[str, str], near: Mapping[str, list[str]], root: str) -> Iterable[list[str]]:
    """The nodes by how many relations they are away from the root, and at last those that are not related to it."""
    seen: set[str] = set()
    ring = [root] if root in kinds else []
    while ring:
        yield ring
        seen.update(ring)
        following: dict[str, None] = {}
        for name in ring:  # those of one node side by side, so that what belongs together is near
            following.update(dict.fromkeys(_together((n for n in near[name] if n not in seen), kinds)))
        ring = list(following)
    if alone := [name for name in kinds if name not in seen]:
        yield _together(alone, kinds)


def _together(names: Iterable[str], kinds: Mapping[str, str]) -> list[str]:
    """Names with those of one kind side by side, kinds in the order of their first."""
    names = list(names)
    first = {kind: place for place, kind in reversed(list(enumerate(kinds[name] for name in names)))}
    return sorted(names, key=lambda name: first[kinds[name]])
