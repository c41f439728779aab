"""Family: generator of random scenes of one kind. A scene is a scenario with its world, both held in memory."""

from __future__ import annotations

import hashlib
import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..base.files import write_whole
from ..base.geometry import Pose2
from ..base.python_content import running_class
from ..base.toml_text import as_toml
from ..catalog import Catalog
from ..declare import Value, read_values, values_of
from .floor import Floor
from .obstacle import Point, length_of

C = TypeVar("C", bound=Catalog)

AGENT = "R"
"""Name of the agent under test in the scenes of families."""


@dataclass(frozen=True)
class Scene:
    """Scenario and world held in memory, with reference data.

    Attributes:
        scenario: Content of the scenario file: dicts, lists, texts, numbers and booleans; quantities are texts with
            units. The key `world` contains the scene's name, such as `barn_like-17`.
        floor: Floor and obstacles, from which the world file is generated.
        difficulty: Difficulty measures by name; the family's class defines each with its unit.
        reference: Corners of a shortest path from start to goal for the robot's inscribed circle [m].
    """

    scenario: Mapping[str, Any]
    floor: Floor
    difficulty: Mapping[str, float] = field(default_factory=dict)
    reference: Sequence[Point] = ()

    @property
    def name(self) -> str:
        """Name of the scene, family and index; the scenario file and the world file have this name too."""
        return str(self.scenario["world"])

    @property
    def reference_length(self) -> float:
        """Length of the reference path [m]; 0 if there is none."""
        return length_of(self.reference)

    @cached_property
    def toml(self) -> str:
        """Text of the scenario file, TOML."""
        return as_toml(self.scenario)

    @cached_property
    def world(self) -> str:
        """Text of the world file, MJCF."""
        return self.floor.world(self.name, str(self.scenario.get("doc", "")))

    @property
    def privileged(self) -> dict[str, Any]:
        """Ground-truth information that only oracle planners get."""
        return {"floor": self.floor, "reference": self.reference}

    def added_to(self, catalog: C) -> C:
        """Copy of a catalog that also contains this scene."""
        return catalog.with_scene(self.name, self.scenario, self.world)

    def write(self, folder: Path) -> Path:
        """Write `scenarios/<name>.toml` and `scenarios/worlds/<name>.xml` into a project folder.

        Returns:
            The scenario file.
        """
        file = folder / "scenarios" / f"{self.name}.toml"
        world = folder / "scenarios" / "worlds" / f"{self.name}.xml"
        world.parent.mkdir(parents=True, exist_ok=True)
        write_whole(world, self.world)
        write_whole(file, self.toml)
        return file


class AgentSetup(Value):
    """Robot, mission and rules of a scene's agent; a planner replaces mission and rules."""

    robot: str = "jackal"
    mission: str = "go_to"
    rules: str = "avoid_collision"  # empty for none


class Family(AgentSetup, ABC):
    """Base class of families, in `scenarios/families/<name>.py`.

    The class name is the file name in CamelCase. Its annotations are the family's parameters: numbers in SI units, with
    types of `rocs_bt.base.units`, all with defaults. The method `scene` must use no source of
    randomness but `rng`, so that scenes are reproducible.

    Attributes:
        NOT_SAMPLED: Parameters that must not affect the random stream, such as robot, mission and rules; every robot
            and planner then gets the same scenes.
    """

    NOT_SAMPLED: ClassVar[tuple[str, ...]] = ("robot", "mission", "rules")

    @property
    def name(self) -> str:
        """Class name in snake_case, which is the file name."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", type(self).__name__).lower()

    @property
    def doc(self) -> str:
        """Description of the family: first line of the docstring of its class."""
        return (type(self).__doc__ or "").strip().split("\n", 1)[0]

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters by name, in SI units."""
        return values_of(self)

    @abstractmethod
    def scene(self, index: int) -> Scene:
        """Generate the scene with an index, 0 or more; equal parameters and index give an equal scene."""

    def scene_name(self, index: int) -> str:
        """Name of the scene with an index."""
        return f"{self.name}-{index}"

    def rng(self, index: int, purpose: str = "scene") -> np.random.Generator:
        """Random stream, seeded from family, parameters except `NOT_SAMPLED`, index and purpose."""
        own = {name: value for name, value in self.parameters.items() if name not in self.NOT_SAMPLED}
        key = json.dumps([self.name, own, index, purpose], sort_keys=True)
        digest = hashlib.sha256(key.encode()).digest()
        return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


def quantity(value: float, unit: str) -> str:
    """Quantity as written in a file, rounded to four decimals; `deg` converts from radians."""
    return f"{round(math.degrees(value) if unit == 'deg' else value, 4):g} {unit}"


def position(point: Point, yaw: float | None = None) -> dict[str, str]:
    """Point [m], or pose [m, rad], as a table of quantities."""
    pose = {"x": quantity(point[0], "m"), "y": quantity(point[1], "m")}
    return pose if yaw is None else {**pose, "yaw": quantity(yaw, "deg")}


def goal_scenario(
    setup: AgentSetup,
    name: str,
    doc: str,
    start: Pose2,
    goal: Point,
    *,
    tolerance: float,
    duration: float,
    agent: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Content of a scenario in which the agent under test drives to one goal; add further tables with `|`.

    Args:
        setup: Robot, mission and rules of the agent; a family is one.
        name: Name of the scene and of its world.
        doc: One-sentence description.
        start: Start pose; the seed varies it by 5 cm and 5 deg.
        goal: Goal position [m].
        tolerance: Tolerance of the goal position [m].
        duration: Time limit [s].
        agent: Additional or replaced keys of the agent's table, such as `parameters` and `success`.
    """
    target = {"name": "goal", "kind": "goal", **position(goal), "tolerance": quantity(tolerance, "m")}
    under_test = {
        "name": AGENT,
        "robot": setup.robot,
        "mission": setup.mission,
        "rules": [setup.rules] if setup.rules else [],
        **position((start.x, start.y), start.yaw),
        "jitter": {"x": "0.05 m", "y": "0.05 m", "yaw": "5 deg"},
        "success": {"goal": "goal"},
        "parameters": {"goal": "goal"},
    }
    return {
        "format": "scenario/2",
        "doc": doc,
        "world": name,
        "duration": quantity(duration, "s"),
        "end_on_collision": True,
        "place": [target],
        "agent": [{**under_test, **(agent or {})}],
    }


def load_family(catalog: Catalog, name: str, values: Mapping[str, object] | None = None) -> Family:
    """Load a family by its name.

    Args:
        catalog: Source of content.
        name: Name or file of the family.
        values: Parameters as written by a user: `{"rooms": 6, "width": "1.5 m"}`.

    Raises:
        InputError: The family does not exist, its file does not load, or parameters are invalid; lists all faults.
    """
    cls: type[Family] = catalog.load_family(catalog.find("family", name))
    with running_class(cls):
        return read_values(cls, values or {}, f"the family {cls.__name__}")


def scene_of(family: Family, index: int) -> Scene:
    """Scene of a family with an index.

    Raises:
        InputError: There is no such scene with these parameters, or the family's code raised an exception.
    """
    with running_class(type(family)):
        found: object = family.scene(index)
        if not isinstance(found, Scene):
            raise TypeError(f"scene returned {found!r:.60}, which is not a Scene.")
        _ = found.name, found.toml, found.world  # what cannot be written is a fault of the family, too
        return found
