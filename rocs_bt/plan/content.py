"""Content: what a mission may ask for by name; the catalog gives it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

from ..errors import Fault, InputError
from ..trees.nodes import Node
from .route import RoutePlanner


class Content(Protocol):
    """Node classes and route planners of a project, and those that we ship."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """The node classes of these names that there are, or all."""
        ...

    def load_route(self, name: str) -> type[RoutePlanner]:
        """The route planner of a name.

        Raises:
            InputError: There is none.
        """
        ...


class NoContent:
    """The content of a mission that no catalog loaded: there is none."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """None at all."""
        return ()

    def load_route(self, name: str) -> type[RoutePlanner]:
        """Refuse.

        Raises:
            InputError: Always.
        """
        hint = "Set `mission.content` to a Catalog, or have the catalog load the mission."
        raise InputError(
            Fault(f"the route planner '{name}' was asked for, and this mission has no catalog.", hint=hint)
        )
