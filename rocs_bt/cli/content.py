"""Content of a command line: the catalog of a file or name, and the option --no-code."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..catalog import Catalog

no_code_option = click.option("--no-code", is_flag=True, help="Refuse Python content.")
"""Option of every command that runs Python content."""


def catalog_for(name: str, *, no_code: bool) -> Catalog:
    """Catalog of the project around a file given by path, else around the current folder."""
    from ..catalog import Catalog, is_path

    return Catalog.here(Path(name).parent if is_path(name) else None, code=not no_code)
