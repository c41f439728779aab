# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Break a sensor in mid-run, and see the robot stand still until it is back.

`prepare` gets the stage before the minds are built, and may put another device in any place. rocs_bt.testing.faults has
devices that die, freeze, lie, hang or refuse. Here the sonars refuse to be read from 2 s to 4 s. Their signals go stale
after three periods. NaN is the one channel of failure: the shipped rule Blind trips on it, and the plan goes on when
the sonars are back.

Output:

     2.00 s  sonar failed: sensor 'sonar' does not answer.
     2.25 s  avoid_collision/Blind fired min(around, goal_distance) = invalid
     2.25 s  the wheels are told to stand
     4.00 s  avoid_collision/Blind ended
     4.00 s  the wheels are told to drive
    exp1, seed 1, 15.3 s simulated
    R2 success; 3.54 m, 0 collisions, 5 reflexes, 3 re-plans
      fault at 2.00 s: sensor sonar: sensor 'sonar' does not answer.
"""

import rocs_bt
from rocs_bt.event import ActuatorCommanded, Event, RuleChanged, SensorFailed
from rocs_bt.simulation import SimulatedWorld
from rocs_bt.testing.faults import DeadSensor, break_sensor


def prepare(stage: SimulatedWorld) -> None:
    """Break R2's sonars."""
    break_sensor(stage, "sonar", DeadSensor, agent="R2", at=2.0, until=4.0)


class Teller:
    """Tells what fails, what that trips, and what the wheels are told."""

    def __init__(self) -> None:
        self.standing = False

    def emit(self, event: Event) -> None:
        """Tell it."""
        if isinstance(event, SensorFailed):
            print(f"{event.t:5.2f} s  {event.sensor} failed: {event.detail}")
        elif isinstance(event, RuleChanged) and event.rule.endswith("Blind") and event.phase in ("fired", "ended"):
            print(f"{event.t:5.2f} s  {event.rule} {event.phase} {event.reading}".rstrip())
        elif isinstance(event, ActuatorCommanded):
            was, self.standing = self.standing, not any(event.values)
            if self.standing != was and 2.0 < event.t < 4.5:
                print(f"{event.t:5.2f} s  the wheels are told to {'stand' if self.standing else 'drive'}")


print(rocs_bt.run("exp1", prepare=prepare, sinks=[Teller()]))
