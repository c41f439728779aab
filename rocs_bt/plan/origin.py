"""Origin of nodes made in Python: the line of the mission that made them."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import Fault
from ..raised import CodeLocation, called_at


@dataclass(frozen=True)
class MissionLine:
    """The line of a Python mission that made a node; the counterpart of an element of an XML mission.

    Attributes:
        location: The line.
    """

    location: CodeLocation

    @classmethod
    def here(cls) -> MissionLine | None:
        """The line of content that is being executed; None if none is."""
        location = called_at()
        return None if location is None else cls(location)

    def fault(
        self, message: str, hint: str = "", *, attribute: str = "", column: int | None = None, warning: bool = False
    ) -> Fault:
        """A fault at the line; attribute and column are not used."""
        return Fault(message, self.location.file, self.location.line, hint=hint, warning=warning)
