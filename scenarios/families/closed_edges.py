"""The robot drives from room to room by roads, some of which are closed by order, without an obstacle."""

from math import inf

from rocs_bt import Count, Seconds
from rocs_bt.compare import Building, Scene, TaskFamily, length_of, quantity


class ClosedEdges(TaskFamily):
    """The robot drives from room to room by roads, some of which are closed by order, without an obstacle.

    Sensors cannot detect a closed road: a planner that ignores knowledge drives through it. The requirement `obeys`
    checks that the robot does not. Each closed road is sampled from the route that is shortest while the other closed
    roads are closed. A route always remains; it is the reference path.

    Difficulty: `length` of the reference path [m]; `detour`: length of this path divided by that of the shortest path
    over all roads; number of `closed` roads.
    """

    closed: Count = 2
    at: Seconds = 0.1

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for rng, building, (start, goal) in self.sample_until_fit(index, rooms=2):
            closed = building.sample_closed(rng, start, goal, self.closed)
            first, last = building.shortest(start, goal), building.shortest(start, goal, closed)
            if 1.2 * first.length < last.length < inf:
                break
        facts = building.facts()
        for door in closed:
            roads = [{"to": building.room_name(room), "open": False, "both_ways": True} for room in door]
            facts.append({"node": building.gate_name(door), "at": quantity(self.at, "s"), "connects": roads})
        doc = f"From room {start} to room {goal} with {len(closed)} roads closed by order."
        path = building.path(last.rooms)
        obeys = {"name": "obeys", "require": forbidden(building, closed)}
        scenario = self.task(index, doc, path) | {"fact": facts, "requirement": [obeys]}
        length = length_of(path)
        difficulty = {"length": length, "detour": length / first.length, "closed": float(len(closed))}
        return Scene(scenario, building.floor(), difficulty, path)


def forbidden(building: Building, closed: list[tuple[int, int]]) -> str:
    """Expression of the requirement that the robot's centre is never in the doorway of a closed road."""
    spots = [building.doorway(door) for door in closed]
    near = f"{building.opening / 2.0:g} m"
    inside = [f"(abs(true_pose[0] - {x:g} m) < {near} and abs(true_pose[1] - {y:g} m) < {near})" for x, y in spots]
    return f"always not ({' or '.join(inside)})"
