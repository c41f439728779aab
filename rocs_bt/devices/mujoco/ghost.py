"""GhostWorld: copy of a world that goes on without physics, to look into the future of scripts."""

from __future__ import annotations

import math

from .body import FreeBody, MocapBody
from .world import MujocoWorld


class GhostWorld(MujocoWorld):
    """Copy of a world in which bodies keep their velocities: contacts and motors have no effect, and no clock advances.

    Scripts can read it, and move their objects in it, as in the world itself.
    """

    def __init__(self, world: MujocoWorld) -> None:
        self.__dict__.update(vars(world))
        self._world = world
        self.data = self._mj.MjData(self.model)
        self._qpos, self._qvel = memoryview(self.data.qpos), memoryview(self.data.qvel)
        self._poses, self._sensed = {}, {}
        self._bases = [robot.v for robot in self.robots.values()]
        self._bases += [body.v for body in self.objects.values() if isinstance(body, FreeBody)]
        self.mirror()

    def mirror(self) -> None:
        """Take over the present state of the world."""
        world, data = self._world, self.data
        with world.lock:
            data.qpos[:], data.qvel[:] = world.data.qpos, world.data.qvel
            data.mocap_pos[:], data.mocap_quat[:] = world.data.mocap_pos, world.data.mocap_quat
            self._drift, self._turns, self.stamp = world._drift.copy(), {}, world.stamp
        for v in self._bases:
            data.qvel[v + 2 : v + 5] = 0.0  # neither up nor tilting
        self._revision += 1

    def go_on(self, duration: float) -> None:
        """Move all bodies for a duration [s] at their present speeds and turn rates."""
        self._turn(0.5 * duration)  # the velocity of the middle of the duration
        self._mj.mj_integratePos(self.model, self.data.qpos, self.data.qvel, duration)
        self._turn(0.5 * duration)
        self.data.mocap_pos += self._drift * (duration / self.step)
        self.stamp += duration
        self._revision += 1

    def _turn(self, duration: float) -> None:
        """Turn the velocities of robots and free bodies with them."""
        qvel = self.data.qvel
        for v in self._bases:
            x, y, turn = float(qvel[v]), float(qvel[v + 1]), duration * float(qvel[v + 5])
            c, s = math.cos(turn), math.sin(turn)
            qvel[v : v + 2] = c * x - s * y, s * x + c * y

    def radius(self, name: str) -> float | None:
        """Radius of an object that a script moves [m]; None unless its widest geom is upright and round."""
        kinds, geoms = self._mj.mjtGeom, self.objects[name].geoms
        if not isinstance(self.objects[name], MocapBody) or not geoms:
            return None
        widest = max(geoms, key=lambda geom: float(self.model.geom_size[geom, 0]))
        round_kinds = kinds.mjGEOM_SPHERE, kinds.mjGEOM_CAPSULE, kinds.mjGEOM_CYLINDER
        is_round = kinds(self.model.geom_type[widest]) in round_kinds
        return float(self.model.geom_size[widest, 0]) if is_round else None
