"""Keys: what an episode depends on, as one number, so that what was played once is never played again."""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import json
import platform
import sys
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from ..catalog import Catalog, Entry, PlannerSpec, content_hash
from ..python_content import texts_in
from ..simulation.header import versions
from .episode import FamilyScene, GeneratedScene, ScenarioScene, SceneRef
from .family import load_family

SCHEMA = "episode/1"
"""Of what a record holds and how its metrics are told; another one makes all keys new."""

_NOT_PLAYED = (
    *("cli", "check", "testing", "record/live"),
    *("compare/report", "compare/statistics", "compare/comparison", "compare/verdict", "compare/replay"),
    *("compare/imports", "compare/cluster", "compare/pool", "compare/sweep", "compare/search"),
)
"""What of the engine has no part in an episode."""


class Keys:
    """Tells the key of each episode of a sweep.

    It covers the content of the scene and of the planner, the parameters of both, the seed, our own code, the versions
    of what computes, and the kind of machine; so a changed number anywhere makes a new episode. A scene of a family is
    held by the family's file and parameters, since the same index is the same scene.

    Args:
        catalog: Where content is found.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._planners: dict[str, str] = {}
        self._scenes: dict[Any, str] = {}

    def of(self, planner: PlannerSpec, scene: SceneRef, seed: int, require: str = "") -> str:
        """The key of one episode.

        Raises:
            InputError: Content that it names does not exist.
        """
        if planner.name not in self._planners:
            self._planners[planner.name] = self._planner(planner)
        told = [SCHEMA, self._planners[planner.name], self._scene(scene), seed, engine_hash(), dict(computing())]
        return _digest([*told, require] if require else told)

    def _planner(self, planner: PlannerSpec) -> str:
        content = self._catalog.content_of_controller(planner)
        python = [entry.path for entry in content if entry.path.suffix == ".py"]
        versions = {name: version for path in python for name, version in libraries(path).items()}
        told = [planner.name, planner.mission, planner.rules, dict(planner.parameters), planner.latency, planner.oracle]
        return _digest([*told, *filter(None, [planner.nodes]), content_hash(content), versions])

    def _scene(self, scene: SceneRef) -> str:
        if not isinstance(scene, FamilyScene):
            if scene not in self._scenes:
                self._scenes[scene] = self._scenario(scene)
            return self._scenes[scene]
        family = replace(scene, index=0)
        if family not in self._scenes:
            self._scenes[family] = self._family(family)
        return _digest([self._scenes[family], scene.name, scene.index])

    def _scenario(self, scene: ScenarioScene | GeneratedScene) -> str:
        """Everything that a scenario uses; the mind that the planner replaces is its word for the agent only."""
        if isinstance(scene, ScenarioScene):
            catalog, named, agent = self._catalog, scene.scenario, scene.agent
        else:
            catalog, named, agent = scene.scene.added_to(self._catalog), scene.name, ""
        return _digest([scene.name, agent, catalog.digest(catalog.load_scenario(named))])

    def _family(self, scene: FamilyScene) -> str:
        family = load_family(self._catalog, scene.family, dict(scene.parameters))
        entry = self._catalog.find("family", scene.family)
        named = texts_in(entry.path) | {value for value in family.parameters.values() if isinstance(value, str)}
        robots = [robot for robot in self._catalog.list("robot") if robot.name in named]
        bases = [self._catalog.find("robot", path.parent.name) for r in robots for path in self._bases(r)]
        return _digest([family.name, family.parameters, content_hash([entry, *robots, *bases])])

    def _bases(self, robot: Entry) -> tuple[Path, ...]:
        return self._catalog.load_robot(robot.name).bases


@cache
def engine_hash() -> str:
    """sha256 of our own code that has a part in an episode."""
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for file in sorted(p for ending in ("py", "c", "h") for p in package.rglob(f"*.{ending}")):
        relative = file.relative_to(package).as_posix()
        if not relative.startswith((*_NOT_PLAYED, "_content")):
            digest.update(f"{relative}\0".encode() + file.read_bytes())
    return digest.hexdigest()


@cache
def computing() -> Mapping[str, str]:
    """The versions of what computes, and the kind of machine: what the bits of a run depend on."""
    return {**versions(), "scipy": importlib.metadata.version("scipy"), "machine": platform.machine()}


def libraries(file: Path) -> dict[str, str]:
    """The versions of the installed packages that a Python file imports, the standard library and ours excepted."""
    tree = ast.parse(file.read_text(encoding="utf-8"), str(file))
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) if node.module}
    modules = {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names) - {"rocs_bt"}
    if not modules:
        return {}
    packages = importlib.metadata.packages_distributions()
    found = {package for module in modules for package in packages.get(module, ())}
    return {package: importlib.metadata.version(package) for package in sorted(found)}


def _digest(told: object) -> str:
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()
