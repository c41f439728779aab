"""WorldModel: knowledge about the world around the robot (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from typing import Any

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2, Pose3, Twist2, along_arc, twist2
from .base import Model
from .movers import Movers
from .occupancy import OccupancyGrid


class WorldModel(Model):
    """View of knowledge as the world: places, goals, objects and peers with their poses, and the pursued goal.

    Attributes:
        occupancy: Occupancy grid that the robot builds; None if no block builds one.
        movers: Estimates of what moves around the robot, as of the latest scan; None if no block tracks it.
        foreseen: True movers with their future, which a simulation gives to oracle planners only; they are `movers`,
            too, instead of estimates.
    """

    occupancy: OccupancyGrid | None = None
    movers: Movers | None = None
    foreseen: Movers | None = None

    def place(self, name: str, pose: Pose2 | Pose3, kind: str = "place", **attributes: Any) -> None:
        """Add a node with a pose, or move it.

        Args:
            name: Name of the node; added if it does not exist.
            pose: Pose in the world frame [m, m, rad]. A `Pose3` also sets the attribute `z`; its tilt is not stored.
            kind: Kind of the node: `goal`, `place`, `object`, `peer`, or another kind that has a pose.
            attributes: Further attributes of that kind.

        Raises:
            KnowledgeError: The node is of another kind, or the schema rejects an attribute.
        """
        if isinstance(pose, Pose3):
            attributes.setdefault("z", pose.z)
            pose = pose.plane
        with self.graph.locked():
            if not self.graph.has(name):
                self.graph.add(name, kind, pose=pose, **attributes)
            elif (is_kind := self.graph.kind(name)) != kind:
                raise KnowledgeError(f"cannot place '{name}' as {kind}: it exists, of kind {is_kind}; remove it first.")
            else:
                self.graph.set(name, pose=pose, **attributes)

    def pose_of(self, name: str) -> Pose2 | None:
        """Pose of a node in the world frame; None if the pose or the node is unknown."""
        if not self.graph.has(name):
            return None
        if name == self.name:
            pose = self.knowledge.pose()
            return None if math.isnan(pose.x) else pose
        try:
            found: Pose2 | None = self.graph.get(name, "pose")
        except KnowledgeError:  # its kind has no pose
            return None
        return found

    def z_of(self, name: str) -> float | None:
        """Height of a node's pose, world frame [m]; None on the floor, or while the height or the node is unknown."""
        if name == self.name:
            signals, t = self.signals, self.knowledge.clock.now()
            height = signals.value("height", t) if "height" in signals else math.nan
            return None if math.isnan(height) else height
        try:
            found: float | None = self.graph.get(name, "z") if self.graph.has(name) else None
        except KnowledgeError:  # its kind has no pose
            return None
        return found

    def places(self) -> list[str]:
        """Names of all places."""
        return self.graph.nodes("place")

    def goals(self) -> list[str]:
        """Names of all goals."""
        return self.graph.nodes("goal")

    def objects(self) -> list[str]:
        """Names of all objects."""
        return self.graph.nodes("object")

    def peers(self) -> list[str]:
        """Names of all known other robots."""
        return self.graph.nodes("peer")

    def motion_of(self, peer: str) -> tuple[float, Pose2, Twist2] | None:
        """Motion of a peer: time of its pose [s], pose in the world frame, twist; None while its pose is unknown.

        An unknown speed or turn rate counts as zero.

        Raises:
            KnowledgeError: No such peer.
        """
        get = self.graph.get
        while True:  # until no other thread has written in between
            since = self.graph.stamp(peer, "pose")
            pose, speed, turn_rate = get(peer, "pose"), get(peer, "speed"), get(peer, "turn_rate")
            if self.graph.stamp(peer, "pose") == since:
                break
        if pose is None:
            return None
        return since.t, pose, twist2((0.0 if speed is None else speed, 0.0 if turn_rate is None else turn_rate, 0.0))

    def predicted(self, peer: str, t: float) -> Pose2 | None:
        """Predicted pose of a peer at time t [s], world frame, assuming constant speed and turn rate; None if unknown.

        Raises:
            KnowledgeError: No such peer.
        """
        motion = self.motion_of(peer)
        return None if motion is None else along_arc(motion[1], motion[2], t - motion[0])

    def pursue(self, goal: str | None) -> None:
        """Pursue this goal from now on; None to pursue none.

        Raises:
            KnowledgeError: No such goal.
        """
        if goal is not None:
            self.graph.relate(self.name, "pursues", goal)
            return
        with self.graph.locked():
            for old in self.graph.related(self.name, "pursues"):
                self.graph.unrelate(self.name, "pursues", old)

    def pursued(self) -> str | None:
        """The pursued goal; None if there is none."""
        goals = self.graph.related(self.name, "pursues")
        return goals[0] if goals else None

    def goal_distance(self, t: float | None = None) -> float:
        """Distance to the pursued goal at time t [m]: +inf without a goal, NaN while the robot's pose is not valid."""
        goal = self.pursued()
        pose = None if goal is None else self.pose_of(goal)
        return math.inf if pose is None else self.knowledge.pose(t).distance(pose)
