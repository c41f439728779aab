"""Late: attributes of py_trees' behaviours that few nodes need and that take long to make."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Late:
    """An attribute that is made when it is first asked for.

    Args:
        make: Makes the value for a node.
    """

    def __init__(self, make: Callable[[Any], Any]) -> None:
        self._make = make
        self._name = ""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        self._name = name

    def __get__(self, node: Any, owner: type[Any]) -> Any:
        if node is None:
            return self
        value = self._make(node)
        setattr(node, self._name, value)  # from now on Python finds this one first
        return value
