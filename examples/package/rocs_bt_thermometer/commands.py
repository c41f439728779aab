"""`rocs-bt thermometer`."""

from __future__ import annotations

from pathlib import Path

import click

from rocs_bt_thermometer.driver import celsius


@click.command()
@click.argument("port", type=click.Path(path_type=Path))
def thermometer(port: Path) -> None:
    """Print the temperature at PORT."""
    click.echo(f"{celsius(port):g} °C")
