"""Options of the command line that take a quantity."""

from __future__ import annotations

from typing import Any

import click

from ..base.units import FINITE, NONE, TIME, Bounds, Dimension, read_quantity


class QuantityType(click.ParamType):  # type: ignore[type-arg]  # older versions are not generic
    """Quantity such as `3 s` or `500 ms`, or a plain number in SI units."""

    def __init__(self, dimension: Dimension = TIME, bounds: Bounds = FINITE) -> None:
        self.name = "quantity" if dimension != NONE else "number"
        self._dimension = dimension
        self._bounds = bounds

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Name of the value in the help."""
        return {"s": "SECONDS", "1/s": "HZ"}.get(str(self._dimension), self.name.upper())

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Convert a text to SI units; a default is a number already."""
        what = "this value" if param is None else param.opts[0]
        return read_quantity(str(value), self._dimension, what, self._bounds)
