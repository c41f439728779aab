"""Types of ports in a TreeNodesModel: types of C++, or units."""

from __future__ import annotations

import re
from typing import Annotated, Any

from ...errors import InputError
from ...units import NONE, parse_quantity, parse_unit
from .model import ModelPort

_WHOLE = frozenset(
    ["int", "unsigned", "unsigned int", "short", "unsigned short", "long", "unsigned long", "long long", "size_t"]
    + [f"{sign}int{bits}{t}" for sign in ("", "u") for bits in (8, 16, 32, 64) for t in ("", "_t")]
)
_REAL = ("double", "float", "long double")
_QUALIFIERS = re.compile(r"\bconst\b|\bstd::(?=size_t|u?int\d)|[&*]")
_CLASS = re.compile(r"\w+(?:::\w+)+|[\w:]+<.+>|[A-Z][a-z0-9]\w*|char")
_TEXT = ("", "std::string", "string", "BT::AnyTypeAllowed", "AnyTypeAllowed")


def annotation(port: ModelPort) -> Any:
    """The annotation of a Python parameter for a port: its type, and its dimension.

    Classes of C++ such as `geometry_msgs::msg::PoseStamped` or `std::vector<double>` are texts, which the nodes that
    read them parse.

    Raises:
        InputError: The type is neither a type of C++ nor a unit.
    """
    kind = _QUALIFIERS.sub("", port.type).strip()
    if kind in _WHOLE:
        return int
    if kind == "bool":
        return bool
    if kind in _TEXT:
        return str
    if kind in _REAL:
        return Annotated[float, NONE if port.default is None else parse_quantity(port.default).dimension]
    try:
        return Annotated[float, parse_unit(kind).dimension]
    except InputError:
        if _CLASS.fullmatch(kind):
            return str
        raise
