"""Warmer: condition on the temperature at a port."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome
from rocs_bt_thermometer.driver import celsius


class Warmer(Instant):
    """SUCCESS if a port's temperature is above a limit, else FAILURE.

    <Warmer port="/dev/ttyUSB0" than="20"/>
    """

    kind = "Condition"
    port: Annotated[str, "file of the thermometer"]
    than: Annotated[float, "limit [°C]"]

    def update(self) -> Outcome:
        """Read and compare."""
        return SUCCESS if celsius(Path(self.port)) > self.than else FAILURE
