"""Speak and Log: emit a text for people nearby or for the recording."""

from typing import Annotated, Any

from rocs_bt.event import Said
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import SUCCESS, Instant, Outcome


class Speak(Instant):
    """Emits a text to be spoken; SUCCESS.

        <Speak text="I am coming."/>

    A robot with a loudspeaker subscribes to the events `Said`, which are recorded too.
    """

    text: Annotated[Any, "text, or a key"]

    def update(self) -> Outcome:
        mission = mission_of(self)
        mission.note(Said, node=mission.path(self), text=str(self.text), aloud=True)
        return SUCCESS


class Log(Instant):
    """Writes a text to the recording, optionally followed by a value; SUCCESS.

    <Log text="tries left:" value="{tries}"/>
    """

    text: Annotated[str, "text"] = ""
    value: Annotated[Any, "value, usually a key"] = None

    def update(self) -> Outcome:
        mission, value = mission_of(self), self.value
        shown = "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        text = f"{self.text} {shown}".strip()
        mission.note(Said, node=mission.path(self), text=text)
        return SUCCESS
