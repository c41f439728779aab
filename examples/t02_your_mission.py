# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Give R2 a mission of your own: drive to a lookout, look back, and go to the origin.

A mission is a function `build` that returns a py_trees tree; `mission.act` creates leaves that run actions. Here the
function replaces the shipped mission of EXP1. The reflexes remain active, and the mission needs no code for them: a
leaf submits its action again from the robot's new pose if a reflex has cancelled the action. An event sink
prints the status changes of the tree during the run.

Output:

      0.0 s  RUNNING  there and back/GoTo lookout
      0.0 s  RUNNING  there and back
      3.1 s  again    there and back/GoTo lookout, after a reflex
      7.2 s  again    there and back/GoTo lookout, after a reflex
     12.1 s  RUNNING  there and back/look back
     12.1 s  SUCCESS  there and back/GoTo lookout
     14.0 s  RUNNING  there and back/look
     14.0 s  SUCCESS  there and back/look back
     15.0 s  RUNNING  there and back/GoTo goal
     15.0 s  SUCCESS  there and back/look
     17.5 s  SUCCESS  there and back/GoTo goal
     17.5 s  SUCCESS  there and back
    exp1, seed 1, 17.6 s simulated
    R2 success; 4.02 m, 0 collisions, 2 reflexes, 2 resumed actions
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

import rocs_bt
from rocs_bt import MetresPerSecond
from rocs_bt.event import Event, NodeTicked, Replanned


def build(mission: rocs_bt.Mission, *, cruise: MetresPerSecond = 0.4) -> Behaviour:
    """Build the tree: drive to the lookout, look back, drive to the goal."""
    mission.knowledge.world.place("lookout", rocs_bt.Pose2(-0.5, -0.5), kind="goal")
    return Sequence(
        "there and back",
        memory=True,
        children=[
            mission.act("GoTo", goal="lookout", cruise=cruise),
            mission.act("TurnTo", yaw="90 deg", name="look back"),
            mission.wait("1 s", name="look"),
            mission.act("GoTo", goal="goal", cruise=cruise),
        ],
    )


class Printer:
    """Event sink that prints status changes and replanning of the tree's nodes."""

    def __init__(self) -> None:
        self.status: dict[str, str] = {}

    def emit(self, event: Event) -> None:
        """Print an event if it concerns the tree."""
        if isinstance(event, NodeTicked):
            if self.status.get(event.node) == event.status:  # only its feedback has changed
                return
            self.status[event.node] = event.status
            print(f"{event.t:5.1f} s  {event.status:8} {event.node}")
        elif isinstance(event, Replanned):
            print(f"{event.t:5.1f} s  again    {event.node}, after a reflex")


result = rocs_bt.run("exp1", missions={"R2": build}, duration=90.0, sinks=[Printer()])
print(result)
