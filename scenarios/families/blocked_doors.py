"""Doors close while the robot drives from room to room; it is informed, or senses it, and must find another route."""

from math import inf
from typing import ClassVar

from rocs_bt import Count, Seconds
from rocs_bt.compare import Scene, TaskFamily, length_of, quantity


class BlockedDoors(TaskFamily):
    """Doors close while the robot drives from room to room; it is informed, or senses it, and must find another route.

    Each closing door is sampled from the route that is shortest while the other closing doors are closed; a route
    always remains. The parameter `doors` is their number. With `report_doors` = 1 the agent receives a fact when a
    door closes; with 0 the robot must sense it. A door waits while a robot blocks it. The reference path uses only
    doors that stay open.

    Difficulty: `length` of the reference path [m]; `detour`: length of this path divided by that of the shortest path
    with all doors open; number of `doors` that close; time of the `first` closing [s].
    """

    NOT_SAMPLED: ClassVar[tuple[str, ...]] = (*TaskFamily.NOT_SAMPLED, "report_doors")

    doors: Count = 2
    report_doors: Count = 1
    until: Seconds = 8.0

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for rng, building, (start, goal) in self.sample_until_fit(index, rooms=2):
            closed = building.sample_closed(rng, start, goal, self.doors)
            first, last = building.shortest(start, goal), building.shortest(start, goal, closed)
            if 1.2 * first.length < last.length < inf:
                break
        times = sorted(rng.uniform(0.5, max(self.until, 0.6), len(closed)).tolist())
        closing = list(zip(closed, times, strict=True))
        floor, path = building.floor(), building.path(last.rooms)
        floor.actors += [building.leaf(door, closed=False) for door in closed]
        updates = [
            {"node": building.door_name(d), "at": quantity(at, "s"), "open": False}
            for d, at in closing
            if self.report_doors
        ]
        doc = f"From room {start} to room {goal} while {len(closed)} doors close."
        scenario = self.task(index, doc, path) | {
            "actor": [building.closing(door, at) for door, at in closing],
            "fact": [*building.facts(), *updates],
        }
        length = length_of(path)
        difficulty = {"detour": length / first.length, "doors": float(len(closed)), "first": times[0]}
        return Scene(scenario, floor, {"length": length, **difficulty}, path)
