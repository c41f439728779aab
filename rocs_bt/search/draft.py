"""Draft: a scene that the search simplifies step by step, by changing obstacles, start, goal and numbers."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from ..compare.episode import GeneratedScene
from ..compare.family import Scene, position
from ..compare.floor import Floor
from ..compare.floor_grid import GridPath
from ..compare.obstacle import Block, Point, Post

CELL = 0.05  # [m] cell size of the path search
_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([A-Za-z/0-9]+)\s*")


@dataclass(frozen=True, eq=False)
class Draft:
    """Immutable scene; each change returns a new draft. Drafts are equal if their scenario and world files are.

    Attributes:
        scene: The scene. Changes keep its name, because the name seeds every random stream of its episodes.
    """

    scene: Scene

    @staticmethod
    def of(scene: Scene, name: str, doc: str, robot: str = "") -> Draft:
        """Make a draft of a family's scene, with another name and without random start offsets (jitter).

        Args:
            scene: Scene to copy.
            name: New name.
            doc: One-sentence description.
            robot: Robot under test; that of the scene if empty.
        """
        scenario = copy.deepcopy({**scene.scenario, "world": name, "doc": doc})
        for table in (*scenario["agent"], *scenario.get("actor", [])):
            table.pop("jitter", None)
        scenario["agent"][0]["robot"] = robot or scenario["agent"][0]["robot"]
        return Draft(Scene(scenario, scene.floor))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Draft) and self.scene_ref == other.scene_ref

    def __hash__(self) -> int:
        return hash(self.scene_ref)

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.scene.name

    @cached_property
    def scene_ref(self) -> GeneratedScene:
        """Reference to the scene for a sweep."""
        return GeneratedScene.of(self.scene)

    @cached_property
    def obstacles(self) -> Mapping[str, Point]:
        """Position of each obstacle, and start position of each actor (door, person, robot) [m], by name."""
        found = {obstacle.name: (obstacle.x, obstacle.y) for obstacle in (*self._floor.obstacles, *self._floor.actors)}
        return found | {actor["name"]: _point(actor) for actor in self._scenario.get("actor", [])}

    @property
    def start(self) -> Point:
        """Start position of the agent under test [m]."""
        return _point(self._scenario["agent"][0])

    @property
    def goal(self) -> Point:
        """Goal position [m]."""
        return _point(_goal(self._scenario))

    @property
    def robot(self) -> str:
        """Name of the robot under test."""
        return str(self._scenario["agent"][0]["robot"])

    @property
    def movable(self) -> bool:
        """Whether the search may move start and goal; False if the agents know places besides the goal."""
        return len(self._scenario.get("place", [])) == 1 and not self._scenario.get("fact")

    @cached_property
    def floor(self) -> Floor:
        """Static obstacles on a floor that extends 2 m beyond everything; without actors."""
        points = [*self.obstacles.values(), self.start, self.goal]
        low, high = (tuple(f(p[axis] for p in points) + d for axis in (0, 1)) for f, d in ((min, -2.0), (max, 2.0)))
        return Floor((low[0], low[1]), (high[0], high[1]), self._floor.obstacles)

    def shortest_path(self, radius: float) -> GridPath | None:
        """Shortest path of a disc with this radius [m] from start to goal; None if there is none."""
        return self.floor.grid(CELL).shortest(self.start, self.goal, radius)

    def without(self, names: Collection[str]) -> Draft:
        """Draft without some obstacles or actors."""
        actors = [actor for actor in self._scenario.get("actor", []) if actor["name"] not in names]
        obstacles, bodies = (
            [obstacle for obstacle in each if obstacle.name not in names]
            for each in (self._floor.obstacles, self._floor.actors)
        )
        floor = replace(self._floor, obstacles=obstacles, actors=bodies)
        return Draft(Scene({**self._scenario, "actor": actors}, floor))

    def between(self, start: Point, goal: Point) -> Draft:
        """Draft with another start and goal [m]."""
        scenario = copy.deepcopy(dict(self._scenario))
        scenario["agent"][0] |= position(start)
        _goal(scenario).update(position(goal))
        return Draft(Scene(scenario, self._floor))

    def rounded(self, step: float, degrees: float, names: Collection[str]) -> Draft:
        """Draft with numbers rounded to multiples of a step.

        Args:
            step: Step of all quantities except angles [m, m/s, s]; sizes stay above 0.
            degrees: Step of angles [deg].
            names: Obstacles and actors to round; the name "" means start and goal.
        """
        scenario = copy.deepcopy(dict(self._scenario))
        tables = [actor for actor in scenario.get("actor", []) if actor["name"] in names]
        tables += [scenario["agent"][0], _goal(scenario)] if "" in names and self.movable else []
        for table in tables:
            table |= {key: _simpler(value, step, degrees) for key, value in table.items() if key != "tolerance"}
        obstacles, bodies = (
            [_simpler_obstacle(obstacle, step, degrees) if obstacle.name in names else obstacle for obstacle in each]
            for each in (self._floor.obstacles, self._floor.actors)
        )
        return Draft(Scene(scenario, replace(self._floor, obstacles=obstacles, actors=bodies)))

    @property
    def _scenario(self) -> Mapping[str, Any]:
        return self.scene.scenario

    @property
    def _floor(self) -> Floor:
        return self.scene.floor


def _goal(scenario: Mapping[str, Any]) -> dict[str, Any]:
    wanted = scenario["agent"][0]["success"]["goal"]
    table: dict[str, Any] = next(place for place in scenario["place"] if place["name"] == wanted)
    return table


def _simpler_obstacle(obstacle: Post | Block, step: float, degrees: float) -> Post | Block:
    """Obstacle with rounded position, size and angle, but unchanged height; a size never becomes 0."""
    x, y = _multiple(obstacle.x, step), _multiple(obstacle.y, step)
    if isinstance(obstacle, Post):
        return replace(obstacle, x=x, y=y, radius=_multiple(obstacle.radius, step / 2.0) or obstacle.radius)
    length, width = (_multiple(size, step) or size for size in (obstacle.length, obstacle.width))
    yaw = math.radians(_multiple(math.degrees(obstacle.yaw), degrees))
    return replace(obstacle, x=x, y=y, length=length, width=width, yaw=yaw)


def _simpler(value: Any, step: float, degrees: float) -> Any:
    """Round a quantity given as text, such as `1.23 m`; other values are returned unchanged."""
    if not isinstance(value, str) or (found := _QUANTITY.fullmatch(value)) is None:
        return value
    unit = found[2]
    return f"{_multiple(float(found[1]), degrees if unit == 'deg' else step):g} {unit}"


def _multiple(value: float, step: float) -> float:
    return round(round(value / step) * step, 6) + 0.0  # + 0.0 turns -0 into 0


def _point(table: Mapping[str, Any]) -> Point:
    """Position in a robot's or goal's table [m]; 0 for missing keys."""
    x, y = (float(found[1]) if (found := _QUANTITY.fullmatch(table.get(key, ""))) else 0.0 for key in ("x", "y"))
    return x, y
