"""Errands in a building, and an urgent one that turns up on the way and must be done first, in time."""

from dataclasses import dataclass
from itertools import pairwise, permutations
from math import atan2, inf
from typing import ClassVar

from rocs_bt import Pose2
from rocs_bt.compare import Building, Family, Scene, goal_scenario, length_of, metres, seconds
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveCount, PositiveMetres, PositiveMetresPerSecond


@dataclass(frozen=True, kw_only=True)
class Priorities(Family):
    """Errands in a building, and an urgent one that turns up on the way and must be done first, in time.

    The agent knows `errands` of equal priority; later it is told of an urgent one, whose time is what the way from the
    start takes at the speed `pace`, twice. Then it drives home. Success needs all of them, the urgent one in time. The
    reference is the shortest tour, as if all had been known. Difficulty: `length` of that tour [m], `errands` in all,
    `told` at [s], `slack`, the time that is left over the least that it takes at 2 m/s.
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner")

    mission: str = "errands"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1
    errands: Count = 2
    pace: PositiveMetresPerSecond = 1.0

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        rng = self.rng(index)
        building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
        if not 1 <= self.errands <= 5 or len(building.rooms) < self.errands + 3:
            raise InputError(f"{self.rows} x {self.columns} rooms are too few for {self.errands} errands, of 1 to 5.")
        start, home, urgent, *spots = rng.permutation(len(building.rooms))[: self.errands + 3].tolist()
        order = best_tour(building, start, [urgent, *spots], home)
        way = [point for a, b in pairwise(order) for point in building.way(leg(building, a, b)[0])]
        told = round(float(rng.uniform(1.0, 4.0)), 2)
        least = leg(building, start, urgent)[1]
        deadline = told + 2.0 * (least + 2.0 * told) / self.pace + 2.0
        tables = [*building.facts()]
        places: list[dict[str, object]] = []
        for i, room in enumerate(spots):
            x, y = building.middle(room)
            places.append({"name": f"spot_{i}", "x": metres(x), "y": metres(y), "tolerance": "0.5 m"})
            tables.append(("fact", {"node": f"task_{i}", "kind": "task", "priority": 1, "serves": [f"spot_{i}"]}))
        x, y = building.middle(urgent)
        at = {"at": seconds(told)}
        # Where it is stands in the scenario for the judge; the agent hears of it later.
        places.append({"name": "urgent", "x": metres(x), "y": metres(y), "tolerance": "0.5 m", "agents": []})
        pose = {"x": metres(x), "y": metres(y)}
        tables.append(("fact", {"node": "urgent", "kind": "goal", **at, "pose": pose, "tolerance": "0.5 m"}))
        news = {"node": "task_urgent", "kind": "task", **at, "priority": 5, "deadline": seconds(deadline)}
        tables.append(("fact", {**news, "serves": ["urgent"]}))
        name, doc = self.scene_name(index), f"{self.errands} errands, and an urgent one that turns up, then home."
        after = {"urgent": seconds(deadline)} | {f"spot_{i}": "inf s" for i in range(len(spots))}
        first = building.middle(spots[0])
        begin = building.middle(start)
        text = goal_scenario(
            self,
            name,
            doc,
            Pose2(*begin, atan2(first[1] - begin[1], first[0] - begin[0])),
            building.middle(home),
            tolerance=0.5,
            duration=180.0,
            tables=tables,
            places=places,
            parameters={"goal": "goal", "planner": self.planner} if self.mission == "errands" else {"goal": "goal"},
            success={"goal": "goal", "after": after},
        )
        ground = building.ground()
        difficulty = {
            "length": length_of(way),
            "errands": float(self.errands + 1),
            "told": told,
            "slack": (deadline - told) / (least / 2.0),
        }
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length_of(way), {"ground": ground})


def leg(building: Building, start: int, goal: int) -> tuple[list[int], float]:
    """The rooms of the shortest way between two rooms, and its length [m]."""
    found = building.shortest(start, goal)
    if found is None:
        raise InputError("a building without doors has no ways.")
    return found


def best_tour(building: Building, start: int, rooms: list[int], home: int) -> list[int]:
    """The order of the shortest tour from the start through all rooms home."""
    best, least = [start, *rooms, home], inf
    for order in permutations(rooms):
        tour = [start, *order, home]
        length = sum(leg(building, a, b)[1] for a, b in pairwise(tour))
        if length < least - 1e-9:
            best, least = tour, length
    return best
