"""Options of a command, made from the fields of a declared class; the command gets each by the name of its field."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar

import click

from ..base.units import FINITE, NONE, POSITIVE, TIME, Bounds, Dimension, Seconds, read_quantity
from ..declare import Declared, Field, Option, Value, options_of


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


F = TypeVar("F", bound=Callable[..., Any])


class EpisodeOptions(Value):
    """Options of the commands that play many episodes."""

    store: Annotated[
        Path, "Folder of stored episodes, which are not played again.", Option(("--store",), path="folder")
    ] = Path("runs/compare")
    jobs: Annotated[
        int | None, Bounds(1), "Number of worker processes; by default one per core.", Option(("--jobs", "-j"))
    ] = None
    wall_limit: Annotated[Seconds, POSITIVE, "Wall-clock limit of an episode.", Option(("--wall-limit",))] = 300.0


def declared_options(cls: type[Declared], stage: str = "") -> Callable[[F], F]:
    """Decorator that adds the options of a class to a command; those for another stage of a run are left out."""
    options = [_option(*o) for o in options_of(cls).values() if o[1].flags and (not stage or o[1].stage in ("", stage))]

    def decorate(command: F) -> F:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def _option(each: Field, option: Option) -> Callable[[Any], Any]:
    default, bounds = None if each.required else each.default, each.mark(Bounds) or FINITE
    words: dict[str, Any] = {"help": each.doc, "metavar": option.metavar}
    words |= {"required": True} if each.required else {"default": default}
    if each.hint is bool:
        words["is_flag"] = True
    elif each.options:
        words |= {"type": click.Choice(each.options), "show_default": default is not None}
    elif each.hint is Path:
        folder, file = option.path != "file", option.path != "folder"
        words |= {"type": click.Path(path_type=Path, dir_okay=folder, file_okay=file), "show_default": bool(default)}
    elif each.hint is int:
        low, high = (int(limit) if abs(limit) < float("inf") else None for limit in (bounds.low, bounds.high))
        words |= {"type": click.IntRange(low, high), "show_default": default is not None}
    elif each.hint is float:
        words |= {"type": QuantityType(each.mark(Dimension) or NONE, bounds), "show_default": default is not None}
    elif each.many:
        words |= {"type": None if each.hint is str else each.hint.read, "multiple": True}
    return click.option(*option.flags, each.name, **words)
