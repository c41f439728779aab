"""Errands in a building, and an urgent one that turns up on the way and must be done first, in time."""

from dataclasses import dataclass
from itertools import pairwise, permutations

from rocs_bt.compare import Building, Scene, TaskFamily, length_of, position, quantity
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveMetresPerSecond


@dataclass(frozen=True, kw_only=True)
class Priorities(TaskFamily):
    """Errands in a building, and an urgent one that turns up on the way and must be done first, in time.

    The agent knows `errands` of equal priority; later it is told of an urgent one, whose time is what the way from the
    start takes at the speed `pace`, twice. Then it drives home. Success needs all of them, the urgent one in time. The
    reference is the shortest tour, as if all had been known. Difficulty: `length` of that tour [m], `errands` in all,
    `told` at [s], `slack`, the time that is left over the least that it takes at 2 m/s.
    """

    mission: str = "errands"
    errands: Count = 2
    pace: PositiveMetresPerSecond = 1.0

    def scene(self, index: int) -> Scene:
        """The building of an index."""
        if not 1 <= self.errands <= 5:
            raise InputError(f"there are 1 to 5 errands, found {self.errands}.")
        rng = self.rng(index)
        building, (start, home, urgent, *spots) = self.sample(rng, self.errands + 3)
        order = best_tour(building, start, [urgent, *spots], home)
        path = [point for a, b in pairwise(order) for point in building.path(building.shortest(a, b).rooms)]
        told = round(float(rng.uniform(1.0, 4.0)), 2)
        least = building.shortest(start, urgent).length
        deadline = told + 2.0 * (least + 2.0 * told) / self.pace + 2.0
        facts, places = building.facts(), list[dict[str, object]]()
        for i, room in enumerate(spots):
            places.append({"name": f"spot_{i}", **position(building.middle(room)), "tolerance": "0.5 m"})
            facts.append({"node": f"task_{i}", "kind": "task", "priority": 1, "serves": [f"spot_{i}"]})
        at, pose, by = {"at": quantity(told, "s")}, position(building.middle(urgent)), quantity(deadline, "s")
        # Where it is stands in the scenario for the judge; the agent hears of it later.
        places.append({"name": "urgent", **pose, "tolerance": "0.5 m", "agents": []})
        facts.append({"node": "urgent", "kind": "goal", **at, "pose": pose, "tolerance": "0.5 m"})
        task = {"node": "task_urgent", "kind": "task", **at, "priority": 5, "deadline": by}
        facts.append({**task, "serves": ["urgent"]})
        after = {"urgent": by} | {f"spot_{i}": "inf s" for i in range(len(spots))}
        slack = (deadline - told) / (least / 2.0)
        doc = f"{self.errands} errands, and an urgent one that turns up, then home."
        success = {"goal": "goal", "after": after}
        scenario = self.task(index, doc, path, ahead=building.middle(spots[0]), agent={"success": success})
        scenario |= {"duration": "180 s", "place": [*scenario["place"], *places], "fact": facts}
        difficulty = {"length": length_of(path), "errands": float(self.errands + 1), "told": told, "slack": slack}
        return Scene(scenario, building.ground(), difficulty, path)


def best_tour(building: Building, start: int, rooms: list[int], home: int) -> tuple[int, ...]:
    """The order of the shortest tour from the start through all rooms home."""

    def length(tour: tuple[int, ...]) -> float:
        return round(sum(building.shortest(a, b).length for a, b in pairwise(tour)), 9)  # of equal ones the first

    return min(((start, *order, home) for order in permutations(rooms)), key=length)
