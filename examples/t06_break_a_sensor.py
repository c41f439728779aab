# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Inject a sensor fault during a run: the robot stops until the sensor recovers.

`prepare` receives the simulated world before the agents are built, and can replace any device. rocs_bt.testing.faults
has devices that die, freeze, give wrong values, hang or raise. Here the sonars cannot be read from 2 s to 4 s. After
three periods without a reading, the values of their signals are NaN, which always means a sensor failure. The shipped
rule Blind then stops the robot; the plan continues when the sonars recover.

Output:

     2.00 s  sonar failed: sensor 'sonar' does not answer.
     2.25 s  avoid_collision/Blind fired min(around, goal_distance) = invalid
     2.25 s  wheel command: stop
     4.00 s  avoid_collision/Blind ended
     4.00 s  wheel command: drive
    exp1, seed 1, 15.3 s simulated
    R2 success; 3.54 m, 0 collisions, 5 reflexes, 3 resumed actions
      fault at 2.00 s: sensor sonar failed: sensor 'sonar' does not answer.
"""

import rocs_bt
from rocs_bt.event import ActuatorCommanded, Event, RuleChanged, SensorFailed
from rocs_bt.simulation import SimulatedWorld
from rocs_bt.testing.faults import DeadSensor, break_sensor


def prepare(world: SimulatedWorld) -> None:
    """Break R2's sonars."""
    break_sensor(world, "sonar", DeadSensor, agent="R2", at=2.0, until=4.0)


class Printer:
    """Event sink that prints sensor failures, the rule Blind, and starts and stops of the wheels."""

    def __init__(self) -> None:
        self.stopped = False

    def emit(self, event: Event) -> None:
        """Print an event."""
        if isinstance(event, SensorFailed):
            print(f"{event.t:5.2f} s  {event.sensor} failed: {event.detail}")
        elif isinstance(event, RuleChanged) and event.rule.endswith("Blind") and event.phase in ("fired", "ended"):
            print(f"{event.t:5.2f} s  {event.rule} {event.phase} {event.reading}".rstrip())
        elif isinstance(event, ActuatorCommanded):
            was, self.stopped = self.stopped, not any(event.values)
            if self.stopped != was and 2.0 < event.t < 4.5:
                print(f"{event.t:5.2f} s  wheel command: {'stop' if self.stopped else 'drive'}")


print(rocs_bt.run("exp1", prepare=prepare, sinks=[Printer()]))
