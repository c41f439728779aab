"""Say something: to the people nearby, or to the log."""

from rocs_bt.event import Said
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import SUCCESS, Input, Instant, Outcome


class Speak(Instant):
    """Says a text aloud; SUCCESS. A robot with a loudspeaker listens to the events `Said`; the recording has them.

    <Speak text="I am coming."/>
    """

    text = Input(object, doc="the text, or a key")

    def update(self) -> Outcome:
        mission = mission_of(self)
        mission.note(Said, node=mission.path(self), text=str(self.text), aloud=True)
        return SUCCESS


class Log(Instant):
    """Writes a text to the recording, and a value after it; SUCCESS.

    <Log text="tries left:" value="{tries}"/>
    """

    text = Input(str, "", "the text")
    value = Input(object, None, "a key")

    def update(self) -> Outcome:
        mission, value = mission_of(self), self.value
        shown = "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        text = f"{self.text} {shown}".strip()
        mission.note(Said, node=mission.path(self), text=text)
        return SUCCESS
