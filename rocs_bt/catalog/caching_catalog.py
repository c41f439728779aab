"""CachingCatalog: catalog that keeps what it has loaded."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar, cast

from ..declare import place_of
from .catalog import Catalog
from .entry import Entry
from .planner_file import PlannerSpec
from .robot_spec import RobotSpec
from .scenario_file import AgentSpec, ScenarioSpec

T = TypeVar("T")

LIMIT = 64
"""Maximum number of cached objects; then the least recently used one is dropped."""


class CachingCatalog(Catalog):
    """Catalog that caches loaded content and objects made of it. Files must not change while the catalog is in use.

    Args:
        project: Project's root; None for shipped content only.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        super().__init__(project, code=code)
        self._cached: OrderedDict[Hashable, Any] = OrderedDict()

    def cached(self, key: Hashable, make: Callable[[], T]) -> T:
        if key in self._cached:
            self._cached.move_to_end(key)
            return cast("T", self._cached[key])
        made = self._cached[key] = make()
        if len(self._cached) > LIMIT:
            self._cached.popitem(last=False)
        return made

    def load_robot(self, name: str) -> RobotSpec:
        return self.cached(("robot", name), lambda: super(CachingCatalog, self).load_robot(name))

    def robot_of(self, agent: AgentSpec) -> RobotSpec:
        return self.cached(
            ("robot", agent.robot, place_of(agent.overlay), repr(agent.overlay)),
            lambda: super(CachingCatalog, self).robot_of(agent),
        )

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        key = "mission", name, dialect
        return self.cached(key, lambda: super(CachingCatalog, self).load_mission(name, dialect))

    def read_scenario(self, name: str, *, missions: bool = True) -> ScenarioSpec:
        key = "scenario", name, missions, self.made
        return self.cached(key, lambda: super(CachingCatalog, self).read_scenario(name, missions=missions))

    def content_of_controller(self, controller: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        key = "controller", controller.mission, controller.rules, repr(controller.parameters), controller.nodes
        return self.cached(key, lambda: super(CachingCatalog, self).content_of_controller(controller))

    def digest(self, scenario: ScenarioSpec, more: tuple[Entry, ...] = ()) -> str:
        agents = tuple((a.name, a.robot, a.mission, a.rules, repr(a.parameters), a.nodes) for a in scenario.agents)
        return self.cached(
            ("digest", scenario.file, self.made, agents, more),
            lambda: super(CachingCatalog, self).digest(scenario, more),
        )
