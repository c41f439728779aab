# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Fill every extension point of the architecture (paper, 5.3) with a class of your own.

A robot shuttles along a corridor, in a flat world without physics. It drives until its Analyze block reports a
near wall, then turns round; it rests when its battery is low. Its reflex backs off from an obstacle that is too close
to wait for the plan, here a closing door. Only Pipeline, Execute and Knowledge are shipped classes.

    mandatory      Sensor, Actuator, Action
    deliberative   Monitor, Analyze, Plan
    reactive       ReactiveModel
    optional       WorldModel, RobotModel, StrategyModel

Output:

     0.00 s    Creep RUNNING by shuttle
     3.80 s  walls: wall near, gap = 0.59 m
     3.80 s    Creep CANCELLED by shuttle
     3.80 s    TurnBack RUNNING by shuttle
    10.00 s  keep_off/TooClose fired gap = 0.25 m
    10.00 s    TurnBack CANCELLED by keep_off/TooClose
    10.00 s  walls: wall near, gap = 0.25 m
    10.00 s    BackOff RUNNING by keep_off/TooClose
    10.70 s    BackOff CANCELLED by keep_off/TooClose
    10.70 s  keep_off/TooClose ended
    10.70 s    TurnBack RUNNING by shuttle
    14.40 s    TurnBack CANCELLED by shuttle
    14.45 s  SUCCESS at x = 0.70 m, strategy 'rest'
    walls met: 2, charge left: 0.55
"""

import math
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

import rocs_bt
from rocs_bt import Metres, MetresPerSecond, Radians
from rocs_bt.agent import AgentRuntime, Controller, RobotDevices
from rocs_bt.base.clock import Rate
from rocs_bt.base.units import LENGTH
from rocs_bt.catalog import load_robot
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from rocs_bt.event import Event, RuleChanged, TicketChanged
from rocs_bt.interfaces.channel import Signals, Stamped
from rocs_bt.knowledge import RobotModel, StrategyModel, WorldModel
from rocs_bt.reactive import Reflex

PERIOD = 0.05  # [s]

ROBOT = f"""
format = "robot/3"
doc = "A shuttle with an echo sounder and a battery."
[locomotion]
kind = "differential"
wheel_separation = "0.3 m"
max_wheel_acceleration = "2 m/s2"
[[sensor]]
name = "echo"
driver = "{Path(__file__).name}:Echo"
signal = "gap"
monitor = "senses"
[[sensor]]
name = "battery"
driver = "{Path(__file__).name}:Battery"
signal = "charge"
monitor = "senses"
[[monitor]]
name = "senses"
class = "{Path(__file__).name}:Senses"
[[analyze]]
name = "walls"
class = "{Path(__file__).name}:Walls"
monitors = ["senses"]
near = "0.6 m"
[[actuator]]
name = "wheels"
driver = "{Path(__file__).name}:Wheels"
range = ["-1 m/s", "1 m/s"]
"""


# Mandatory: sensors, actuators and actions.


class Echo(rocs_bt.Sensor):
    """Range to the nearest obstacle ahead [m]."""

    def __init__(self, robot: FlatRobot) -> None:
        super().__init__("echo")
        self.robot = robot

    def read(self) -> rocs_bt.Reading:
        """Return the range along one ray, straight ahead."""
        return rocs_bt.Reading(self.robot.world.clock.now(), [self.robot.world.ray(*self.robot.pose)])


class Battery(rocs_bt.Sensor):
    """Battery voltage, which falls with time [V]."""

    def __init__(self, clock: rocs_bt.Clock) -> None:
        super().__init__("battery")
        self.clock = clock

    def read(self) -> rocs_bt.Reading:
        """Return the voltage, 12.6 V when full."""
        return rocs_bt.Reading(self.clock.now(), [12.6 - 0.05 * self.clock.now()])


class Wheels(rocs_bt.Actuator):
    """The shuttle's two motors."""

    def __init__(self, robot: FlatRobot) -> None:
        super().__init__("wheels", 2)
        self.robot = robot

    def command(self, values: Sequence[float]) -> None:
        """Set the wheel linear speeds, left and right [m/s]."""
        self.robot.motion = list(values)

    def neutral(self) -> None:
        """Stop."""
        self.robot.motion = [0.0, 0.0]


class Creep(rocs_bt.AtomicAction):
    """Drive ahead, slower at small gaps, until the action is cancelled."""

    speed: MetresPerSecond = 0.4

    def act(self, body):
        """Command the body for one control period."""
        gap = body.knowledge.signals.value("gap", body.clock.now())
        if math.isnan(gap):
            return rocs_bt.Failure(rocs_bt.Reason.LOST_SENSOR, "the gap is not known")
        ahead = rocs_bt.Twist2(self.speed * min(1.0, gap))
        body.move(ahead)
        return rocs_bt.Progress.RUNNING


class Spin(rocs_bt.AtomicAction):
    """Turn on the spot by an angle, open loop."""

    angle: Radians = math.pi
    left: float = math.nan

    def act(self, body):
        """Command the body for one control period."""
        self.left = self.angle if math.isnan(self.left) else self.left
        turn = math.copysign(min(abs(self.left), 2.0 * body.period), self.left)
        body.move(rocs_bt.Twist2(0.0, turn=turn / body.period))
        self.left -= turn
        return rocs_bt.Progress.RUNNING if self.left else rocs_bt.Progress.SUCCEEDED


class TurnBack(rocs_bt.MacroAction):
    """Turn round, and creep back."""

    def decompose(self, body):
        """Yield the two actions in order."""
        yield Spin(angle=math.pi)
        yield Creep()


class BackOff(rocs_bt.AtomicAction):
    """Drive backward until the rule is released."""

    def act(self, body):
        """Command the body for one control period."""
        body.move(rocs_bt.Twist2(-0.3))
        return rocs_bt.Progress.RUNNING


# Deliberative: monitor, analyser and plan.


class Senses(rocs_bt.Monitor):
    """Converts the echo to a gap, and the voltage to a charge."""

    def signals(self) -> Sequence[rocs_bt.Signal]:
        """Return the declarations of the signals that this monitor writes."""
        return [
            rocs_bt.Signal("gap", 1, (LENGTH,), (0.0, math.inf), self.max_age),
            rocs_bt.Signal("charge", 1, bounds=(0.0, 1.0), max_age=self.max_age),
        ]

    def interpret(self, readings: Mapping[str, rocs_bt.Reading]) -> Signals:
        """Compute the gap [m] and the charge (0 to 1) from the readings; the battery is empty at 11 V."""
        volts = readings["battery"].values[0]
        return {"gap": readings["echo"].values, "charge": [(volts - 11.0) / 1.6]}


class Walls(rocs_bt.Analyze):
    """Detects near walls."""

    near: Metres
    close = False

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[rocs_bt.Change]:
        """Report a Change when a wall becomes near."""
        gap = samples[-1].value["gap"][0]
        was, self.close = self.close, gap < self.near
        if self.close and not was:
            self.knowledge.world.saw_wall()
            yield self.change(samples[-1].t, "wall near", gap=gap)


class Shuttle(rocs_bt.Plan):
    """Plan that shuttles until the strategy is 'rest'."""

    ticket = None

    def run(self, t: float) -> None:
        """Turn at walls, continue after a reflex, and end with the strategy 'rest'."""
        walls = [c for c in self.changes() if c.value.kind == "wall near"]
        strategy = self.knowledge.strategy.choose()
        if strategy == "rest":
            self.pipeline.clear(by=self.name)
            self.status = "SUCCESS"
        elif self.pipeline.held:
            pass  # a reflex is active; the plan runs again when it ends
        elif self.ticket is None:
            self.ticket = self.submit("Creep", speed=0.4)
        elif walls or self.ticket.state.done:
            self.pipeline.cancel(self.ticket, by=self.name)
            self.ticket = self.submit("TurnBack")


# Reactive: reflexes that cannot wait for a plan.


class KeepOff(rocs_bt.ReactiveModel):
    """Backs off from an obstacle that is too close."""

    def __init__(self, knowledge: rocs_bt.Knowledge) -> None:
        self.gap = knowledge.signals.slice_of("gap").start
        self.latched = False

    def react(self, x: np.ndarray, t: float) -> Sequence[Reflex]:
        """Request BackOff when the gap is below 0.30 m, until it is above 0.45 m (hysteresis)."""
        gap = x[self.gap]
        self.latched = gap < (0.45 if self.latched else 0.30)
        reading = f"gap = {gap:.2f} m"
        return [Reflex("keep_off/TooClose", 50, "BackOff", level=True, latched=self.latched, reading=reading)]


# Optional: the three models, which are views of the same Knowledge.


class Corridor(WorldModel):
    """World model that counts walls."""

    walls = 0

    def saw_wall(self) -> None:
        """Count a wall and add it to the graph."""
        self.walls += 1
        self.graph.add(f"wall {self.walls}", "object")


class Charged(RobotModel):
    """Robot model with a battery."""

    @property
    def charge(self) -> float:
        """Charge from 0 to 1; NaN while unknown."""
        return self.signals.value("charge", self.knowledge.clock.now())


class Duty(StrategyModel):
    """Strategy model: shuttle while there is charge, then rest."""

    def choose(self) -> str:
        """Set the strategy in use from the charge, and return it."""
        if not self.names():
            self.add("rest")
            self.add("shuttle", falls_back_to="rest")
        self.use("shuttle" if self.knowledge.robot.charge > 0.55 else "rest")
        return self.used()


class Printer:
    """Event sink that prints changes, reflexes and actions."""

    def emit(self, event: Event) -> None:
        """Print an event."""
        if isinstance(event, rocs_bt.Change):
            print(f"{event.t:5.2f} s  {event.source}: {event.kind}, gap = {event.values['gap']:.2f} m")
        elif isinstance(event, RuleChanged) and event.phase in ("fired", "ended"):
            print(f"{event.t:5.2f} s  {event.rule} {event.phase} {event.reading}".rstrip())
        elif isinstance(event, TicketChanged) and event.state in ("RUNNING", "CANCELLED"):
            print(f"{event.t:5.2f} s    {event.action} {event.state} by {event.by}")


def make_agent(clock: rocs_bt.SimulatedClock, world: FlatWorld) -> tuple[rocs_bt.Agent, FlatRobot]:
    """Build the shuttle's agent and its simulated body."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.toml"
        file.write_text(ROBOT)
        file.with_name(Path(__file__).name).write_bytes(Path(__file__).read_bytes())
        spec = load_robot(file)
    body = FlatRobot(world, spec.locomotion, rocs_bt.Pose2(0.0, 0.0, 0.0))
    gate = spec.actuators[0].guard(Wheels(body), clock, PERIOD)
    body.gates.append(gate)
    controller = Controller(
        build=lambda mission: Shuttle("shuttle", **mission.parts),
        reflexes=lambda knowledge: [KeepOff(knowledge)],
        actions=[Creep, Spin, TurnBack, BackOff],
        world_model=Corridor,
        robot_model=Charged,
        strategy_model=Duty,
    )
    every_period = Rate(1, PERIOD)
    devices = RobotDevices(
        spec,
        sensors={"echo": Echo(body), "battery": Battery(clock)},
        actuators={"wheels": gate},
        sensor_rates={"echo": every_period, "battery": every_period},
    )
    agent = rocs_bt.build_agent(
        "R1",
        devices,
        controller,
        rocs_bt.Rates(control=every_period, plan=Rate(2, PERIOD)),
        AgentRuntime(clock, Printer()),
        load_class=lambda file, name: globals()[name],  # the classes are in this file
    )
    return agent, body


def main() -> None:
    """Run the agent until its mission has ended."""
    clock = rocs_bt.SimulatedClock(PERIOD)
    world = FlatWorld(clock, segments=[((2.0, -1.0), (2.0, 1.0)), ((-1.0, -1.0), (-1.0, 1.0))])
    agent, body = make_agent(clock, world)
    while agent.status == "RUNNING":
        if clock.count == 200:  # a door closes in front of the robot
            x = body.pose.transform(0.25, 0.0)[0]
            world.segments.append(((x, -1.0), (x, 1.0)))
        agent.step(clock.count)
        world.advance(PERIOD)
        clock.advance()
    agent.stop()
    knowledge = agent.knowledge
    print(f"{clock.now():5.2f} s  {agent.status} at x = {body.pose.x:.2f} m, strategy '{knowledge.strategy.used()}'")
    print(f"walls met: {knowledge.world.walls}, charge left: {knowledge.robot.charge:.2f}")


if __name__ == "__main__":
    main()
