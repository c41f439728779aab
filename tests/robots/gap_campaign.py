"""`navigate` through gaps 0.25 m wider than the hull: `python tests/robots/gap_campaign.py jackal --scenes 20`.

A wall with one gap is between start and goal; where the gap is, how thick the wall is and where the robot starts is
sampled. An arena of 5 x 4 m surrounds all of it.
"""

from __future__ import annotations

import argparse
import sys
from functools import cache
from math import atan2

from rocs_bt import Pose2
from rocs_bt.catalog import PlannerSpec
from rocs_bt.compare import Block, Family, Floor, Scene, goal_scenario, walls_around
from rocs_bt.compare.episode import Episode, GeneratedScene
from rocs_bt.compare.record import EpisodeRecord
from rocs_bt.compare.runner import EpisodeRunner

ROOM = 0.25  # [m] by which a gap is wider than the hull
SIZE = (2.5, 2.0)  # [m] half of the arena


class Gaps(Family):
    """A wall with one gap between start and goal."""

    width: float = 0.7  # [m] of the gap

    def scene(self, index: int) -> Scene:
        rng = self.rng(index)
        (wide, high), thick = SIZE, float(rng.choice([0.02, 0.1, 0.3]))
        middle = float(rng.uniform(-0.5, 0.5) * high)
        start = Pose2(float(rng.uniform(-1.8, -1.0)), float(rng.uniform(-1.0, 1.0)))
        goal = (float(rng.uniform(1.0, 1.8)), float(rng.uniform(-1.0, 1.0)))
        heading = atan2(goal[1] - start.y, goal[0] - start.x) + float(rng.uniform(-0.5, 0.5))
        low, top = middle - 0.5 * self.width, middle + 0.5 * self.width
        ends = ((-high, low), (top, high))
        wall = [Block(f"wall{i}", 0.0, 0.5 * (a + b), thick, b - a) for i, (a, b) in enumerate(ends)]
        floor = Floor((-wide, -high), (wide, high), [*walls_around((-wide, -high), (wide, high)), *wall])
        start = Pose2(start.x, start.y, heading)
        scenario = goal_scenario(self, self.scene_name(index), self.doc, start, goal, tolerance=0.1, duration=60.0)
        return Scene(scenario, floor)


@cache
def runner() -> EpisodeRunner:
    return EpisodeRunner()


def through_a_gap(robot: str, index: int) -> EpisodeRecord:
    """Play one scene with a robot."""
    width = runner().catalog.load_robot(robot).body.width + ROOM
    gaps = Gaps(robot=robot, width=width)
    planner = PlannerSpec(name="navigate", mission="navigate", rules=("contact",), parameters={"goal": "goal"})
    scene = GeneratedScene.of(gaps.scene(index))
    return runner().play(Episode(f"{robot}-{index}", planner, scene, index + 1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="+")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--from", dest="first", type=int, default=0)
    given = parser.parse_args()
    for robot in given.robots:
        found = [through_a_gap(robot, index) for index in range(given.first, given.first + given.scenes)]
        good = sum(record.outcome == "success" for record in found)
        sys.stdout.write(f"{robot}: {good} of {len(found)}\n")
        for record in found:
            if record.outcome != "success":
                sys.stdout.write(f"  {record.scene} seed {record.seed}: {record.outcome}, {record.reason}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
