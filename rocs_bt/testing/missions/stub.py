"""Stubs: classes for leaves that a document names and nobody has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import Fault
from ...trees.nodes import FAILURE, Leaf, Outcome


class _Stub(Leaf):
    """A leaf that takes whatever ports it is given, and fails unless something stands in for it."""

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        kept = {n: v for n, v in attributes.items() if n.startswith("_")}
        super().__init__(name, **kept)

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return super().attribute_faults({n: v for n, v in attributes.items() if n.startswith("_")})

    def update(self) -> Outcome:
        self.feedback_message = "nobody knows what this is"
        return FAILURE


def stub(tag: str) -> type[Leaf]:
    """A class of that name."""
    return type(tag, (_Stub,), {"tag": tag, "__doc__": "Stands for a node that is not here."})
