"""The battery runs low on the way through a building; the robot must reach the charger in time, then the goal."""

from typing import Annotated

from rocs_bt import PositiveMetresPerSecond
from rocs_bt.base.units import POSITIVE
from rocs_bt.compare import Scene, TaskFamily, length_of, position, quantity


class LowBattery(TaskFamily):
    """The battery runs low on the way through a building; the robot must reach the charger in time, then the goal.

    At a random time the agent receives the urgent task to reach the charger, with the remaining battery time as
    deadline. The charge itself is not simulated. The remaining time is `spare` times the travel time to the charger at
    the speed `pace`, from the farthest point that the robot can have reached. Success requires the charger in time, and
    then the goal. The reference path leads from the start over the charger to the goal.

    Difficulty: `length` of the reference path [m]; `detour`: length of this path divided by that of the shortest path
    from start to goal; `report`: time at which the agent receives the task [s]; `remaining`: battery time then [s].
    """

    mission: str = "errands"
    pace: PositiveMetresPerSecond = 1.0
    spare: Annotated[float, POSITIVE] = 1.5

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for rng, building, (start, charger, goal) in self.sample_until_fit(index, rooms=3):
            there, on = building.shortest(start, charger), building.shortest(charger, goal)
            direct = building.shortest(start, goal)
            reported = round(float(rng.uniform(0.3, 0.9)) * direct.length / 2.0, 2)
            # The report comes before even a robot of 2 m/s can reach the goal.
            if direct.length > 2.0 * self.side - 0.1:
                break
        remaining = self.spare * (there.length + 2.0 * reported) / self.pace
        by = quantity(reported + remaining, "s")
        path = building.path(there.rooms) + building.path(on.rooms)[1:]
        task = {"node": "charge", "kind": "task", "at": quantity(reported, "s"), "priority": 9, "serves": ["charger"]}
        place = {"name": "charger", **position(building.middle(charger)), "tolerance": "0.5 m"}
        doc = "From room to room, over the charger once the battery runs low."
        success = {"goal": "goal", "after": {"charger": by}}
        scenario = self.task(index, doc, path, ahead=path[-1], agent={"success": success}) | {"duration": "180 s"}
        scenario["place"].append(place)
        scenario["fact"] = [*building.facts(), {**task, "deadline": by}]
        length = length_of(path)
        difficulty = {"length": length, "detour": length / direct.length, "report": reported, "remaining": remaining}
        return Scene(scenario, building.floor(), difficulty, path)
