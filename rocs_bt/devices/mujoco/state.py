"""WorldState: a compiled model of an arena and robots with its present state, to be read."""

from __future__ import annotations

import hashlib
import math
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ...base.clock import Clock
from ...base.errors import UnknownName, unknown
from ...base.geometry import Pose2, Pose3, Twist2, Twist3, pose2, wrap_angle, yaw_of
from ..simulated.scene import Rays as Cast
from .body import Controls, FreeBody, MocapBody, Motors, RobotElements, bounds, find_bodies, find_objects, z_axis
from .nearness import Among, ClearanceQuery, Near
from .sight import LineOfSight
from .terrain import GroundHeight

_RAYS, _POSITION, _VELOCITY = range(3)  # stages of sensors: rangefinders, then those of MuJoCo, with acceleration last


class WorldState:
    """State of a simulated world in MuJoCo, protected by one lock. `Scene` describes the members that it declares.

    Elements of robots in the model have the robot's name as prefix.

    Attributes:
        model, data: MuJoCo's model and state, which devices must not change; hold `lock` to use them while another
            thread steps, and call `update_poses` before reading poses of sites or geoms.
        clock: Clock of the world.
        robots: Indices of the robots in the model, by name.
        objects: Named bodies that are no robots: mocap bodies, which scripts move, and free bodies, by name.
        parts: Names of objects that are parts of others, such as legs; `around` measures to the others only.
        step: Physics step [s].
        only_robots_move: Whether all movable bodies belong to robots.
    """

    def __init__(self, model: Any, robots: Sequence[str], clock: Clock) -> None:
        from .library import mujoco

        self._mj = mujoco
        self.model = model
        self.data = mujoco.MjData(model)
        # Views of MuJoCo's arrays, which have fixed memory; for few numbers they are faster than numpy.
        self._qpos: memoryview[float] = memoryview(self.data.qpos)
        self._qvel: memoryview[float] = memoryview(self.data.qvel)
        self._sensordata: npt.NDArray[np.float64] = self.data.sensordata
        self.clock = clock
        self.step = float(model.opt.timestep)
        self.lock = threading.RLock()
        self.stamp = clock.now()
        self.places: Mapping[str, Pose2] = {}
        self.robots: Mapping[str, RobotElements] = find_bodies(model, robots)
        self.objects: Mapping[str, MocapBody | FreeBody] = find_objects(model, self.robots)
        self.parts: set[str] = set()
        roots = {body.root for body in self.robots.values()}
        self.only_robots_move = not self.objects and roots.issuperset(model.body_rootid[model.dof_bodyid].tolist())
        mujoco.mj_kinematics(model, self.data)
        self._ground = GroundHeight(model, self.data)
        self._clearance = ClearanceQuery(model, self.robots)
        self._sight = LineOfSight(model, self.robots)
        self._revision = 0  # number of the present state, for values that are cached per state
        self._posed = -1
        self._past: deque[tuple[npt.NDArray[np.float64], ...]] = deque(maxlen=0)  # positions before the last steps
        self._scratch: Any = None  # MjData of a past state
        self._grip: dict[
            int, float
        ] = {}  # share of the travel that is left, by joint's index in qvel, of slipping wheels
        self._sensor_stages = _sensor_stages(model)
        self._sensed: dict[int, int] = {}  # revision of the values of each stage of sensors
        self._poses: dict[str, tuple[int, Pose2]] = {}
        self._sensors_off = int(model.opt.disableflags)
        self._sensors_on = self._sensors_off & ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)

    def body(self, robot: str) -> RobotElements:
        """Indices of a robot in the model.

        Raises:
            UnknownName: The world has no such robot.
        """
        if robot not in self.robots:
            raise UnknownName(unknown("robot", robot, self.robots, "The world"))
        return self.robots[robot]

    def pose(self, robot: str) -> Pose2:
        """True pose of a robot's base, world frame; cached per state."""
        known = self._poses.get(robot)
        if known is not None and known[0] == self._revision:
            return known[1]
        with self.lock:
            q = self.body(robot).q
            x, y, _, w, i, j, k = self._qpos[q : q + 7].tolist()
            pose = pose2((x, y, yaw_of(w, i, j, k)))
            self._poses[robot] = self._revision, pose
        return pose

    def pose3(self, robot: str) -> Pose3:
        """Pose of a robot's base in space, world frame."""
        q = self.body(robot).q
        with self.lock:
            state = self._qpos[q : q + 7].tolist()
        return Pose3.from_quaternion(state[:3], state[3:])

    def tilt(self, robot: str) -> float:
        """True angle between the z axis of a robot's base and the vertical [rad], in [0, pi]."""
        q, state = self.body(robot).q, self._qpos
        i, j = state[q + 4], state[q + 5]
        return math.acos(max(-1.0, 1.0 - 2.0 * (i * i + j * j)))

    def twist(self, robot: str) -> Twist2:
        """True velocity of a robot's base, body frame."""
        v, yaw = self.body(robot).v, self.pose(robot).yaw
        with self.lock:
            x, y, _, _, _, turn = self._qvel[v : v + 6].tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        return Twist2(c * x + s * y, turn, c * y - s * x)

    def twist3(self, robot: str) -> Twist3:
        """Velocity of a robot's base: forward and left (horizontal), up [m/s], turn about the vertical [rad/s]."""
        body = self.body(robot)
        with self.lock:
            w, i, j, k = self._qpos[body.q + 3 : body.q + 7].tolist()
            x, y, up, *turning = self._qvel[body.v : body.v + 6].tolist()
        yaw = self.pose(robot).yaw
        c, s = math.cos(yaw), math.sin(yaw)
        vertical = (2.0 * (i * k - w * j), 2.0 * (j * k + w * i), 1.0 - 2.0 * (i * i + j * j))  # in the body frame
        turn = sum(a * b for a, b in zip(vertical, turning, strict=True))
        return Twist3(c * x + s * y, c * y - s * x, up, turn)

    def mocap_body(self, name: str) -> MocapBody:
        """Find a mocap body by its name.

        Raises:
            UnknownName: The world has no such mocap body.
        """
        found, known = self.objects.get(name), [n for n, o in self.objects.items() if isinstance(o, MocapBody)]
        if not isinstance(found, MocapBody):
            raise UnknownName(unknown("mocap body", name, known, "The world"))
        return found

    def object_pose(self, name: str) -> Pose2:
        """Pose of a mocap body or a free body, world frame."""
        if isinstance(free := self.objects.get(name), FreeBody):
            with self.lock:
                x, y, _, w, i, j, k = self._qpos[free.q : free.q + 7].tolist()
            return Pose2(x, y, yaw_of(w, i, j, k))
        slot = self.mocap_body(name).slot
        with self.lock:
            x, y, _ = self.data.mocap_pos[slot].tolist()
            w, _, _, k = self.data.mocap_quat[slot].tolist()
        return Pose2(x, y, wrap_angle(2.0 * math.atan2(k, w)))

    def motor_speeds(self, motors: Motors) -> list[float]:
        """Speeds of motors [rad/s], in the order of `motors`, as their encoders measure them."""
        with self.lock:
            speeds = [self._qvel[j] for j in motors.joints]
        return self._unslipped(motors, speeds) if self._grip else speeds

    def motor_angles(self, motors: Motors) -> list[float]:
        """Angles of motors [rad], in the order of `motors`, as their encoders measure them."""
        with self.lock:
            angles = [self._qpos[a] for a in motors.angles]
        return self._unslipped(motors, angles) if self._grip else angles

    def _unslipped(self, motors: Motors, values: list[float]) -> list[float]:
        """Speeds or angles of motors with slip: the model's wheels turn less, so that its robot travels less."""
        return [value / self._grip.get(joint, 1.0) for value, joint in zip(values, motors.joints, strict=True)]

    def joint_positions(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True positions of the joints of actuators [rad or m], shape (n,); NaN without a joint."""
        with self.lock:
            return np.where(controls.angles < 0, math.nan, self.data.qpos[controls.angles])

    def joint_velocities(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True velocities of the joints of actuators [rad/s or m/s], shape (n,); NaN without a joint."""
        with self.lock:
            return np.where(controls.joints < 0, math.nan, self.data.qvel[controls.joints])

    def ground_height(self, x: float, y: float) -> float:
        """Height of the ground over the level floor at a point of the world frame [m]; obstacles do not count."""
        with self.lock:
            return self._ground.at(x, y)

    def clearance(self, robot: str, limit: float = math.inf, among: Among = "all") -> tuple[float, str]:
        """Distance from a robot's hull to the nearest obstacle, without the floor.

        Args:
            robot: Name of the robot.
            limit: Distance beyond which obstacles are ignored [m].
            among: Obstacles that count: other `robots`, `obstacles` that are no robots, or `all`.

        Returns:
            Distance [m], negative if they overlap, and name of the obstacle; (limit, "") if none is within the limit.
        """
        body = self.body(robot)
        with self.lock:
            self.update_poses()
            return self._clearance.clearance(self.data, body, limit, among)

    def around(self, name: str, limit: float, *, robots: bool = True, objects: bool = True) -> list[Near]:
        """Robots and objects near one of them.

        Args:
            name: Name of the robot or object.
            limit: Distance beyond which they are ignored [m].
            robots: Whether robots count.
            objects: Whether other objects count; their parts do not.
        """
        others = {robot: body.hull for robot, body in self.robots.items()} if robots else {}
        if objects:
            others |= {other: body.geoms for other, body in self.objects.items() if other not in self.parts}
        own = self.robots[name].hull if name in self.robots else self.objects[name].geoms
        others.pop(name, None)
        with self.lock:
            self.update_poses()
            return self._clearance.around(self.data, own, others, limit)

    def sunk(self, robot: str) -> tuple[float, str, str]:
        """Depth of a robot's hull in the level floor [m], and the names of both geoms; (0, "", "") if it is above."""
        body = self.body(robot)
        with self.lock:
            self.update_poses()
            return self._clearance.sunk(self.data, body)

    def room(self, x: float, y: float, z: float = 0.15) -> float:
        """Distance from a point (x, y, z), world frame [m], to the nearest static obstacle, without the floor [m]."""
        with self.lock:
            self.update_poses()
            return self._clearance.room(self.data, np.array([x, y, z]))

    def sees(self, robot: str, other: str, height: float) -> bool:
        """Whether nothing is between the bases of two robots at a height [m]."""
        here, there = self.pose(robot), self.pose(other)
        ends = (here.x, here.y, height), (there.x, there.y, height)
        with self.lock:
            self.update_poses()
            return self._sight.clear(self.data, self.body(robot), self.body(other), *ends)

    def sensed(self, addresses: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
        """Values of sensors of the model at n addresses, in the present state, shape (n,); cached per state."""
        with self.lock:
            for stage in {*self._sensor_stages.take(addresses).tolist()}:
                if self._sensed.get(stage) != self._revision:
                    self._compute_sensors(stage)
                    self._sensed[stage] = self._revision
            return self._sensordata.take(addresses)

    def sensor_address(self, robot: str, name: str) -> int:
        """Address of the first value of a sensor in a robot's model, for `sensed`; its other values follow.

        Raises:
            UnknownName: The model has no such sensor.
        """
        return int(self.model.sensor_adr[self._id("sensor", robot, name)])

    def beams(self, robot: str, sensor: str, sites: Sequence[str], angles: Sequence[tuple[float, float]]) -> Cast:
        """Function that casts the rays of a range sensor, which has some at each site."""
        names = [f"{sensor}/{site}/{ray}" for site in sites for ray in range(len(angles))]
        addresses = np.array([self.sensor_address(robot, name) for name in names], dtype=np.intp)

        def cast() -> npt.NDArray[np.float64]:
            found = self.sensed(addresses).reshape(len(sites), -1)  # -1 where a ray hits nothing
            return np.where(found < 0.0, math.inf, found)

        return cast

    def direction(self, robot: str, site: str, axis: Literal["x", "z"]) -> tuple[float, float, float, float]:
        """Place x, y [m] of a site and direction of its axis, body frame."""
        element = self.model.site(f"{robot}/{site}")
        x, y, _ = element.pos.tolist()
        if axis == "z":
            dx, dy, dz = z_axis(element.quat)
        else:
            w, i, j, k = element.quat.tolist()
            dx, dy, dz = 1.0 - 2.0 * (j * j + k * k), 2.0 * (w * k + i * j), 2.0 * (i * k - w * j)
        return x, y, math.atan2(dy, dx), math.atan2(dz, math.hypot(dx, dy))

    def bounds(self) -> tuple[float, float, float, float]:
        """Minimum x, minimum y, maximum x, maximum y of the static geoms [m]; infinite for an infinite floor."""
        return bounds(self.model)

    def digest(self, into: hashlib._Hash) -> None:
        """Update a hash with all generalised positions (float64 bytes), to compare trajectories."""
        with self.lock:
            into.update(self._qpos)

    def update_poses(self) -> None:
        """Compute the poses of all geoms and sites in `data`, which a physics step leaves at the previous state."""
        if self._posed != self._revision:
            self._mj.mj_kinematics(self.model, self.data)
            self._posed = self._revision

    def remember(self, duration: float) -> None:
        """Keep the positions of all bodies for a time [s], for `past`; the longest of all calls counts."""
        steps = max(round(duration / self.step), self._past.maxlen or 0)
        self._past = deque(self._past, maxlen=steps)
        if steps and self._scratch is None:
            self._scratch = self._mj.MjData(self.model)

    def past(self, stamp: float) -> Any:
        """MjData with the positions of the physics step nearest to a time [s], and updated poses.

        The time is at most as long ago as asked for by `remember`; before the start, the first positions count. The
        result is valid until the next call.
        """
        with self.lock:
            ago = min(round((self.stamp - stamp) / self.step), len(self._past))
            data = self.data
            positions = self._past[-ago] if ago else (data.qpos, data.mocap_pos, data.mocap_quat)
            scratch = self._scratch
            scratch.qpos[:], scratch.mocap_pos[:], scratch.mocap_quat[:] = positions
            self._mj.mj_kinematics(self.model, scratch)
            return scratch

    def _compute_sensors(self, stage: int) -> None:
        """Compute the sensors of one stage of the model; physics steps compute none."""
        mj, model, data = self._mj, self.model, self.data
        if stage == _RAYS:
            self.update_poses()
        else:
            mj.mj_fwdPosition(model, data)
            self._posed = self._revision
        model.opt.disableflags = self._sensors_on
        if stage <= _POSITION:
            mj.mj_sensorPos(model, data)
        elif stage == _VELOCITY:
            mj.mj_fwdVelocity(model, data)
            mj.mj_sensorVel(model, data)
        else:
            warm_start = data.qacc_warmstart.copy()  # a reading must not change the next physics step
            mj.mj_forward(model, data)
            data.qacc_warmstart[:] = warm_start
        model.opt.disableflags = self._sensors_off

    def _id(self, kind: str, robot: str, name: str) -> int:
        obj, model = self._mj.mjtObj, self.model
        kinds = {"actuator": obj.mjOBJ_ACTUATOR, "sensor": obj.mjOBJ_SENSOR, "geom": obj.mjOBJ_GEOM}
        found = self._mj.mj_name2id(self.model, kinds[kind], f"{robot}/{name}")
        if found < 0:
            count = {"actuator": model.nu, "sensor": model.nsensor, "geom": model.ngeom}[kind]
            names = [str(self._mj.mj_id2name(self.model, kinds[kind], i)) for i in range(count)]
            own = [n.removeprefix(f"{robot}/") for n in names if n.startswith(f"{robot}/")]
            raise UnknownName(unknown(f"MuJoCo {kind} of {robot}", name, own, f"The model of {robot}"))
        return int(found)


def _sensor_stages(model: Any) -> npt.NDArray[np.intp]:
    """Stage of each value in `sensordata`. Rangefinders need less than MuJoCo's position stage: the poses only."""
    from .library import mujoco

    rays = model.sensor_type == int(mujoco.mjtSensor.mjSENS_RANGEFINDER)
    return np.repeat(np.where(rays, _RAYS, model.sensor_needstage), model.sensor_dim)
