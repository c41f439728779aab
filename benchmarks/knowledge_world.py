"""A world of 10,000 objects for the knowledge graph, for raw networkx and for rdflib."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

import networkx
from row import size

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge

COUNT, NEIGHBOURS, SIDE = (
    size(10_000, 200),
    3,
    100.0,
)  # number of objects, edges per object, side of their square [m]
HERE = (50.0, 50.0)  # position of the robot [m]


def objects() -> Iterator[tuple[str, dict[str, Any]]]:
    """Names and attributes, from a fixed seed."""
    draw = random.Random(1)
    for i in range(COUNT):
        pose = Pose2(draw.uniform(0.0, SIDE), draw.uniform(0.0, SIDE))
        yield f"o{i}", {"pose": pose, "moves": i % 2 == 0, "radius": draw.random()}


def edges() -> Iterator[tuple[str, str]]:
    """Pairs of objects with a `near` edge, from a fixed seed."""
    draw = random.Random(2)
    for i in range(COUNT):
        for j in draw.sample(range(COUNT), NEIGHBOURS):
            yield f"o{i}", f"o{j}"


def known() -> Knowledge:
    """The world in a robot's Knowledge."""
    made = Knowledge("R2", SimulatedClock(0.05), NullSink())
    made.signals.declare(Signal("pose", 3, (LENGTH, LENGTH, ANGLE)))
    made.signals.freeze()
    made.signals.write("pose", (*HERE, 0.0), 0.0)
    for name, attributes in objects():
        made.graph.add(name, "object", **attributes)
    for source, target in edges():
        made.graph.relate(source, "near", target)
    return made


def raw() -> networkx.MultiDiGraph:
    """The world in networkx, unchecked."""
    made = networkx.MultiDiGraph()
    for name, attributes in objects():
        made.add_node(name, **attributes)
    for source, target in edges():
        made.add_edge(source, target, key="near")
    return made


class Rdf:
    """The world in rdflib, with prepared SPARQL queries."""

    def __init__(self) -> None:
        from rdflib import Graph, Literal, Namespace
        from rdflib.plugins.sparql import prepareQuery

        self.name = Namespace("urn:r:")
        self.graph = Graph()
        for name, attributes in objects():
            node, pose = self.name[name], attributes["pose"]
            self.graph.add((node, self.name["kind"], self.name["object"]))
            for key, value in {"x": pose.x, "y": pose.y, **attributes}.items():
                if key != "pose":
                    self.graph.add((node, self.name[key], Literal(value)))
        for source, target in edges():
            self.graph.add((self.name[source], self.name["near"], self.name[target]))
        spaces = {"r": self.name}
        x, y = HERE
        away = f"((?x - {x}) * (?x - {x}) + (?y - {y}) * (?y - {y}))"
        texts = {
            "hop": "SELECT ?b WHERE { ?a r:near ?b }",
            "hops": "SELECT ?c WHERE { ?a r:near ?b . ?b r:near ?c . ?c r:moves true }",
            "filter": "SELECT ?a WHERE { ?a r:kind r:object ; r:moves true ; r:radius ?v FILTER(?v < 0.1) }",
            "nearest": f"SELECT ?a WHERE {{ ?a r:x ?x ; r:y ?y }} ORDER BY {away} LIMIT 1",
            "within": f"SELECT ?a WHERE {{ ?a r:x ?x ; r:y ?y FILTER({away} < 4) }}",
        }
        self._prepared = {key: prepareQuery(text, initNs=spaces) for key, text in texts.items()}

    def ask(self, question: str, **bound: str) -> list[Any]:
        """Results of one of the queries."""
        bindings = {key: self.name[value] for key, value in bound.items()}
        return list(self.graph.query(self._prepared[question], initBindings=bindings))

    def copy(self) -> Any:
        """Copy of the graph."""
        from rdflib import Graph

        made = Graph()
        for triple in self.graph:
            made.add(triple)
        return made

    def read(self) -> Any:
        """Read one attribute."""
        return self.graph.value(self.name["o1"], self.name["radius"]).value

    def write(self, value: float) -> None:
        """Write one attribute."""
        from rdflib import Literal

        self.graph.set((self.name["o1"], self.name["radius"], Literal(value)))


def nearest(graph: networkx.MultiDiGraph) -> str:
    """Nearest object, by linear search."""
    x, y = HERE
    return min(
        graph.nodes, key=lambda name: math.hypot(graph.nodes[name]["pose"].x - x, graph.nodes[name]["pose"].y - y)
    )
