"""Options of the commands that play many episodes."""

from __future__ import annotations

from pathlib import Path

import click

from ..base.units import POSITIVE
from .quantity import QuantityType

store_option = click.option(
    "--store",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs/compare"),
    show_default=True,
    help="Folder of stored episodes, which are not played again.",
)

jobs_option = click.option(
    "--jobs", "-j", type=click.IntRange(min=1), help="Number of worker processes; by default one per core."
)

wall_limit_option = click.option(
    "--wall-limit",
    type=QuantityType(bounds=POSITIVE),
    default=300.0,
    show_default=True,
    help="Wall-clock limit of an episode.",
)
