"""The robot drives through rooms to a goal that is moved to other rooms during the run."""

from itertools import pairwise

from rocs_bt import Count, PositiveMetresPerSecond
from rocs_bt.compare import Scene, TaskFamily, length_of, position, quantity


class MovedGoals(TaskFamily):
    """The robot drives through rooms to a goal that is moved to other rooms during the run.

    The agent receives each new position before a robot at the speed `fastest` can reach the previous one. The reference
    path leads from the start to the last position of the goal.

    Difficulty: `length` of the reference path [m]; number of `moves`; `astray`: length of a path over all positions of
    the goal, divided by that of the reference path; time of the `last` move [s].
    """

    moves: Count = 2
    fastest: PositiveMetresPerSecond = 2.0

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for rng, building, (start, *goals) in self.sample_until_fit(index, rooms=self.moves + 2):
            away = [building.shortest(start, room).length for room in goals]
            # The goal moves before even the fastest robot can reach its position.
            times = [float(rng.uniform(0.3, 0.9)) * length / self.fastest for length in away[:-1]]
            if all(b - a > 0.5 for a, b in pairwise([0.0, *times])):
                break
        path = building.path(building.shortest(start, goals[-1]).rooms)
        facts = building.facts()
        for at, room in zip(times, goals[1:], strict=True):
            facts.append({"node": "goal", "at": quantity(at, "s"), "pose": position(building.middle(room))})
        doc = f"From room {start} to a goal that moves {self.moves} times."
        difficulty = {
            "length": length_of(path),
            "moves": float(self.moves),
            "astray": sum(building.shortest(a, b).length for a, b in pairwise([start, *goals])) / length_of(path),
            "last": max(times, default=0.0),
        }
        goal = building.middle(goals[0])
        scenario = self.task(index, doc, path, ahead=goal, goal=goal) | {"fact": facts}
        return Scene(scenario, building.floor(), difficulty, path)
