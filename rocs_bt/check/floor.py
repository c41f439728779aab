"""Check of the floor of a scenario: a robot is identified for the friction of one floor only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..base.errors import Fault
from ..catalog import AgentSpec, Catalog, ScenarioSpec
from ..declare import place_of
from ..drivers.mujoco import MujocoWorld, compose_world
from ..drivers.mujoco.body import FLOOR, geom_labels
from ..simulation.identified_file import identified_path
from ..simulation.identify import WORLD
from .identified import TOLERANCE

_SETTLED = 40  # [physics steps] until a robot that was placed rests on the floor


def floor_faults(scenario: ScenarioSpec, agent: AgentSpec, world: MujocoWorld, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a floor on which an agent's robot has another friction than where its motion was measured.

    The robot is placed at its start, and settles on the floor.
    """
    robot = catalog.robot_of(agent)
    if identified_path(robot) is None or robot.locomotion.kind == "flying":
        return
    world.place(agent.name, agent.pose)
    world.advance(_SETTLED)
    model, labels = world.model, geom_labels(world.model, world.robots)
    for contact in world.data.contact:
        own = contact.geom1 if labels[contact.geom1] == agent.name else contact.geom2
        if {labels[contact.geom1], labels[contact.geom2]} != {FLOOR, agent.name} or contact.dim == 1:
            continue
        found, measured = float(contact.friction[0]), _measured_friction(model, own, catalog)
        if abs(found - measured) > TOLERANCE * measured:
            message = (
                f"'{robot.name}' is not identified on this floor: its friction is {found:.3g}, not {measured:.3g} as "
                "where the motion was measured. It may stop late and cut corners."
            )
            hint = (
                f"Give the floor of '{scenario.world}' the friction of that of '{WORLD}', or identify the robot on it."
            )
            yield Fault(message, scenario.file, place_of(agent).line, hint=hint, warning=True)
            return


def _measured_friction(model: Any, geom: int, catalog: Catalog) -> float:
    """Sliding friction of a robot's geom on the floor of the world in which robots are identified."""
    plane = compose_world(catalog.find("world", WORLD).path, [], within=catalog.roots).model
    floor = geom_labels(plane, {}).index(FLOOR)
    sides = [(int(m.geom_priority[g]), float(m.geom_friction[g][0])) for m, g in ((model, geom), (plane, floor))]
    first = max(priority for priority, _ in sides)
    return max(friction for priority, friction in sides if priority == first)
