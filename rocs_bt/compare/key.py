"""Keys: hashes of everything that an episode depends on, so that no episode is played twice."""

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

from ..base.files import read_bytes, read_text
from ..base.python_content import texts_in
from ..catalog import Catalog, PlannerSpec, content_hash
from ..declare import values_of
from ..running.header import versions
from .episode import FamilyScene, GeneratedScene, ScenarioScene, SceneRef
from .family import load_family

SCHEMA = "episode/1"
"""Version of the record format and of the metric definitions; a new version changes all keys."""

_NOT_PLAYED = (
    "cli",
    "check",
    "testing",
    "studio",
    "search",
    "compare/report",
    "compare/statistics",
    "compare/comparison",
    "compare/verdict",
    "compare/replay",
    "compare/cold",
    "compare/pool",
    "compare/run_sweep",
)
"""Folders and modules of rocs_bt that do not affect the result of an episode."""


class EpisodeKeys:
    """Computes the keys of a sweep's episodes.

    A key is a hash of the content and parameters of scene and planner, the seed, the engine's code, the versions of
    numerical packages and the machine type. If any of these changes, the episode has a new key and is played again. For
    a scene of a family, the family's file, its parameters and the index are hashed instead of the generated scene.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._planners: dict[str, str] = {}
        self._scenes: dict[Any, str] = {}

    def of(self, planner: PlannerSpec, scene: SceneRef, seed: int, require: str = "") -> str:
        """Key of one episode.

        Raises:
            InputError: Content that the episode names does not exist.
        """
        if planner.name not in self._planners:
            self._planners[planner.name] = self._planner(planner)
        parts = [SCHEMA, self._planners[planner.name], self._scene(scene), seed, engine_hash(), dict(computing())]
        return _digest([*parts, require] if require else parts)

    def _planner(self, planner: PlannerSpec) -> str:
        content = self._catalog.content_of_controller(planner)
        if planner.robot:
            content += self._catalog.content_of_robot(planner.robot)
        python = [file for entry in content if entry.path.suffix == ".py" for file in entry.files()]
        versions = {name: version for path in python for name, version in libraries(path).items()}
        own = [planner.name, planner.mission, planner.rules, dict(planner.parameters), planner.latency, planner.oracle]
        more = [each for each in (planner.nodes, [values_of(each) for each in planner.perturbations]) if each]
        return _digest([*own, *more, content_hash(content), versions])

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
        """Digest of all content of a scenario, except the controller that the planner replaces."""
        if isinstance(scene, ScenarioScene):
            catalog, named, agent = self._catalog, scene.scenario, scene.agent
        else:
            catalog, named, agent = scene.scene.added_to(self._catalog), scene.name, ""
        return _digest([scene.name, agent, catalog.digest(catalog.load_scenario(named))])

    def _family(self, scene: FamilyScene) -> str:
        family = load_family(self._catalog, scene.family, dict(scene.parameters))
        entry = self._catalog.find("family", scene.family)
        named = {text for file in entry.files() for text in texts_in(file)}
        named |= {value for value in family.parameters.values() if isinstance(value, str)}
        robots = [robot for robot in self._catalog.list("robot") if robot.name in named]
        bases = [base for robot in robots for base in self._catalog.content_of_robot(robot.name)[1:]]
        return _digest([family.name, family.parameters, content_hash([entry, *robots, *bases])])


@cache
def engine_hash() -> str:
    """sha256 of all code of rocs_bt that affects the result of an episode."""
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for file in sorted(p for ending in ("py", "c", "h") for p in package.rglob(f"*.{ending}")):
        relative = file.relative_to(package).as_posix()
        if not relative.startswith((*_NOT_PLAYED, "_content")):
            digest.update(f"{relative}\0".encode() + read_bytes(file))
    return digest.hexdigest()


@cache
def computing() -> Mapping[str, str]:
    """Versions of the numerical packages, and the machine type: the exact numbers of a run depend on them."""
    return {**versions(), "scipy": importlib.metadata.version("scipy"), "machine": platform.machine()}


def libraries(file: Path) -> dict[str, str]:
    """Versions of the installed packages that a Python file imports, except the standard library and rocs_bt."""
    tree = ast.parse(read_text(file), str(file))
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    names |= {
        node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module and not node.level
    }
    modules = {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names) - {"rocs_bt"}
    if not modules:
        return {}
    found = {package for module in modules for package in _packages().get(module, ())}
    return {package: importlib.metadata.version(package) for package in sorted(found)}


@cache
def _packages() -> Mapping[str, list[str]]:
    """Installed packages by module; reading their metadata takes longer than a short episode."""
    return importlib.metadata.packages_distributions()


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True, default=str).encode()).hexdigest()
