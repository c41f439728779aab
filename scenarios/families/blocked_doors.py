"""From room to room while doors shut: the robot is told, or finds out, and must think of another way."""

from dataclasses import dataclass
from math import atan2
from typing import ClassVar

from rocs_bt import Pose2
from rocs_bt.compare import Building, Family, Scene, door_name, goal_scenario, length_of, seconds
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveCount, PositiveMetres, Seconds


@dataclass(frozen=True, kw_only=True)
class BlockedDoors(Family):
    """From room to room while doors shut: the robot is told, or finds out, and must think of another way.

    Each of `doors` is drawn from the way that is shortest while the others are shut; a way remains. With `told` the
    agent hears of each as it shuts, else only its eyes tell. A door waits while a robot is in its way. The reference
    goes by doors that stay open. Difficulty: `length` of that way [m], `detour` over the way that was open at first,
    `doors` that shut, `first` time [s] at which one does.
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner", "told")

    mission: str = "navigate"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1
    doors: Count = 2
    told: Count = 1
    until: Seconds = 8.0

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
            start, goal = rng.permutation(len(building.rooms))[:2].tolist()
            first, shut = building.shortest(start, goal), list[tuple[int, int]]()
            while len(shut) < self.doors and (now := building.shortest(start, goal, shut)) is not None:
                on_way = [(min(a, b), max(a, b)) for a, b in zip(now[0], now[0][1:], strict=False)]
                shut.append(on_way[int(rng.integers(len(on_way)))])
            last = building.shortest(start, goal, shut)
            if first is not None and last is not None and last[1] > 1.2 * first[1]:
                break
        else:
            raise InputError(
                f"a building of {self.rows} x {self.columns} rooms has no way with {self.doors} doors shut."
            )
        times = sorted(rng.uniform(0.5, max(self.until, 0.6), len(shut)).tolist())
        name, doc = self.scene_name(index), f"From room {start} to room {goal} while {len(shut)} doors shut."
        ground = building.ground()
        ground.movers += [building.leaf(door, shut=False) for door in shut]
        way = building.way(last[0])
        ahead = way[1]
        pose = Pose2(*way[0], atan2(ahead[1] - way[0][1], ahead[0] - way[0][0]))
        tables = [("mover", building.closing(door, at)) for door, at in zip(shut, times, strict=True)]
        tables += building.facts()
        if self.told:
            news = zip(shut, times, strict=True)
            tables += [("fact", {"node": door_name(d), "at": seconds(at), "open": False}) for d, at in news]
        parameters = {"goal": "goal", "planner": self.planner} if self.mission == "navigate" else {"goal": "goal"}
        text = goal_scenario(
            self, name, doc, pose, way[-1], tolerance=0.5, duration=120.0, tables=tables, parameters=parameters
        )
        length = length_of(way)
        difficulty = {"length": length, "detour": length / first[1], "doors": float(len(shut)), "first": times[0]}
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length, {"ground": ground})
