"""Visibility graph: shortest path around known obstacles, along straight lines between their corners.

Obstacles are objects of the world model with a pose and a size: a `radius`, or a `length` and a `width`. Each obstacle
is approximated by a convex polygon, inflated by the robot's radius plus the clearance. The nodes of the graph are the
corners of the polygons; its edges are the lines between corners that cross no polygon. The shortest path in the graph
is the shortest path around these polygons (Lozano-Perez and Wesley, Communications of the ACM 22, 1979).
"""

from itertools import combinations
from math import cos, dist, hypot, pi, sin

import networkx as nx

from rocs_bt import Pose2
from rocs_bt.plan import NoRoute, Point, RoutePlanner

SIDES = 12  # number of sides of the polygon around a round obstacle
INSIDE = 1e-6  # [m] tolerance: a line that only touches a polygon does not cross it


class Visibility(RoutePlanner):
    """Plans in the visibility graph of the objects of the world model."""

    def route(self, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        here, there = start[:2], goal[:2]
        grown = self._polygons(self._robot() + clearance)
        self._refuse(there, grown)
        corners = {c for polygon in grown.values() for c in polygon if not _within(c, grown)}
        graph = nx.Graph()
        graph.add_nodes_from([here, there])
        # A robot too near to an obstacle may still drive off: only the obstacle itself, not its margin, blocks it.
        lenient = {n: (p if not _inside(here, p) else self._polygons(0.0)[n]) for n, p in grown.items()}
        for a, b in combinations([here, there, *sorted(corners)], 2):
            polygons = lenient if here in (a, b) else grown
            if not any(_crosses(a, b, polygon) for polygon in polygons.values()):
                graph.add_edge(a, b, weight=dist(a, b))
        try:
            return [tuple(map(float, p)) for p in nx.shortest_path(graph, here, there, weight="weight")]
        except nx.NetworkXNoPath as error:
            names = ", ".join(f"'{name}'" for name in sorted(grown))
            raise NoRoute(f"there is no path between {names} with a clearance of {clearance:g} m") from error

    def _robot(self) -> float:
        """Radius of the robot's hull around its base at any heading [m]; 0 if unknown."""
        known = self.knowledge.graph.attributes(self.knowledge.agent)
        return known.get("radius", 0.5 * hypot(known.get("length", 0.0), known.get("width", 0.0)))

    def _polygons(self, margin: float) -> dict[str, list[Point]]:
        """Polygons of the known obstacles, inflated by a margin [m], corners counterclockwise."""
        found = {}
        for name in self.knowledge.world.objects():
            known = self.knowledge.graph.attributes(name)
            if "pose" not in known:
                continue
            if "radius" in known:
                found[name] = _round(known["pose"], known["radius"] + margin)
            elif "length" in known and "width" in known:
                found[name] = _box(known["pose"], 0.5 * known["length"] + margin, 0.5 * known["width"] + margin)
        return found

    def _refuse(self, there: Point, grown: dict[str, list[Point]]) -> None:
        for name, polygon in grown.items():
            if _inside(there, polygon):
                raise NoRoute(f"the goal is too near to '{name}'")


def _round(centre: Pose2, radius: float) -> list[Point]:
    """Regular polygon that circumscribes a circle."""
    outer = radius / cos(pi / SIDES)
    angles = [2.0 * pi * i / SIDES for i in range(SIDES)]
    return [(centre.x + outer * cos(a), centre.y + outer * sin(a)) for a in angles]


def _box(centre: Pose2, along: float, across: float) -> list[Point]:
    return [centre.transform(x, y) for x, y in ((along, across), (-along, across), (-along, -across), (along, -across))]


def _edges(polygon: list[Point]) -> list[tuple[Point, Point]]:
    return list(zip(polygon, [*polygon[1:], polygon[0]], strict=True))


def _depth(point: Point, edge: tuple[Point, Point]) -> float:
    """Signed distance of a point from a polygon's edge [m], positive to the left, which is inside."""
    (ax, ay), (bx, by) = edge
    return ((bx - ax) * (point[1] - ay) - (by - ay) * (point[0] - ax)) / dist(*edge)


def _inside(point: Point, polygon: list[Point]) -> bool:
    return all(_depth(point, edge) > INSIDE for edge in _edges(polygon))


def _within(point: Point, polygons: dict[str, list[Point]]) -> bool:
    return any(_inside(point, polygon) for polygon in polygons.values())


def _crosses(a: Point, b: Point, polygon: list[Point]) -> bool:
    """Whether the line from `a` to `b` crosses a convex polygon, by the clipping algorithm of Cyrus and Beck."""
    low, high = 0.0, 1.0
    for edge in _edges(polygon):
        at_a, at_b = _depth(a, edge) - INSIDE, _depth(b, edge) - INSIDE
        if at_a <= 0.0 and at_b <= 0.0:
            return False
        if at_a < 0.0 < at_b:
            low = max(low, at_a / (at_a - at_b))
        elif at_b < 0.0 < at_a:
            high = min(high, at_a / (at_a - at_b))
    return low < high
