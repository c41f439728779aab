"""Family: unlimited scenes of one kind, each an ordinary scenario and its world, as values."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import re
import typing
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..action import Parameter
from ..catalog import Catalog
from ..errors import Fault, InputError, unknown
from ..geometry import Pose2
from ..toml_text import as_toml
from ..units import convert
from .ground import Ground
from .obstacle import Point, length_of

C = TypeVar("C", bound=Catalog)

AGENT = "R"
"""The agent under test in every family's scenes."""


@dataclass(frozen=True)
class Scene:
    """One scene: a scenario and its world as values, and what is known of them.

    Attributes:
        scenario: Content of the scenario's file: dicts, lists, texts, numbers and flags, quantities with their unit.
            Its `world` is the scene's name, such as `barn_like-17`.
        ground: The floor and what stands on it, of which the world is made.
        difficulty: How hard it is, by measure; the family's class says what each is, in which unit.
        reference: Corners of a shortest way from start to goal of the robot's inscribed circle [m].
    """

    scenario: Mapping[str, Any]
    ground: Ground
    difficulty: Mapping[str, float] = field(default_factory=dict)
    reference: Sequence[Point] = ()

    @property
    def name(self) -> str:
        """Its family's name and its index; the stem of both files."""
        return str(self.scenario["world"])

    @property
    def reference_length(self) -> float:
        """Length of the reference [m]; 0 where there is none."""
        return length_of(self.reference)

    @cached_property
    def toml(self) -> str:
        """The scenario as TOML."""
        return as_toml(self.scenario)

    @cached_property
    def world(self) -> str:
        """The world as MJCF."""
        return self.ground.world(self.name, str(self.scenario.get("doc", "")))

    @property
    def privileged(self) -> dict[str, Any]:
        """Information for oracle planners only: the ground and the reference path."""
        return {"ground": self.ground, "reference": self.reference}

    def added_to(self, catalog: C) -> C:
        """A catalog with all that another has and this scene."""
        return catalog.with_scene(self.name, self.scenario, self.world)

    def write(self, folder: Path) -> Path:
        """Write it into a project folder, as `scenarios/<name>.toml` and `scenarios/worlds/<name>.xml`.

        Returns:
            The scenario's file.
        """
        file = folder / "scenarios" / f"{self.name}.toml"
        world = folder / "scenarios" / "worlds" / f"{self.name}.xml"
        world.parent.mkdir(parents=True, exist_ok=True)
        world.write_text(self.world, encoding="utf-8")
        file.write_text(self.toml, encoding="utf-8")
        return file


@dataclass(frozen=True, kw_only=True)
class AgentSetup:
    """Who drives in a scene as it is; a planner brings a mission and rules of its own.

    Attributes:
        robot: The robot's name.
        mission: Its mission's.
        rules: Its rule file's; empty for none.
    """

    robot: str = "jackal"
    mission: str = "go_to"
    rules: str = "avoid_collision"


@dataclass(frozen=True, kw_only=True)
class Family(AgentSetup, ABC):
    """A kind of scene. A family is a frozen, keyword-only dataclass in `scenarios/families/<name>.py`.

    Its class is the file's name in CamelCase; its fields are its parameters, numbers in SI units that are annotated
    with the types of `rocs_bt.units`, all with defaults. `scene` draws from `rng` and nothing else, so that a scene is
    the same wherever and however often it is made.

    Attributes:
        ASIDE: Parameters that have no part in what is drawn: who drives, with which mission and rules, so that all meet
            the same scenes.
    """

    NOT_SAMPLED: ClassVar[tuple[str, ...]] = ("robot", "mission", "rules")

    @property
    def name(self) -> str:
        """Its class's name in snake_case, which is its file's."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", type(self).__name__).lower()

    @property
    def doc(self) -> str:
        """The first line of its class's docstring."""
        return (type(self).__doc__ or "").strip().split("\n", 1)[0]

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters by name, in SI units."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}

    @abstractmethod
    def scene(self, index: int) -> Scene:
        """The scene of an index, 0 or more."""

    def scene_name(self, index: int) -> str:
        """What the scene of an index is called."""
        return f"{self.name}-{index}"

    def rng(self, index: int, purpose: str = "scene") -> np.random.Generator:
        """A stream of the family, its parameters but those of `ASIDE`, an index, and what it is for."""
        own = {name: value for name, value in self.parameters.items() if name not in self.NOT_SAMPLED}
        key = json.dumps([self.name, own, index, purpose], sort_keys=True)
        digest = hashlib.sha256(key.encode()).digest()
        return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


def quantity(value: float, unit: str) -> str:
    """A quantity as a file has it, to four decimals; an angle [rad] becomes one in `deg`."""
    return f"{round(math.degrees(value) if unit == 'deg' else value, 4):g} {unit}"


def position(point: Point, yaw: float | None = None) -> dict[str, str]:
    """A point [m], or a pose [m, rad], as a table has it."""
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
    """A scenario in which the agent under test must come to one place; add tables to it, such as movers, by `|`.

    Args:
        setup: Whose robot, mission and rules it has; a family is one.
        name: Of the scene, and so of its world.
        doc: One sentence for people.
        start: Where the agent stands; the seed moves it by 5 cm and 5 deg.
        goal: Where it must come to [m].
        tolerance: How near [m].
        duration: How long it has [s].
        agent: Other values of the agent's table, such as its `parameters` and when it is a `success`.
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
        "format": "scenario/1",
        "doc": doc,
        "world": name,
        "duration": quantity(duration, "s"),
        "end_on_collision": True,
        "place": [target],
        "agent": [{**under_test, **(agent or {})}],
    }


def family_parameters(family: type[Family]) -> dict[str, Parameter]:
    """What may be set of a family, by name."""
    hints = typing.get_type_hints(family, include_extras=True)
    return {f.name: Parameter.annotated(f.name, hints[f.name], False, f.default) for f in dataclasses.fields(family)}


def load_family(catalog: Catalog, name: str, values: Mapping[str, object] | None = None) -> Family:
    """A family by its name.

    Args:
        catalog: Where it is found.
        name: Its name, or its file.
        values: Its parameters as a person writes them: `{"rooms": 6, "width": "1.5 m"}`.

    Raises:
        InputError: There is no such family, its file does not load, or a parameter is wrong; with every fault.
    """
    entry = catalog.find("family", name)
    camel = "".join(part.capitalize() for part in entry.name.split("_"))
    cls = catalog.load_class(entry.path, camel)
    if not issubclass(cls, Family) or not dataclasses.is_dataclass(cls):
        hint = "Write: @dataclass(frozen=True, kw_only=True) class ...(Family)."
        raise InputError(Fault(f"'{camel}' is no dataclass that derives from Family.", entry.path, hint=hint))
    given, faults = _arguments(cls, values or {})
    if faults:
        raise InputError(*faults)
    return cls(**given)


def _arguments(family: type[Family], values: Mapping[str, object]) -> tuple[dict[str, Any], list[Fault]]:
    """A family's parameters in SI units, and what is wrong with them."""
    declared, given, faults = family_parameters(family), dict[str, Any](), list[Fault]()
    for name, value in values.items():
        if name not in declared:
            faults.append(unknown("parameter", name, declared, f"The family {family.__name__}"))
            continue
        parameter = declared[name]
        try:
            number = convert(value, parameter.dimension, name) if parameter.dimension is not None else value
        except InputError as error:
            faults += error.faults
            continue
        wrong_type = parameter.dimension is None and type(number) is not parameter.type
        if wrong_type:
            faults.append(Fault(f"{name} must be of type {parameter.type.__name__}, found {value!r}."))
        faults += [] if wrong_type else parameter.faults(number, name)
        given[name] = number
    return given, faults
