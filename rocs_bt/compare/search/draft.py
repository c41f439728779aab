"""Draft: a scene that is made simpler part by part: what stands in it, from where to where it goes, its numbers."""

from __future__ import annotations

import copy
import math
import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

from ..family import Scene
from ..floor_grid import Way
from ..ground import Ground
from ..scene_text import as_toml, metres
from ..thing import Block, Point, Post

CELL = 0.05  # [m] of the grid on which a way is looked for
_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([A-Za-z/0-9]+)\s*")
_SIZES = {"box": (0, 1), "cylinder": (0,)}  # which of a geom's sizes lie in the plane


@dataclass(frozen=True)
class Draft:
    """A scene as the two texts that it is made of. Each change gives another one.

    A thing is what has a name of its own in the world or in the scenario's movers, such as a box or a walker; the floor
    is none.

    Attributes:
        name: The scenario's and the world's. It stays, since it has a part in every random draw.
        scenario: The scenario, as TOML.
        world: The world, as MJCF.
    """

    name: str
    scenario: str
    world: str

    @staticmethod
    def of(scene: Scene, name: str, doc: str) -> Draft:
        """A scene of a family under another name, nobody's start with jitter: what is not drawn is simpler.

        Args:
            scene: The scene.
            name: Its name from now on.
            doc: One sentence for people.
        """
        document = tomllib.loads(scene.scenario) | {"world": name, "doc": doc}
        for table in (*document["agent"], *document.get("mover", [])):
            table.pop("jitter", None)
        return Draft(name, _toml(document), scene.world)._with_world(ElementTree.fromstring(scene.world))

    @property
    def scene(self) -> Scene:
        """It as a scene, to be written."""
        return Scene(self.name, self.scenario, self.world)

    @cached_property
    def things(self) -> Mapping[str, Point]:
        """Where each thing is [m], or begins."""
        found = {e.get("name", ""): _floats(e.get("pos", "0 0 0")) for e in self._body if _is_thing(e)}
        found |= {m["name"]: (_number(m.get("x")), _number(m.get("y"))) for m in self._document.get("mover", [])}
        return {name: (place[0], place[1]) for name, place in found.items() if name}

    @property
    def start(self) -> Point:
        """Where the agent under test starts [m]."""
        return _place(self._document["agent"][0])

    @property
    def goal(self) -> Point:
        """Where it must come to [m]."""
        return _place(self._goal(self._document))

    @property
    def robot(self) -> str:
        """The name of the robot under test."""
        return str(self._document["agent"][0]["robot"])

    @property
    def movable(self) -> bool:
        """Whether start and goal may be elsewhere: not so in a task, where agents are told of places."""
        return len(self._document.get("place", [])) == 1 and not self._document.get("fact")

    @cached_property
    def ground(self) -> Ground:
        """What stands in it; movers do not."""
        points = [*self.things.values(), self.start, self.goal]
        low, high = (tuple(f(p[axis] for p in points) + d for axis in (0, 1)) for f, d in ((min, -2.0), (max, 2.0)))
        standing = [thing for e in self._body if e.tag == "geom" and (thing := _thing(e)) is not None]
        return Ground((low[0], low[1]), (high[0], high[1]), standing)

    def way(self, radius: float) -> Way | None:
        """The shortest way of a disc of this radius [m] from start to goal; None where there is none."""
        return self.ground.grid(CELL).shortest(self.start, self.goal, radius)

    def without(self, names: Collection[str]) -> Draft:
        """It without some things."""
        document, root = copy.deepcopy(self._document), copy.deepcopy(self._root)
        body = _worldbody(root)
        for element in [e for e in body if e.get("name") in names]:
            body.remove(element)
        document["mover"] = [m for m in document.get("mover", []) if m["name"] not in names]
        return replace(self, scenario=_toml(document))._with_world(root)

    def between(self, start: Point, goal: Point) -> Draft:
        """It with another start and goal [m]."""
        document = copy.deepcopy(self._document)
        for table, (x, y) in ((document["agent"][0], start), (self._goal(document), goal)):
            table |= {"x": metres(x), "y": metres(y)}
        return replace(self, scenario=_toml(document))

    def rounded(self, step: float, degrees: float, names: Collection[str]) -> Draft:
        """It with simpler numbers: multiples of a step [m, m/s, s] and of an angle [deg].

        Args:
            step: The step of all but angles; sizes stay above 0.
            degrees: That of angles.
            names: Of which things; with "" among them of start and goal too.
        """
        document, root = copy.deepcopy(self._document), copy.deepcopy(self._root)
        tables = [m for m in document.get("mover", []) if m["name"] in names]
        tables += [document["agent"][0], self._goal(document)] if "" in names and self.movable else []
        for table in tables:
            table |= {k: _simpler(v, step, degrees) for k, v in table.items() if k != "tolerance"}
        for element in (e for e in _worldbody(root) if e.get("name") in names and _is_thing(e)):
            for part in element.iter():
                _round_element(part, step, degrees)
        return replace(self, scenario=_toml(document))._with_world(root)

    @cached_property
    def _document(self) -> dict[str, Any]:
        return tomllib.loads(self.scenario)

    @cached_property
    def _root(self) -> ElementTree.Element:
        return ElementTree.fromstring(self.world)

    @property
    def _body(self) -> ElementTree.Element:
        return _worldbody(self._root)

    def _goal(self, document: Mapping[str, Any]) -> dict[str, Any]:
        wanted = document["agent"][0]["success"]["goal"]
        table: dict[str, Any] = next(place for place in document["place"] if place["name"] == wanted)
        return table

    def _with_world(self, root: ElementTree.Element) -> Draft:
        root.set("model", self.name)
        ElementTree.indent(root)
        doc = self._document.get("doc", "")
        return replace(self, world=f"<!-- {doc} -->\n{ElementTree.tostring(root, encoding='unicode')}\n")


def _worldbody(root: ElementTree.Element) -> ElementTree.Element:
    body = root.find("worldbody")
    return ElementTree.Element("worldbody") if body is None else body


def _is_thing(element: ElementTree.Element) -> bool:
    return element.tag in ("geom", "body") and element.get("type") != "plane"


def _thing(geom: ElementTree.Element) -> Post | Block | None:
    """A geom as it stands on the ground; None for another shape than an upright cylinder or box."""
    (x, y), size = _floats(geom.get("pos", "0 0 0"))[:2], _floats(geom.get("size", "0"))
    name, yaw = geom.get("name", ""), math.radians(_floats(geom.get("euler", "0 0 0"))[2])
    if geom.get("type") == "cylinder":
        return Post(name, x, y, size[0])
    return Block(name, x, y, 2.0 * size[0], 2.0 * size[1], yaw) if geom.get("type") == "box" else None


def _round_element(element: ElementTree.Element, step: float, degrees: float) -> None:
    """Make an element's numbers in the plane simpler."""
    if (text := element.get("pos")) is not None:
        x, y, z = _floats(text)
        element.set("pos", _text((_multiple(x, step), _multiple(y, step), z)))
    if (text := element.get("size")) is not None:
        size = _floats(text)
        for i in _SIZES.get(element.get("type", ""), ()):
            size[i] = _multiple(size[i], step / 2.0) or size[i]  # they are half of what a person measures
        element.set("size", _text(size))
    if (text := element.get("euler")) is not None:
        element.set("euler", _text([_multiple(angle, degrees) for angle in _floats(text)]))


def _simpler(value: Any, step: float, degrees: float) -> Any:
    """A quantity as a person writes it, rounded; anything else as it is."""
    if not isinstance(value, str) or (found := _QUANTITY.fullmatch(value)) is None:
        return value
    unit = found[2]
    return f"{_multiple(float(found[1]), degrees if unit == 'deg' else step):g} {unit}"


def _multiple(value: float, step: float) -> float:
    return round(round(value / step) * step, 6) + 0.0  # which makes -0 a plain 0


def _number(value: object) -> float:
    found = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return float(found[1]) if found else 0.0


def _place(table: Mapping[str, Any]) -> Point:
    return _number(table["x"]), _number(table["y"])


def _floats(text: str) -> list[float]:
    return [float(each) for each in text.split()]


def _text(values: Collection[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)


def _toml(document: Mapping[str, Any]) -> str:
    tables = {k: v for k, v in document.items() if isinstance(v, list) and all(isinstance(t, dict) for t in v)}
    root = {key: value for key, value in document.items() if key not in tables}
    return as_toml(root, [(key, table) for key, each in tables.items() for table in each])
