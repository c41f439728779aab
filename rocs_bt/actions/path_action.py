"""PathAction: base class of the actions that move the robot along a path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from ..base.errors import InputError, KnowledgeError
from ..base.units import Bounds, Metres
from ..control.locomotion import Locomotion
from ..event import Value
from ..interfaces.action import Action, Body, MacroAction
from .heading import ALONG, Heading
from .path_drive import TURN_FIRST, PathDrive

if TYPE_CHECKING:
    from ..knowledge import Knowledge


Height = Annotated[Metres, Bounds(infinite=True)]
"""Type of the parameter `height` [m]; +inf for no change."""


class PathAction(MacroAction):
    """Base class of actions along a path; its subclasses declare the parameters `heading` and `height`.

    Attributes:
        heading: Yaw of the robot, see `Heading`; all but `along` need a body that moves sideways.
        height: Height to fly at [m]; +inf for no change. It needs a body that flies.
    """

    if TYPE_CHECKING:  # see `GoalAction`
        heading: str
        height: float

    def __post_init__(self) -> None:
        self._heading = Heading(self.heading)

    @property
    def parameters(self) -> dict[str, Value]:
        """Parameters as plain data, without a heading or a height that is not set."""
        given = super().parameters
        if self._heading.along:
            del given["heading"]
        if math.isinf(self.height):
            del given["height"]
        return given

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterator[tuple[str, str]]:
        try:
            locomotion = knowledge.robot.locomotion
        except KnowledgeError:
            return
        try:
            if wrong := Heading(parameters.get("heading", ALONG)).misfit(locomotion):
                yield "heading", wrong
        except InputError as error:
            yield "heading", str(error.faults[0].message).removesuffix(".")
        if not math.isinf(parameters.get("height", math.inf)) and (wrong := _height_misfit(locomotion)):
            yield "height", wrong

    def resume(self, cut_off: Action) -> None:
        if isinstance(cut_off, type(self)) and cut_off.heading == self.heading:
            self._heading = cut_off._heading

    def path_drive(
        self, body: Body, cruise: float, lateral_acceleration: float = 1.0, turn_first: float = TURN_FIRST
    ) -> PathDrive:
        """Create the PathDrive of this action; arguments as for `PathDrive`.

        Raises:
            InputError: The body cannot have the heading or the height.
        """
        wrong = self._heading.misfit(body.locomotion)
        if not math.isinf(self.height):
            wrong = wrong or _height_misfit(body.locomotion)
        if wrong:
            raise InputError(f"{wrong}.")
        return PathDrive(body, cruise, lateral_acceleration, turn_first, self._heading, self.height)


def _height_misfit(locomotion: Locomotion) -> str:
    """Reason why a body cannot change its height; empty if it can."""
    return "" if "vz" in locomotion.axes else f"a '{locomotion.kind}' locomotion cannot fly"
