"""Inputs of a command line: the catalog of a file or name, the recording of a run, and the option --no-code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from .terminal import echo, own_stdout

if TYPE_CHECKING:
    from ..catalog import Catalog
    from ..record import Recording

F = TypeVar("F", bound=Callable[..., Any])

no_code_option = click.option("--no-code", is_flag=True, help="Refuse Python content.")
"""Option of every command that runs Python content."""


def json_option(text: str) -> Callable[[F], F]:
    """Option `--json`, passed as `as_json`; with it standard output has the JSON only (see `own_stdout`)."""
    return click.option("--json", "as_json", is_flag=True, help=text, callback=_reserve)


def open_recording(run: Path) -> Recording:
    """Recording of a run; at the end of the command stderr says what is missing of it, if it is cut off or damaged."""
    from ..record import Recording

    opened = click.get_current_context().meta.setdefault("rocs_bt.recordings", {})  # a command may open it twice
    if run not in opened:
        opened[run] = recording = Recording.open(run)

        def missing() -> None:
            if recording.missing:
                echo(recording.missing, err=True)

        click.get_current_context().call_on_close(missing)
    return cast("Recording", opened[run])


def _reserve(context: click.Context, _: click.Parameter, wanted: bool) -> bool:
    if wanted:
        context.with_resource(own_stdout())
    return wanted


def catalog_for(name: str, *, no_code: bool) -> Catalog:
    """Catalog of the project around a file given by path, else around the current folder."""
    from ..catalog import Catalog, is_path

    return Catalog.here(Path(name).parent if is_path(name) else None, code=not no_code)
