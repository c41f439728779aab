"""On the way through a building the battery runs low: first to the charger, while it lasts, and then to the goal."""

from dataclasses import dataclass
from math import atan2
from typing import Annotated, ClassVar

from rocs_bt import Pose2
from rocs_bt.compare import Building, Family, Scene, goal_scenario, length_of, metres, seconds
from rocs_bt.errors import InputError
from rocs_bt.units import POSITIVE, PositiveCount, PositiveMetres, PositiveMetresPerSecond


@dataclass(frozen=True, kw_only=True)
class LowBattery(Family):
    """On the way through a building the battery runs low: first to the charger, while it lasts, and then to the goal.

    The power electronics say at some time for how long the battery lasts, and the agent learns it as an urgent task;
    the charge itself is not simulated. It lasts `spare` times what the way to the charger takes at the speed `pace`,
    from wherever the robot can be by then. Success is at the goal, after the charger was reached in time. The reference
    goes from the start over the charger. Difficulty: `length` of that way [m], `detour` over the way without it, `told`
    at [s], `lasts` [s].
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner")

    mission: str = "errands"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1
    pace: PositiveMetresPerSecond = 1.0
    spare: Annotated[float, POSITIVE] = 1.5

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
            start, charger, goal = rng.permutation(len(building.rooms))[:3].tolist()
            there, on, direct = (building.shortest(a, b) for a, b in ((start, charger), (charger, goal), (start, goal)))
            # The warning comes before even a robot of 2 m/s can be at the goal.
            if there and on and direct and direct[1] > 2.0 * self.side - 0.1:
                break
        else:
            raise InputError(f"{self.rows} x {self.columns} rooms are too few.")
        told = round(float(rng.uniform(0.3, 0.9)) * direct[1] / 2.0, 2)
        lasts = self.spare * (there[1] + 2.0 * told) / self.pace
        way = building.way(there[0]) + building.way(on[0])[1:]
        x, y = building.middle(charger)
        places = [{"name": "charger", "x": metres(x), "y": metres(y), "tolerance": "0.5 m"}]
        task = {"node": "charge", "kind": "task", "at": seconds(told), "priority": 9, "serves": ["charger"]}
        tables = [*building.facts(), ("fact", {**task, "deadline": seconds(told + lasts)})]
        name, doc = self.scene_name(index), "From room to room, over the charger once the battery runs low."
        begin, end = building.middle(start), building.middle(goal)
        text = goal_scenario(
            self,
            name,
            doc,
            Pose2(*begin, atan2(end[1] - begin[1], end[0] - begin[0])),
            end,
            tolerance=0.5,
            duration=180.0,
            tables=tables,
            places=places,
            parameters={"goal": "goal", "planner": self.planner} if self.mission == "errands" else {"goal": "goal"},
            success={"goal": "goal", "after": {"charger": seconds(told + lasts)}},
        )
        ground = building.ground()
        length = length_of(way)
        difficulty = {"length": length, "detour": length / direct[1], "told": told, "lasts": lasts}
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length, {"ground": ground})
