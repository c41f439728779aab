"""Whether a scenario and a robot fit each other: what neither file can tell alone."""

from __future__ import annotations

from collections.abc import Iterator

from ..errors import Fault
from .robot_spec import RobotSpec
from .scenario_file import ScenarioSpec


def misfits(scenario: ScenarioSpec, name: str, robot: RobotSpec) -> Iterator[Fault]:
    """What keeps a robot from being an agent of a scenario, each fault in the file that has to change.

    An agent, its devices and the places that it is told of are nodes of one graph, so they cannot share a name; and
    its actuators must wait for a command as long as the scenario's control period is.

    Args:
        scenario: The scenario.
        name: What it calls the robot.
        robot: The robot.
    """
    agents = [agent for agent in scenario.agents if agent.robot == name]
    devices = {d.name: kind for kind, of in (("sensor", robot.sensors), ("actuator", robot.actuators)) for d in of}
    named = [(agent.name, agent.line) for agent in agents]
    told = {agent.name for agent in agents}
    named += [(place.name, place.line) for place in scenario.places if told.intersection(place.agents)]
    for taken, line in named:
        if taken in devices:
            message = f"the name '{taken}' is taken by the {devices[taken]} '{taken}' of {robot.name}."
            yield Fault(message, scenario.file, line, hint="Choose another name.")
    period = scenario.rate.control_rate.period
    for actuator in robot.actuators if agents else ():
        if actuator.max_command_age < period - 1e-9:
            yield Fault(
                f"the actuator '{actuator.name}' goes to neutral {actuator.max_command_age:g} s after a command, but "
                f"{scenario.name} commands it only every {period:g} s.",
                robot.file,
                actuator.line,
                hint=f'Write max_command_age = "{4.0 * period:g} s", or a faster control rate.',
            )
