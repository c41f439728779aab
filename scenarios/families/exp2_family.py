"""Variations of EXP2: a robot drives to a place and stays there, while others wander and disturb it."""

from math import atan2, dist, pi

from rocs_bt import Count, InputError, Pose2, PositiveMetres, PositiveMetresPerSecond
from rocs_bt.compare import Family, Floor, Scene, goal_scenario, position, quantity, walls_around


class Exp2Family(Family):
    """Variations of EXP2: a robot drives to a place and stays there, while others wander and disturb it.

    These are scenes of the paper's second experiment with random start, place and wandering robots (wanderers). Success
    means that the robot is at the place when the run ends.

    Difficulty: `length` of the straight line from start to place [m]; number of `wanderers`; `density`: wanderers per
    floor area [1/m2].
    """

    robot: str = "summit_xl"
    wanderers: Count = 1
    side: PositiveMetres = 5.0
    speed: PositiveMetresPerSecond = 0.3

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        half = self.side / 2.0
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            places = [tuple(p) for p in rng.uniform(-half + 0.8, half - 0.8, (2 + self.wanderers, 2)).tolist()]
            (start, goal, *others), apart = places, [dist(a, b) for i, a in enumerate(places) for b in places[:i]]
            if dist(start, goal) > 0.4 * self.side and min(apart) > 1.0:
                break
        else:
            raise InputError(f"{self.wanderers} wanderers do not fit into {self.side} m.")
        name, doc = self.scene_name(index), "EXP2: drive to a place and stay there, random start and place."
        floor = Floor(
            (-half, -half), (half, half), walls_around((-half, -half), (half, half), thickness=0.05, height=0.5)
        )
        wanderers = [
            {
                "name": f"W{i + 1}",
                "robot": "pioneer_p3dx",
                "script": "random_walk",
                **position((x, y), float(rng.uniform(-pi, pi))),
                "jitter": {"x": "0.1 m", "y": "0.1 m", "yaw": "180 deg"},
                "max_speed": quantity(self.speed, "m/s"),
            }
            for i, (x, y) in enumerate(others)
        ]
        facing = quantity(atan2(-goal[1], -goal[0]), "deg")
        scenario = goal_scenario(
            self,
            name,
            doc,
            Pose2(start[0], start[1], atan2(goal[1] - start[1], goal[0] - start[0])),
            (goal[0], goal[1]),
            tolerance=0.15,
            duration=60.0,
            agent={
                "success": {"goal": "goal", "at": "end"},
                "parameters": {"goal": "goal", "hold": True, "facing": facing},
            },
        )
        scenario |= {"end_on_collision": False, "actor": wanderers}
        length = dist(start, goal)
        difficulty = {"length": length, "wanderers": float(self.wanderers), "density": self.wanderers / self.side**2}
        path = ((start[0], start[1]), (goal[0], goal[1]))
        return Scene(scenario, floor, difficulty, path)
