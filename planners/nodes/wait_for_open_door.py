"""WaitForOpenDoor: wait until a robot has observed an open door."""

from math import inf
from typing import Annotated

from rocs_bt.base.units import TimeLimit
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Leaf, Outcome, Output


class WaitForOpenDoor(Leaf):
    """RUNNING until a door is known to be open, then SUCCESS; FAILURE if all doors are closed, or none is open in time.

        <WaitForOpenDoor patience="2 min" found="{door}"/>
        <WaitForOpenDoor door="hatch" patience="3 s"/>

    A door counts only with an observation of it in Knowledge that has at least `confidence`, made by this robot or by
    one that shares its knowledge. The nearest open door is found first. Without a known door it waits, because another
    robot may share doors.
    """

    door: Annotated[str, "name of the door; any door if empty"] = ""
    confidence: Annotated[float, "minimum confidence of the observation, 0 to 1"] = 0.9
    patience: Annotated[TimeLimit, "time after which it fails [s]"] = inf
    found: Annotated[Output[str], "name of the open door"]

    def __init__(self, name="", /, **attributes):
        super().__init__(name, **attributes)
        self._since = 0.0
        self._unseen = ""

    def initialise(self) -> None:
        self._since = mission_of(self).clock.now()

    def update(self) -> Outcome:
        mission = mission_of(self)
        doors = [self.door] if self.door else mission.knowledge.graph.nodes("door")
        answers = mission.knowledge.ask(
            "observation observes door where observation.confidence >= least order by distance(door) give door.open",
            least=self.confidence,
        )
        observed = {row["door"]: row["door.open"] for row in answers.dicts if row["door"] in doors}
        if (door := next((name for name, is_open in observed.items() if is_open), None)) is not None:
            self.found = door
            self.feedback_message = f"{door} is open"
            return SUCCESS
        unseen = ", ".join(name for name in doors if name not in observed)
        if doors and not unseen:
            self.feedback_message = f"closed: {', '.join(doors)}"
            return FAILURE
        self._unseen = unseen
        waited = mission.clock.now() - self._since
        reason = f"no door is known to be open after {waited:.1f} s; not observed: {unseen}"
        self.feedback_message = reason if doors else f"no door is known after {waited:.1f} s"
        return RUNNING if waited < self.patience else FAILURE

    def wait_text(self) -> str:
        unseen = f"; not observed: {self._unseen}" if self._unseen else "; none is known"
        deadline = self._since + self.patience
        return f"for an open door{unseen}" + (f", until {deadline:.2f} s" if deadline < inf else "")
