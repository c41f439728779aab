"""The robot runs errands in a building; on the way, an urgent errand with a deadline is added."""

from itertools import pairwise, permutations

from rocs_bt import Count, InputError, PositiveMetresPerSecond
from rocs_bt.compare import Building, Scene, TaskFamily, length_of, position, quantity


class Priorities(TaskFamily):
    """The robot runs errands in a building; on the way, an urgent errand with a deadline is added.

    An errand is a visit to a room. At the start the agent knows several errands of equal priority; the parameter
    `errands` is their number. Later it receives an urgent errand with a deadline after about twice the travel time at
    the speed `pace`. At the end the robot drives home. Success requires all errands, and the urgent one in time. The
    reference path is the shortest tour over all rooms.

    Difficulty: `length` of the reference path [m]; number of `errands`, including the urgent one; `report`: time at
    which the agent receives the urgent errand [s]; `slack`: time until its deadline, divided by the shortest travel
    time from the start at 2 m/s.
    """

    mission: str = "errands"
    errands: Count = 2
    pace: PositiveMetresPerSecond = 1.0

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        if not 1 <= self.errands <= 5:
            raise InputError(f"errands must be 1 to 5, found {self.errands}.")
        rng = self.rng(index)
        building, (start, home, urgent, *spots) = self.sample(rng, self.errands + 3)
        order = best_tour(building, start, [urgent, *spots], home)
        path = [point for a, b in pairwise(order) for point in building.path(building.shortest(a, b).rooms)]
        reported = round(float(rng.uniform(1.0, 4.0)), 2)
        least = building.shortest(start, urgent).length
        deadline = reported + 2.0 * (least + 2.0 * reported) / self.pace + 2.0
        facts, places = building.facts(), list[dict[str, object]]()
        for i, room in enumerate(spots):
            places.append({"name": f"spot_{i}", **position(building.middle(room)), "tolerance": "0.5 m"})
            facts.append({"node": f"task_{i}", "kind": "task", "priority": 1, "serves": [f"spot_{i}"]})
        at, pose, by = {"at": quantity(reported, "s")}, position(building.middle(urgent)), quantity(deadline, "s")
        # The place is for the judge of success only; no agent knows it until it receives the fact.
        places.append({"name": "urgent", **pose, "tolerance": "0.5 m", "agents": []})
        facts.append({"node": "urgent", "kind": "goal", **at, "pose": pose, "tolerance": "0.5 m"})
        task = {"node": "task_urgent", "kind": "task", **at, "priority": 5, "deadline": by}
        facts.append({**task, "serves": ["urgent"]})
        after = {"urgent": by} | {f"spot_{i}": "inf s" for i in range(len(spots))}
        slack = (deadline - reported) / (least / 2.0)
        doc = f"{self.errands} errands, and an urgent one that turns up, then home."
        success = {"goal": "goal", "after": after}
        scenario = self.task(index, doc, path, ahead=building.middle(spots[0]), agent={"success": success})
        scenario |= {"duration": "180 s", "place": [*scenario["place"], *places], "fact": facts}
        difficulty = {"length": length_of(path), "errands": float(self.errands + 1), "report": reported, "slack": slack}
        return Scene(scenario, building.floor(), difficulty, path)


def best_tour(building: Building, start: int, rooms: list[int], home: int) -> tuple[int, ...]:
    """Order of rooms in the shortest tour from the start room through all rooms to the home room."""

    def length(tour: tuple[int, ...]) -> float:
        return round(
            sum(building.shortest(a, b).length for a, b in pairwise(tour)), 9
        )  # rounded so that the first of equal tours is chosen

    return min(((start, *order, home) for order in permutations(rooms)), key=length)
