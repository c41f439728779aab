"""From room to room to a goal that moves to another room meanwhile: whoever keeps an old plan arrives in vain."""

from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from typing import ClassVar

from rocs_bt import Pose2
from rocs_bt.compare import Building, Family, Scene, goal_scenario, length_of, metres, seconds
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveCount, PositiveMetres, PositiveMetresPerSecond


@dataclass(frozen=True, kw_only=True)
class MovedGoals(Family):
    """From room to room to a goal that moves to another room meanwhile: whoever keeps an old plan arrives in vain.

    The agent is told each time, before a robot of the `fastest` speed can be there. The reference leads
    from the start to the last place of the goal, as if it had been known. Difficulty: `length` of that way [m], `moves`
    of the goal, `astray`, the way to all its places over that one, `last` time [s] at which it moves.
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner")

    mission: str = "navigate"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1
    moves: Count = 2
    fastest: PositiveMetresPerSecond = 2.0

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
            start, *goals = rng.permutation(len(building.rooms))[: self.moves + 2].tolist()
            away = [found[1] for room in goals if (found := building.shortest(start, room)) is not None]
            # Not even the fastest robot is where the goal is before it moves on.
            times = [float(rng.uniform(0.3, 0.9)) * length / self.fastest for length in away[:-1]]
            if len(goals) == self.moves + 1 and all(b - a > 0.5 for a, b in pairwise([0.0, *times])):
                break
        else:
            raise InputError(f"{self.rows} x {self.columns} rooms are too few for {self.moves} moves.")
        legs = [building.shortest(a, b) for a, b in pairwise([start, *goals])]
        direct = building.shortest(start, goals[-1])
        if direct is None:
            raise InputError("a building without doors has no ways.")
        name, doc = self.scene_name(index), f"From room {start} to a goal that moves {self.moves} times."
        ground, way = building.ground(), building.way(direct[0])
        first = building.middle(goals[0])
        pose = Pose2(*way[0], atan2(first[1] - way[0][1], first[0] - way[0][0]))
        tables = [*building.facts()]
        for at, room in zip(times, goals[1:], strict=True):
            x, y = building.middle(room)
            told = {"node": "goal", "at": seconds(at), "pose": {"x": metres(x), "y": metres(y)}}
            tables.append(("fact", told))
        parameters = {"goal": "goal", "planner": self.planner} if self.mission == "navigate" else {"goal": "goal"}
        text = goal_scenario(
            self, name, doc, pose, first, tolerance=0.5, duration=120.0, tables=tables, parameters=parameters
        )
        length = length_of(way)
        difficulty = {
            "length": length,
            "moves": float(self.moves),
            "astray": sum(leg[1] for leg in legs if leg is not None) / length,
            "last": max(times, default=0.0),
        }
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length, {"ground": ground})
