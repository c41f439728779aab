# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Replace a subtree of a mission while the robot drives: R2 visits the second place of its rounds in another way.

The mission `rounds` visits two places by the subtrees `visit first` and `visit second`. At 8 s, while R2 drives to the
second place, the tree in careful.xml replaces the one inside `visit second`: the drive is cancelled, and R2 goes on as
the new tree says. The new tree has the blackboard of its place, so it knows `place` and `cruise`. On the command line:

    rocs-bt run rounds --swap "visit second=careful.xml@8"

Output:

      0.0 s  GoTo west at 0.4 m/s: RUNNING
      5.7 s  GoTo west at 0.4 m/s: SUCCEEDED
      6.3 s  GoTo east at 0.4 m/s: RUNNING
      8.0 s  GoTo east at 0.4 m/s: CANCELLED
      8.0 s  'Repeat/one round/visit second/Sequence' was replaced by 'Repeat/one round/visit second/carefully'
      8.0 s  R2 says: I come slowly
      8.0 s  GoTo east at 0.2 m/s: RUNNING
     18.4 s  GoTo east at 0.2 m/s: SUCCEEDED
     18.5 s  GoTo west at 0.4 m/s: RUNNING
     20.0 s  GoTo west at 0.4 m/s: CANCELLED
    replay: all events are equal
"""

import tempfile
from pathlib import Path

import rocs_bt
from rocs_bt.event import Event, Said, SubtreeSwapped, TicketChanged
from rocs_bt.record import Recording, SubtreeSwap
from rocs_bt.running import replay

CAREFUL = """
<root BTCPP_format="4" main_tree_to_execute="careful">
  <BehaviorTree ID="careful">
    <Sequence name="carefully">
      <Speak text="{warning}"/>
      <GoTo goal="{place}" cruise="{slow}"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="careful">
      <input_port name="place">place to visit, which `rounds` gives</input_port>
      <input_port name="slow" type="m/s" default="0.2 m/s">speed</input_port>
      <input_port name="warning" default="I come slowly">words for people nearby</input_port>
    </SubTree>
  </TreeNodesModel>
</root>
"""


class Printer:
    """Event sink that prints what R2 does."""

    def emit(self, event: Event) -> None:
        """Print an event of the mission."""
        if isinstance(event, SubtreeSwapped):
            print(f"{event.t:5.1f} s  {event.sentence}")
        elif isinstance(event, Said):
            print(f"{event.t:5.1f} s  R2 says: {event.sentence}")
        elif isinstance(event, TicketChanged) and event.state != "QUEUED":
            goal, speed = event.parameters.get("goal", ""), event.parameters.get("cruise", 0.0)
            print(f"{event.t:5.1f} s  {event.action} {goal} at {speed:g} m/s: {event.state}")


with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "careful.xml"
    file.write_text(CAREFUL, encoding="utf-8")
    result = rocs_bt.run(
        "rounds",
        duration=20.0,
        out=Path(folder) / "run",
        report=False,
        sinks=[Printer()],
        swaps=[SubtreeSwap("visit second", str(file), at=8.0)],
    )
    assert result.recording is not None
    same = replay(Recording.open(result.recording)) is None
    print("replay:", "all events are equal" if same else "the events differ")
