"""Costs of Nav2's costmaps, computed from the robot's own map, and the nodes that read them.

The map is the occupancy grid that the robot builds; a robot without one has the objects of its world model, and
everything else is free. The map moves with the robot, so cells outside of it are unknown, not lethal as in Nav2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose2
from ..knowledge import FREE, OCCUPIED, UNKNOWN
from ..plan.context import mission_of
from ..trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output
from .lenient import Serviced
from .path import nearest, poses_in, within
from .poses import PoseText, known, pose_of, robot_pose

if TYPE_CHECKING:
    from ..plan.context import MissionContext

INSCRIBED, LETHAL, NO_INFORMATION = 253, 254, 255
"""Costs of cells in which a round robot touches an obstacle, of obstacles, and of unknown cells."""

INFLATION, DECAY = 0.55, 3.0
"""Distance from obstacles up to which cells have a cost [m], and its decay [1/m], as in Nav2's defaults."""

CELL = 0.05
"""Side of the cells for a robot without a map [m]."""

States = npt.NDArray[np.int8]
Costs = npt.NDArray[np.int_]
Points = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Costmap:
    """Costs around poses, for one robot.

    Attributes:
        mission: Mission of the robot with the map.
        radius: Radius of a circular robot [m]; None for a rectangular one.
        length: Size along the robot [m].
        width: Size across the robot [m].
    """

    mission: MissionContext
    radius: float | None
    length: float
    width: float

    @classmethod
    def of(cls, mission: MissionContext) -> Costmap:
        """Costmap of a mission's robot, with the outline in its Knowledge."""
        body = mission.knowledge.graph.attributes(mission.knowledge.agent)
        return cls(mission, body.get("radius"), body.get("length", 0.0), body.get("width", 0.0))

    def costs(self, poses: Sequence[Pose2], *, outline: bool = True) -> list[int]:
        """Cost at each pose: of its cell, or the greatest on the outline of a rectangular robot.

        Without a heading (NaN), a pose at which a rectangular robot touches an obstacle at each heading is LETHAL. If
        not `outline`, it is the cost of the cell at each position.
        """
        if not poses:
            return []
        boxed = outline and self.radius is None
        rows = [self._outline(p) if boxed and math.isfinite(p.yaw) else np.array([p[:2]]) for p in poses]
        costs, counts = self._at(np.vstack(rows)), [len(row) for row in rows]
        found = [_greatest(part) for part in np.split(costs, np.cumsum(counts)[:-1])]
        return [LETHAL if boxed and len(r) == 1 and c == INSCRIBED else c for r, c in zip(rows, found, strict=True)]

    def collisions(self, poses: Sequence[Pose2]) -> list[Pose2]:
        """Poses at which the robot would touch an obstacle."""
        centres = self.costs(poses, outline=False)  # an obstacle that is smaller than the robot is within its outline
        found = zip(poses, self.costs(poses), centres, strict=True)
        return [p for p, cost, centre in found if cost == LETHAL or INSCRIBED <= centre < NO_INFORMATION]

    def _outline(self, pose: Pose2) -> Points:
        """Points on the outline, at most half a cell apart, world frame [m], shape (k, 2)."""
        x, y = 0.5 * self.length, 0.5 * self.width
        steps = max(2, math.ceil(max(self.length, self.width) / (0.5 * CELL)) + 1)
        along, across = np.linspace(-x, x, steps), np.linspace(-y, y, steps)
        points = np.vstack([np.column_stack([along, np.full(steps, s)]) for s in (-y, y)])
        points = np.vstack([points, *(np.column_stack([np.full(steps, s), across]) for s in (-x, x))])
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        turned: Points = points @ np.array([[c, s], [-s, c]]) + pose[:2]
        return turned

    def _at(self, points: Points) -> Costs:
        """Costs of the cells at points, shape (k,)."""
        from scipy.ndimage import distance_transform_edt

        margin = INFLATION + CELL
        states, x, y, cell = self._states(points.min(axis=0) - margin, points.max(axis=0) + margin)
        inner = self.radius if self.radius is not None else 0.5 * min(self.length, self.width)
        away = np.full(states.shape, math.inf)
        if (states == OCCUPIED).any():
            away = distance_transform_edt(states != OCCUPIED) * cell
        costs = np.where(away < INFLATION, (252.0 * np.exp(-DECAY * np.maximum(away - inner, 0.0))).astype(int), 0)
        costs[states == UNKNOWN] = NO_INFORMATION
        costs[away <= inner] = INSCRIBED
        costs[states == OCCUPIED] = LETHAL
        column, row = (np.floor((points[:, i] - low) / cell).astype(int) for i, low in ((0, x), (1, y)))
        found: Costs = costs[row.clip(0, states.shape[0] - 1), column.clip(0, states.shape[1] - 1)]
        return found

    def _states(self, low: Points, high: Points) -> tuple[States, float, float, float]:
        """States of the cells of a rectangle, its western and southern edge, and the side of a cell [m]."""
        grid = self.mission.knowledge.world.occupancy
        if grid is not None:
            window = grid.window((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))
            return window.states, window.x, window.y, window.cell
        first = np.floor(low / CELL)
        count = np.ceil(high / CELL) - first
        columns, rows = np.meshgrid(*((first[i] + 0.5 + np.arange(count[i])) * CELL for i in (0, 1)))
        states = np.full(columns.shape, FREE, np.int8)
        for name in self.mission.knowledge.world.objects():
            states[_inside(self.mission.knowledge.graph.attributes(name), columns, rows)] = OCCUPIED
        return states, float(first[0] * CELL), float(first[1] * CELL), CELL


def _inside(known: dict[str, Any], x: Points, y: Points) -> npt.NDArray[np.bool_]:
    """Which points [m] are inside an object of the world model; none if its pose or size is unknown."""
    pose = known.get("pose")
    if pose is None or not ("radius" in known or ("length" in known and "width" in known)):
        return np.zeros(x.shape, bool)
    dx, dy, c, s = x - pose.x, y - pose.y, math.cos(pose.yaw), math.sin(pose.yaw)
    if "radius" in known:
        round_: npt.NDArray[np.bool_] = np.hypot(dx, dy) <= known["radius"]
        return round_
    along, across = np.abs(c * dx + s * dy), np.abs(c * dy - s * dx)
    inside: npt.NDArray[np.bool_] = (along <= 0.5 * known["length"]) & (across <= 0.5 * known["width"])
    return inside


def _greatest(costs: Costs) -> int:
    """Greatest cost, where a lethal cell counts more than an unknown one."""
    return LETHAL if (costs == LETHAL).any() else int(costs.max())


class _PathCheck(Serviced):
    """Base of nodes that test a path from the pose nearest to the robot to its end."""

    path: Annotated[Any, "path"] = "{path}"
    unseen_is_valid = True
    """Result while the robot's pose is unknown."""

    def check(self, limit: float) -> list[Pose2] | None:
        """Bad poses of the path within a length after the nearest pose [m]; None if the path cannot be tested."""
        mission, path = mission_of(self), poses_in(self.path)
        if not path:
            self.feedback_message = "the path is empty"
            return None
        here = known(robot_pose(mission))
        if here is None:
            self.feedback_message = "the pose of the robot is unknown"
            return [] if self.unseen_is_valid else None
        ahead = path[nearest(path, here) :]
        ahead = ahead[: within(ahead, limit)]
        costmap = Costmap.of(mission)
        costs = costmap.costs(ahead)
        bad = [pose for pose, cost in zip(ahead, costs, strict=True) if self.bad(cost, costmap.radius is not None)]
        self.feedback_message = (
            f"the path collides at ({bad[0].x:.2f}, {bad[0].y:.2f}) m" if bad else "the path is free"
        )
        return bad

    def bad(self, cost: int, round_: bool) -> bool:
        """Whether a pose is in collision."""
        raise NotImplementedError


class _CostLimited(_PathCheck):
    """Base of path checks with a maximum cost, as since Kilted."""

    consider_unknown_as_obstacle: Annotated[bool, "whether unknown cells are obstacles; else they are free"] = False

    def bad(self, cost: int, round_: bool) -> bool:
        if cost == NO_INFORMATION:
            cost = LETHAL if self.consider_unknown_as_obstacle else 0
        return cost == LETHAL or cost >= self.read("max_cost") or (round_ and cost == INSCRIBED)


class IsPathValid(_CostLimited, Instant):
    """SUCCESS if the rest of a path is free in the robot's map; since Lyrical, Nav2 has ValidatePath instead."""

    kind = "Condition"
    max_cost: Annotated[int, "least cost that is an obstacle"] = 253

    def update(self) -> Outcome:
        bad = self.check(math.inf)
        return FAILURE if bad is None or bad else SUCCESS


class ValidatePath(_CostLimited, Instant):
    """SUCCESS if the rest of a path is free in the robot's map; FAILURE also while the robot's pose is unknown."""

    unseen_is_valid = False
    max_cost: Annotated[int, "least cost that is an obstacle"] = 254
    layer_name: Annotated[str, "layer of the costmap; for a running Nav2 only"] = ""
    footprint: Annotated[str, "outline; for a running Nav2 only"] = ""
    stop_at_first_collision: Annotated[bool, "whether `collision_poses` contains only the first bad pose"] = True
    max_lookahead_distance: Annotated[float, "length of the path that is tested [m]; all of it if not above 0"] = -1.0
    collision_poses: Annotated[Output[Any], "poses of the path that collide"]

    def update(self) -> Outcome:
        limit = self.max_lookahead_distance
        bad = self.check(limit if limit > 0.0 else math.inf)
        if bad is None:
            return FAILURE
        self.collision_poses = bad[:1] if self.stop_at_first_collision else bad
        return FAILURE if bad else SUCCESS


class OccupancyTest(Serviced):
    """Base of nodes that compare the costs of poses with a threshold."""

    cost_threshold: Annotated[float, "least cost that is an obstacle"] = 254.0
    use_footprint: Annotated[bool, "whether the outline of the robot counts; else only the cell at the position"] = True
    consider_unknown_as_obstacle: Annotated[bool, "whether unknown cells are obstacles"] = False

    def occupied(self, pose: Pose2) -> bool:
        """Whether the cost of a pose reaches the threshold."""
        (cost,) = Costmap.of(mission_of(self)).costs([pose], outline=self.use_footprint)
        return self.consider_unknown_as_obstacle if cost == NO_INFORMATION else cost >= self.cost_threshold


class CheckPoseOccupancy(OccupancyTest, Instant):
    """SUCCESS if a pose is occupied in the robot's map."""

    pose: Annotated[PoseText, "pose"] = None

    def update(self) -> Outcome:
        given = self.pose
        pose = None if given is None else pose_of(mission_of(self), given)
        if pose is None:
            self.feedback_message = "there is no pose"
            return FAILURE
        return SUCCESS if self.occupied(pose) else FAILURE
