"""Trial: one episode to be played, small enough to be sent to another process or another machine."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from ..catalog import PlannerSpec
from .family import Scene


@dataclass(frozen=True)
class FamilyScene:
    """A scene of a family; the worker that plays it makes it.

    Attributes:
        family: The family's name.
        index: Which of its scenes.
        parameters: The family's, as a person writes them, in the order of their names.
    """

    family: str
    index: int
    parameters: tuple[tuple[str, Any], ...] = ()

    @property
    def group(self) -> str:
        """What its results are told under: the family, and the parameters that are not its own."""
        told = ", ".join(f"{name}={value}" for name, value in self.parameters)
        return f"{self.family}({told})" if told else self.family

    @property
    def name(self) -> str:
        """The cluster that its seeds belong to."""
        return f"{self.group}-{self.index}"


@dataclass(frozen=True)
class ScenarioScene:
    """A scenario that was written by hand.

    Attributes:
        scenario: Its name or its file.
        agent: Whose planner is compared; the first one by default.
    """

    scenario: str
    agent: str = ""

    @property
    def group(self) -> str:
        """What its results are told under: the scenario, and the agent where one was given, as in `exp3:R2`."""
        return ":".join(filter(None, (Path(self.scenario).stem, self.agent)))

    @property
    def name(self) -> str:
        """The cluster that its seeds belong to."""
        return self.group


@dataclass(frozen=True)
class GeneratedScene:
    """A scene that a program made; whoever plays it is sent its values.

    Attributes:
        digest: sha256 of its texts, by which two are the same.
        scene: The scene.
    """

    digest: str
    scene: Scene = field(compare=False, repr=False)

    @staticmethod
    def of(scene: Scene) -> GeneratedScene:
        """The place of a scene."""
        return GeneratedScene(hashlib.sha256(f"{scene.toml}\0{scene.world}".encode()).hexdigest(), scene)

    @property
    def group(self) -> str:
        """What its results are told under."""
        return self.scene.name

    @property
    def name(self) -> str:
        """The cluster that its seeds belong to."""
        return self.scene.name


SceneRef: TypeAlias = FamilyScene | ScenarioScene | GeneratedScene


@dataclass(frozen=True)
class Episode:
    """One episode to be played.

    Attributes:
        key: What it depends on, as one number (`Keys`).
        planner: Who decides.
        scene: Scene to play in.
        seed: The episode's seed.
        project: The project in which content is found; None for shipped content.
        wall_limit: How long it may take to compute [s].
        require: One more requirement on the agent, such as `always min(front) > 0.05 m`; empty for none.
        code: Whether Python content may run.
    """

    key: str
    planner: PlannerSpec
    scene: SceneRef
    seed: int
    project: Path | None = None
    wall_limit: float = 300.0
    require: str = ""
    code: bool = True


def scenes_of(
    family: str, count: int | Iterable[int], parameters: Mapping[str, Any] | None = None
) -> list[FamilyScene]:
    """Scenes of a family: the first `count`, or those of certain indices."""
    indices = range(count) if isinstance(count, int) else count
    return [FamilyScene(family, index, tuple(sorted((parameters or {}).items()))) for index in indices]
