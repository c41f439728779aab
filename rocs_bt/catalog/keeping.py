"""KeepingCatalog: content that is read once for many episodes."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar, cast

from .catalog import Catalog
from .entry import Entry
from .planner_file import PlannerSpec
from .robot_spec import RobotSpec
from .scenario_file import AgentSpec, ScenarioSpec

T = TypeVar("T")

LIMIT = 64
"""How many things are kept; what was not used for longest is let go."""


class KeepingCatalog(Catalog):
    """A catalog that keeps what it has read and what was made of it. Files must not change while it is in use.

    Args:
        project: The project's root; None for shipped content only.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        super().__init__(project, code=code)
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()

    def keep(self, key: Hashable, make: Callable[[], T]) -> T:
        if key in self._kept:
            self._kept.move_to_end(key)
            return cast("T", self._kept[key])
        made = self._kept[key] = make()
        if len(self._kept) > LIMIT:
            self._kept.popitem(last=False)
        return made

    def load_robot(self, name: str) -> RobotSpec:
        return self.keep(("robot", name), lambda: super(KeepingCatalog, self).load_robot(name))

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        key = "mission", name, dialect
        return self.keep(key, lambda: super(KeepingCatalog, self).load_mission(name, dialect))

    def content_of_mind(self, mind: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        key = "mind", mind.mission, mind.rules, repr(mind.parameters), mind.nodes
        return self.keep(key, lambda: super(KeepingCatalog, self).content_of_mind(mind))

    def digest(self, scenario: ScenarioSpec) -> str:
        minds = tuple((a.name, a.mission, a.rules, repr(a.parameters), a.nodes) for a in scenario.agents)
        return self.keep(("digest", scenario.file, minds), lambda: super(KeepingCatalog, self).digest(scenario))
