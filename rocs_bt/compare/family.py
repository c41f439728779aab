"""Family: unlimited scenes of one kind, each an ordinary scenario and its world."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
import typing
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..action import Parameter
from ..catalog import Catalog
from ..errors import Fault, InputError, unknown
from ..units import convert
from .thing import Point

AGENT = "R"
"""The agent under test in every family's scenes."""


@dataclass(frozen=True)
class Scene:
    """One scene: a scenario and its world as texts, and what is known of them.

    Attributes:
        name: Its family's name and its index, such as `barn_like-17`; the stem of both files.
        scenario: The scenario, as TOML; its world is named as the scene is.
        world: The world, as MJCF.
        difficulty: How hard it is, by measure; the family's class says what each is, in which unit.
        reference: Corners of a shortest way from start to goal of the robot's inscribed circle [m].
        reference_length: How long that way is [m].
        extras: What only an oracle may know.
    """

    name: str
    scenario: str
    world: str
    difficulty: Mapping[str, float] = field(default_factory=dict)
    reference: tuple[Point, ...] = ()
    reference_length: float = 0.0
    extras: Mapping[str, Any] = field(default_factory=dict)

    def write(self, folder: Path) -> Path:
        """Write it into a project folder, as `scenarios/<name>.toml` and `scenarios/worlds/<name>.xml`.

        Returns:
            The scenario's file.
        """
        file = folder / "scenarios" / f"{self.name}.toml"
        world = folder / "scenarios" / "worlds" / f"{self.name}.xml"
        world.parent.mkdir(parents=True, exist_ok=True)
        world.write_text(self.world, encoding="utf-8")
        file.write_text(self.scenario, encoding="utf-8")
        return file


@dataclass(frozen=True, kw_only=True)
class Driver:
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
class Family(Driver, ABC):
    """A kind of scene. A family is a frozen, keyword-only dataclass in `scenarios/families/<name>.py`.

    Its class is the file's name in CamelCase; its fields are its parameters, numbers in SI units that are annotated
    with the types of `rocs_bt.units`, all with defaults. `scene` draws from `rng` and nothing else, so that a scene is
    the same wherever and however often it is made.

    Attributes:
        ASIDE: Parameters that have no part in what is drawn: who drives, with which mission and rules, so that all meet
            the same scenes.
    """

    ASIDE: ClassVar[tuple[str, ...]] = ("robot", "mission", "rules")

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

    def rng(self, index: int, what: str = "scene") -> np.random.Generator:
        """A stream of the family, its parameters but those of `ASIDE`, an index, and what it is for."""
        own = {name: value for name, value in self.parameters.items() if name not in self.ASIDE}
        key = json.dumps([self.name, own, index, what], sort_keys=True)
        digest = hashlib.sha256(key.encode()).digest()
        return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


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
