"""Stub leaves for node names without a class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...base.errors import Fault
from ...trees.nodes import FAILURE, Leaf, Outcome


class _Stub(Leaf):
    """Leaf that accepts any ports and fails unless it is substituted."""

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        kept = {n: v for n, v in attributes.items() if n.startswith("_")}
        super().__init__(name, **kept)

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return super().attribute_faults({n: v for n, v in attributes.items() if n.startswith("_")})

    def update(self) -> Outcome:
        self.feedback_message = "this node has no class"
        return FAILURE


def stub_leaf(tag: str) -> type[Leaf]:
    """Return a stub class for the XML tag of a node without a class."""
    return type(tag, (_Stub,), {"tag": tag, "__doc__": "Stub of a node without a class."})
