"""From room to room by roads, some of which are closed by order: nothing stands there, and yet one must not pass."""

from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from typing import ClassVar

from rocs_bt import Pose2
from rocs_bt.compare import Building, Family, Scene, gate_name, goal_scenario, length_of, room_name, seconds
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveCount, PositiveMetres, Seconds


@dataclass(frozen=True, kw_only=True)
class ClosedEdges(Family):
    """From room to room by roads, some of which are closed by order: nothing stands there, and yet one must not pass.

    Only knowledge tells: a planner that trusts its eyes drives through. Whether it did is the requirement `obeys`.
    Roads are drawn from the way that is shortest while the others are closed; a way remains, and is the reference.
    Difficulty: `length` of that way [m], `detour` over the way of who does not obey, `closed` roads.
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner")

    mission: str = "navigate"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1
    closed: Count = 2
    at: Seconds = 0.1

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
            start, goal = rng.permutation(len(building.rooms))[:2].tolist()
            first, shut = building.shortest(start, goal), list[tuple[int, int]]()
            while len(shut) < self.closed and (now := building.shortest(start, goal, shut)) is not None:
                on_way = [(min(a, b), max(a, b)) for a, b in pairwise(now[0])]
                shut.append(on_way[int(rng.integers(len(on_way)))])
            last = building.shortest(start, goal, shut)
            if first is not None and last is not None and last[1] > 1.2 * first[1]:
                break
        else:
            raise InputError(f"{self.rows} x {self.columns} rooms leave no way with {self.closed} roads closed.")
        name, doc = self.scene_name(index), f"From room {start} to room {goal} with {len(shut)} roads closed by order."
        ground, way = building.ground(), building.way(last[0])
        pose = Pose2(*way[0], atan2(way[1][1] - way[0][1], way[1][0] - way[0][0]))
        tables = [*building.facts()]
        for door in shut:
            roads = [{"to": room_name(room), "open": False, "both_ways": True} for room in door]
            tables.append(("fact", {"node": gate_name(door), "at": seconds(self.at), "connects": roads}))
        tables.append(("requirement", {"name": "obeys", "require": forbidden(building, shut)}))
        parameters = {"goal": "goal", "planner": self.planner} if self.mission == "navigate" else {"goal": "goal"}
        text = goal_scenario(
            self, name, doc, pose, way[-1], tolerance=0.5, duration=120.0, tables=tables, parameters=parameters
        )
        length = length_of(way)
        difficulty = {"length": length, "detour": length / first[1], "closed": float(len(shut))}
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length, {"ground": ground})


def forbidden(building: Building, shut: list[tuple[int, int]]) -> str:
    """The requirement that the robot's middle is in no doorway of a closed road."""
    spots = [building.doorway(door) for door in shut]
    near = f"{building.opening / 2.0:g} m"
    inside = [f"(abs(true_pose[0] - {x:g} m) < {near} and abs(true_pose[1] - {y:g} m) < {near})" for x, y in spots]
    return f"always not ({' or '.join(inside)})"
