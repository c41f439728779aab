"""Variations of EXP3: a robot visits four places in turn, another one follows it, and a third wanders."""

from math import atan2, dist, pi
from typing import Any

from rocs_bt import InputError, PositiveMetres, PositiveMetresPerSecond
from rocs_bt.compare import Family, Floor, Scene, length_of, position, quantity, walls_around

NAMES = ("corner_1", "corner_2", "corner_3", "corner_4")


class Exp3Family(Family):
    """Variations of EXP3: a robot visits four places in turn, another one follows it, and a third wanders.

    These are scenes of the paper's third experiment with random places and start positions. Success means that the
    visiting robot R reaches its last place.

    Difficulty: total `length` of the straight legs between R's places [m]; `turning`: sum of the angles between
    successive legs [rad].
    """

    robot: str = "pioneer_p3dx"
    mission: str = "corners"
    follower: str = "summit_xl"
    side: PositiveMetres = 5.0
    speed: PositiveMetresPerSecond = 0.2

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        half = self.side / 2.0
        for attempt in range(1000):
            rng = self.rng(index, f"attempt {attempt}")
            start, *goals = [(x, y) for x, y in rng.uniform(-half + 0.5, half - 0.5, (5, 2)).tolist()]
            follower, wanderer = [(x, y) for x, y in rng.uniform(-half + 0.8, half - 0.8, (2, 2)).tolist()]
            legs = [dist(a, b) for a, b in zip((start, *goals), goals, strict=False)]
            apart = min(dist(start, follower), dist(start, wanderer), dist(follower, wanderer))
            if min(legs) > 0.35 * self.side and apart > 1.2 and dist(start, follower) < 0.6 * self.side:
                break
        else:
            raise InputError(f"three robots and four places do not fit into {self.side} m.")
        name, doc = self.scene_name(index), "EXP3: R visits four random places, R3 follows it, and W1 wanders."
        floor = Floor(
            (-half, -half), (half, half), walls_around((-half, -half), (half, half), thickness=0.05, height=0.5)
        )
        path = (start, *goals)
        turns = [
            abs((atan2(c[1] - b[1], c[0] - b[0]) - atan2(b[1] - a[1], b[0] - a[0]) + pi) % (2.0 * pi) - pi)
            for a, b, c in zip(path, path[1:], path[2:], strict=False)
        ]
        difficulty = {"length": length_of(path), "turning": sum(turns)}
        root = {"format": "scenario/2", "doc": doc, "world": name, "duration": "90 s", "end_on_collision": False}
        scenario = root | self.tables(path, follower, wanderer, float(rng.uniform(-pi, pi)))
        return Scene(scenario, floor, difficulty, path)

    def tables(
        self,
        path: tuple[tuple[float, float], ...],
        follower: tuple[float, float],
        wanderer: tuple[float, float],
        heading: float,
    ) -> dict[str, Any]:
        """Scenario tables of places, agents and actors.

        Args:
            path: Start of the visiting robot and its four places [m].
            follower: Start position of the following robot [m].
            wanderer: Start position of the wandering robot [m].
            heading: Initial yaw of the wandering robot [rad].
        """
        jitter = {"x": "0.05 m", "y": "0.05 m", "yaw": "10 deg"}

        def start(at: tuple[float, float], towards: tuple[float, float]) -> dict[str, object]:
            yaw = atan2(towards[1] - at[1], towards[0] - at[0])
            return {**position(at, yaw), "jitter": jitter}

        places = [{"name": n, **position(at), "agents": ["R"]} for n, at in zip(NAMES, path[1:], strict=True)]
        visitor = {
            "name": "R",
            "robot": self.robot,
            "mission": self.mission,
            "rules": [self.rules] if self.rules else [],
            **start(path[0], path[1]),
            "success": {"goal": NAMES[-1]},
            "parameters": {"cruise": "0.4 m/s"},
        }
        behind = {
            "name": "R3",
            "robot": self.follower,
            "mission": "follow_robot",
            "rules": ["avoid_collision"],
            **start(follower, path[0]),
            "parameters": {"leader": "R", "distance": "1.5 m", "room": "1.3 m", "cruise": "0.8 m/s", "rest": "8 s"},
        }
        wanders = {
            "name": "W1",
            "robot": "pioneer_p3dx",
            "script": "random_walk",
            "max_speed": quantity(self.speed, "m/s"),
            **position(wanderer, heading),
            "jitter": jitter,
        }
        return {"place": places, "agent": [visitor, behind], "actor": [wanders]}
