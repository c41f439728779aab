"""On the way through a building the battery runs low: first to the charger, while it lasts, and then to the goal."""

from dataclasses import dataclass
from typing import Annotated

from rocs_bt.compare import Scene, TaskFamily, length_of, position, quantity
from rocs_bt.units import POSITIVE, PositiveMetresPerSecond


@dataclass(frozen=True, kw_only=True)
class LowBattery(TaskFamily):
    """On the way through a building the battery runs low: first to the charger, while it lasts, and then to the goal.

    The power electronics say at some time for how long the battery lasts, and the agent learns it as an urgent task;
    the charge itself is not simulated. It lasts `spare` times what the way to the charger takes at the speed `pace`,
    from wherever the robot can be by then. Success is at the goal, after the charger was reached in time. The reference
    goes from the start over the charger. Difficulty: `length` of that way [m], `detour` over the way without it, `told`
    at [s], `lasts` [s].
    """

    mission: str = "errands"
    pace: PositiveMetresPerSecond = 1.0
    spare: Annotated[float, POSITIVE] = 1.5

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        for rng, building, (start, charger, goal) in self.sample_until_fit(index, rooms=3):
            there, on = building.shortest(start, charger), building.shortest(charger, goal)
            direct = building.shortest(start, goal)
            told = round(float(rng.uniform(0.3, 0.9)) * direct.length / 2.0, 2)
            # The warning comes before even a robot of 2 m/s can be at the goal.
            if direct.length > 2.0 * self.side - 0.1:
                break
        lasts = self.spare * (there.length + 2.0 * told) / self.pace
        by = quantity(told + lasts, "s")
        path = building.path(there.rooms) + building.path(on.rooms)[1:]
        task = {"node": "charge", "kind": "task", "at": quantity(told, "s"), "priority": 9, "serves": ["charger"]}
        place = {"name": "charger", **position(building.middle(charger)), "tolerance": "0.5 m"}
        doc = "From room to room, over the charger once the battery runs low."
        success = {"goal": "goal", "after": {"charger": by}}
        scenario = self.task(index, doc, path, ahead=path[-1], agent={"success": success}) | {"duration": "180 s"}
        scenario["place"].append(place)
        scenario["fact"] = [*building.facts(), {**task, "deadline": by}]
        length = length_of(path)
        difficulty = {"length": length, "detour": length / direct.length, "told": told, "lasts": lasts}
        return Scene(scenario, building.ground(), difficulty, path)
