"""MujocoWorld: the simulated world, a compiled model of an arena and robots with its state."""

from __future__ import annotations

import hashlib
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...clock import Clock, SimulatedClock
from ...errors import BlockError, DeviceError, Fault, InputError, UnknownName, unknown
from ...geometry import Pose2, Pose3, Twist2, Twist3, pose2, wrap_angle
from ...safety import SafetyGate
from .body import Controls, FreeBody, MocapBody, Motors, RobotBody, bounds, find_bodies, find_objects
from .ground import carrying_geoms
from .nearness import Among, ClearanceQuery
from .sight import LineOfSight
from .terrain import GroundHeight
from .touch import Contact, ContactDetector

__all__ = ["Contact", "MujocoWorld"]

_UNSTABLE = (
    "MuJoCo found NaN, infinite or huge positions, velocities or accelerations. Use weaker forces, larger masses or a "
    "shorter physics step."
)


_RAYS, _POSITION, _VELOCITY = range(3)  # stages of sensors: rangefinders, then those of MuJoCo, with acceleration last


class MujocoWorld:
    """Simulated world: an arena, robots and time in MuJoCo, protected by one lock.

    Args:
        model: Compiled MjModel; elements of robots have the robot's name as prefix.
        robots: Names of the robots.
        clock: Clock of the world; a simulated clock is advanced by each physics step.

    Attributes:
        model, data: MuJoCo's model and state; hold `lock` to use them while another thread steps.
        robots: Indices of the robots in the model, by name.
        objects: Named bodies that are no robots: mocap bodies, which scripts move, and free bodies, by name.
        step: Physics step [s].
        lock: Lock of the state, held for each physics step and each read.
        stamp: Time of the present state, on `clock` [s].
        only_robots_move: Whether all movable bodies belong to robots.
    """

    def __init__(self, model: Any, robots: Sequence[str], clock: Clock) -> None:
        from .library import mujoco

        self.model = model
        self.data = mujoco.MjData(model)
        # Views of MuJoCo's arrays, which have fixed memory; for few numbers they are faster than numpy.
        self._qpos: memoryview[float] = memoryview(self.data.qpos)
        self._qvel: memoryview[float] = memoryview(self.data.qvel)
        self._ctrl: memoryview[float] = memoryview(self.data.ctrl)
        kinds = mujoco.mjtWarning
        bad = slice(int(kinds.mjWARN_BADQPOS), int(kinds.mjWARN_BADQACC) + 1)  # of positions, velocities, accelerations
        self._bad: memoryview[int] = memoryview(self.data.warning.number)[bad]
        self._sensordata: npt.NDArray[np.float64] = self.data.sensordata
        self.clock = clock
        self.step = float(model.opt.timestep)
        self.lock = threading.RLock()
        self.stamp = clock.now()
        self.robots: Mapping[str, RobotBody] = find_bodies(model, robots)
        self.objects: Mapping[str, MocapBody | FreeBody] = find_objects(model, self.robots)
        roots = {body.root for body in self.robots.values()}
        self.only_robots_move = not self.objects and roots.issuperset(model.body_rootid[model.dof_bodyid].tolist())
        self._drift = np.zeros((model.nmocap, 3))  # [m] displacements of scripted objects per physics step
        self._turns: dict[int, float] = {}  # [rad] turns of scripted objects per physics step, by slot
        self._pushes: list[tuple[int, RobotBody, npt.NDArray[np.float64]]] = []  # end [steps], robot, force [N]
        self._mj = mujoco
        self._simulated = isinstance(clock, SimulatedClock)
        self._tick: Callable[[], None] = clock.advance if isinstance(clock, SimulatedClock) else lambda: None
        self._motors: dict[str, list[Motors]] = {name: [] for name in robots}
        self._late: list[Motors] = []  # motors with a delay
        self._steps = 0  # number of physics steps since the start
        self._ramping: list[Motors] = []  # motors that have not reached their targets
        self._gates: list[SafetyGate] = []
        self._loops: list[Callable[[float], None]] = []  # inner loops of actuators
        self._motion: dict[str, SafetyGate] = {}  # gates of robots' motion actuators without velocity motors
        self._touch = ContactDetector(model, self.robots)
        mujoco.mj_kinematics(model, self.data)
        for name, body in self.robots.items():
            self._touch.allow_ground(name, carrying_geoms(model, self.data, body))
        self._ground = GroundHeight(model, self.data)
        self._clearance = ClearanceQuery(model, self.robots)
        self._sight = LineOfSight(model, self.robots)
        self._revision = 0  # number of the present state, for values that are cached per state
        self._posed = -1
        self._sensor_stages = _sensor_stages(model)
        self._sensed: dict[int, int] = {}  # revision of the values of each stage of sensors
        self._poses: dict[str, tuple[int, Pose2]] = {}
        self._sensors_off = int(model.opt.disableflags)
        self._sensors_on = self._sensors_off & ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)

    def body(self, robot: str) -> RobotBody:
        """Indices of a robot in the model.

        Raises:
            UnknownName: The world has no such robot.
        """
        if robot not in self.robots:
            raise UnknownName(unknown("robot", robot, self.robots, "The world"))
        return self.robots[robot]

    def place(self, robot: str, pose: Pose2, height: float | None = None) -> None:
        """Place a robot at rest.

        Args:
            robot: Name of the robot.
            pose: Pose of its base, world frame.
            height: Height of its base, world frame [m]; by default that of its model over the ground.
        """
        body = self.body(robot)
        with self.lock:
            q, v = body.q, body.v
            self.data.qpos[q : q + 7] = self.model.qpos0[q : q + 7]
            self.data.qpos[q : q + 2] = pose.x, pose.y
            if height is not None:
                self.data.qpos[q + 2] = height
            elif self._ground:
                self.data.qpos[q + 2] += self._ground.below(pose, body.reach)
            self.data.qpos[q + 3 : q + 7] = math.cos(pose.yaw / 2.0), 0.0, 0.0, math.sin(pose.yaw / 2.0)
            self.data.qvel[v : v + 6] = 0.0
            self._revision += 1

    def pose(self, robot: str) -> Pose2:
        """True pose of a robot's base, world frame; cached per state."""
        known = self._poses.get(robot)
        if known is not None and known[0] == self._revision:
            return known[1]
        with self.lock:
            q = self.body(robot).q
            x, y, _, w, i, j, k = self._qpos[q : q + 7].tolist()
            pose = pose2((x, y, wrap_angle(math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)))))
            self._poses[robot] = self._revision, pose
        return pose

    def pose3(self, robot: str) -> Pose3:
        """True pose of a robot's base in space, world frame."""
        q = self.body(robot).q
        with self.lock:
            state = self._qpos[q : q + 7].tolist()
        return Pose3.from_quaternion(state[:3], state[3:])

    def tilt(self, robot: str) -> float:
        """True angle between the z axis of a robot's base and the vertical [rad], in [0, pi]."""
        q, state = self.body(robot).q, self._qpos
        i, j = state[q + 4], state[q + 5]
        return math.acos(max(-1.0, 1.0 - 2.0 * (i * i + j * j)))

    def position(self, robot: str) -> list[float]:
        """True position of the origin of a robot's base: x, y, z [m], world frame."""
        q = self.body(robot).q
        with self.lock:
            return [*self._qpos[q : q + 3]]

    def twist(self, robot: str) -> Twist2:
        """True velocity of a robot's base, body frame."""
        v, yaw = self.body(robot).v, self.pose(robot).yaw
        with self.lock:
            x, y, _, _, _, turn = self._qvel[v : v + 6].tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        return Twist2(c * x + s * y, turn, c * y - s * x)

    def twist3(self, robot: str) -> Twist3:
        """True velocity of a robot's base in space; forward and left are horizontal, up and turn vertical."""
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
            return Pose2(x, y, wrap_angle(math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))))
        slot = self.mocap_body(name).slot
        with self.lock:
            x, y, _ = self.data.mocap_pos[slot].tolist()
            w, _, _, k = self.data.mocap_quat[slot].tolist()
        return Pose2(x, y, wrap_angle(2.0 * math.atan2(k, w)))

    def place_object(self, name: str, pose: Pose2) -> None:
        """Move a mocap body, or a free body at rest, at once to a pose, world frame; a free body above the ground."""
        if isinstance(free := self.objects.get(name), FreeBody):
            with self.lock:
                turn = math.cos(pose.yaw / 2.0), 0.0, 0.0, math.sin(pose.yaw / 2.0)
                self.data.qpos[free.q : free.q + 7] = pose.x, pose.y, self.model.qpos0[free.q + 2], *turn
                self.data.qvel[free.v : free.v + 6] = 0.0
                if self._ground:
                    self._mj.mj_kinematics(self.model, self.data)
                    self.data.qpos[free.q + 2] += self._ground.below_geoms(free.tree, pose.yaw)
                self._revision += 1
            return
        slot = self.mocap_body(name).slot
        with self.lock:
            self.data.mocap_pos[slot, :2] = pose.x, pose.y
            self.data.mocap_quat[slot] = math.cos(pose.yaw / 2.0), 0.0, 0.0, math.sin(pose.yaw / 2.0)
            self._revision += 1

    def set_object_velocity(self, name: str, velocity: tuple[float, float]) -> None:
        """Set the velocity of a mocap body [m/s], world frame; contacts do not stop it."""
        slot = self.mocap_body(name).slot
        with self.lock:
            self._drift[slot, :2] = velocity[0] * self.step, velocity[1] * self.step

    def set_object_turn(self, name: str, rate: float) -> None:
        """Set the turn rate of a mocap body about its vertical axis [rad/s]; contacts do not stop it."""
        slot = self.mocap_body(name).slot
        with self.lock:
            self._turns[slot] = rate * self.step

    def push(self, robot: str, force: tuple[float, float, float], duration: float) -> None:
        """Apply a force to the origin of a robot's base from the next physics step on.

        Args:
            robot: Name of the robot.
            force: Force [N] forward, to the left and up, horizontal frame of the base at the present time.
            duration: Duration of the force [s], rounded to physics steps, at least one.
        """
        body, (x, y, up), yaw = self.body(robot), force, self.pose(robot).yaw
        c, s = math.cos(yaw), math.sin(yaw)
        with self.lock:
            end = self._steps + max(round(duration / self.step), 1)
            self._pushes.append((end, body, np.array([c * x - s * y, s * x + c * y, up])))

    def motors(self, robot: str, names: Sequence[str], max_change: float = math.inf, delay: float = 0.0) -> Motors:
        """Get a handle of velocity motors of a robot.

        Args:
            robot: Name of the robot.
            names: Names of the motors in the robot's model, without the robot's prefix.
            max_change: Maximum rate of change of a motor's speed [rad/s2].
            delay: Delay of each command [s], a whole number of physics steps.

        Raises:
            UnknownName: The model has no such actuator.
            InputError: The delay is not a whole number of physics steps.
        """
        self.body(robot)
        late = round(delay / self.step)
        if abs(late * self.step - delay) > 1e-6 * self.step:
            near = f"{1e3 * self.step * late:g} ms"
            message = f"the delay of {robot}'s motors, {1e3 * delay:g} ms, is not a whole number of physics steps of "
            raise InputError(Fault(f"{message}{1e3 * self.step:g} ms.", hint=f"Use {near}."))
        ids = [self._id("actuator", robot, name) for name in names]
        turned = [int(self.model.actuator_trnid[i, 0]) for i in ids]
        joints, angles = ([int(adr[j]) for j in turned] for adr in (self.model.jnt_dofadr, self.model.jnt_qposadr))
        motors = Motors(ids, joints, angles, [0.0] * len(ids), max_change * self.step, delay=late)
        self._motors[robot].append(motors)
        if late:
            self._late.append(motors)
        return motors

    def drive(self, motors: Motors, speeds: Sequence[float]) -> None:
        """Command the speeds of motors [rad/s], which are approached after the delay, at the maximum rate of change."""
        with self.lock:
            if motors.delay:
                motors.coming.append((self._steps + motors.delay, speeds))
            else:
                self._aim(motors, speeds)

    def motor_speeds(self, motors: Motors) -> list[float]:
        """True speeds of motors [rad/s]."""
        with self.lock:
            return [self._qvel[j] for j in motors.joints]

    def motor_angles(self, motors: Motors) -> list[float]:
        """True angles of motors since the start [rad]."""
        with self.lock:
            return [self._qpos[a] for a in motors.angles]

    def controls(self, robot: str, names: Sequence[str]) -> Controls:
        """Get a handle of actuators in a robot's model.

        Args:
            robot: Name of the robot.
            names: Names of the actuators in the robot's model, without the robot's prefix.

        Raises:
            UnknownName: The model has no such actuator.
        """
        self.body(robot)
        model, ids = self.model, np.array([self._id("actuator", robot, name) for name in names], np.intp)
        low, high = model.actuator_ctrlrange[ids].T
        limited = model.actuator_ctrllimited[ids].astype(bool)
        joint = model.actuator_trntype[ids] == int(self._mj.mjtTrn.mjTRN_JOINT)
        of = np.where(joint, model.actuator_trnid[ids, 0], 0)
        angles, joints = (np.where(joint, of_joint[of], -1) for of_joint in (model.jnt_qposadr, model.jnt_dofadr))
        low, high = np.where(limited, low, -np.inf), np.where(limited, high, np.inf)
        return Controls(robot, tuple(names), ids, low, high, angles, joints)

    def set_controls(self, controls: Controls, values: npt.ArrayLike) -> None:
        """Set the control values of actuators, limited to their ranges, from the next physics step on.

        Args:
            controls: Handle of the actuators.
            values: Control values, in MuJoCo's units of the actuators, shape (n,).

        Raises:
            DeviceError: The number of values is wrong, or a value is NaN.
        """
        wanted = np.asarray(values, np.float64)
        if wanted.shape != controls.ids.shape:
            raise DeviceError(f"{len(controls.ids)} actuators take as many values, found the shape {wanted.shape}.")
        if np.isnan(wanted).any():
            raise DeviceError(f"the value of '{controls.names[int(np.isnan(wanted).argmax())]}' is NaN.")
        with self.lock:
            self.data.ctrl[controls.ids] = np.minimum(np.maximum(wanted, controls.low), controls.high)

    def joint_positions(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True positions of the joints of actuators [rad or m], shape (n,); NaN without a joint."""
        with self.lock:
            return np.where(controls.angles < 0, math.nan, self.data.qpos[controls.angles])

    def joint_velocities(self, controls: Controls) -> npt.NDArray[np.float64]:
        """True velocities of the joints of actuators [rad/s or m/s], shape (n,); NaN without a joint."""
        with self.lock:
            return np.where(controls.joints < 0, math.nan, self.data.qvel[controls.joints])

    def attach(self, loop: Callable[[float], None]) -> None:
        """Call a function before each physics step with the time [s], in the order of attachment, with `lock` held.

        The function reads the present state, also the pose of a robot and `stamp`.
        """
        self._loops.append(loop)

    def watch_motion(self, robot: str, gate: SafetyGate, *, wheeled: bool = False) -> None:
        """Register the safety gate of a motion actuator without velocity motors, for `commanded`.

        Args:
            robot: Name of the robot.
            gate: Safety gate of its motion actuator.
            wheeled: Whether the robot has wheels; the vertical motion of other robots counts in contacts.
        """
        self._motion[robot] = gate
        if not wheeled:
            self._touch.spatial.add(robot)

    def guard(self, gate: SafetyGate) -> None:
        """Register a safety gate; its watchdog is then checked before each physics step."""
        self._gates.append(gate)

    def commanded(self, robot: str) -> bool:
        """Whether a robot is commanded to move: motors turn or brake, or the motion actuator has a command."""
        for m in self._motors[robot]:
            if not m.settled or any(m.target) or any(any(speeds) for _, speeds in m.coming):
                return True
        return robot in self._motion and self._motion[robot].active

    def advance(self, steps: int) -> None:
        """Advance the world by a number of physics steps.

        Raises:
            BlockError: The simulation has become unstable.
        """
        with self.lock:
            touch, data, model, step, now = self._touch, self.data, self.model, self._mj.mj_step, self.clock.now
            touch.begin(data)
            expiry = min([gate.expiry for gate in self._gates], default=math.inf)
            safe = self._simulated and now() + steps * self.step <= expiry
            for i in range(steps):
                if not safe and now() > expiry:
                    for gate in self._gates:
                        gate.check()
                for motors in self._late:
                    while motors.coming and motors.coming[0][0] <= self._steps:
                        self._aim(motors, motors.coming.popleft()[1])
                if self._ramping:
                    self._ramp()
                if self.objects:
                    data.mocap_pos += self._drift
                    if self._turns:
                        self._turn_objects()
                if self._pushes:
                    self._push()
                for loop in self._loops:
                    loop(self.stamp)
                step(model, data)
                self._steps += 1
                self._tick()
                if self._loops:
                    self.stamp = now()
                    self._revision += 1
                if i == steps - 1 or data.ncon != touch.usual:
                    touch.update(data, now(), self.commanded)
            self.stamp = now()
            self._revision += 1
            if any(self._bad):
                raise BlockError(
                    "physics", "raised", f"the simulation became unstable by {self.stamp:.2f} s: {_UNSTABLE}"
                )

    def contacts(self) -> list[Contact]:
        """Contacts that began since the last call; on the floor only those with side faces of its ground count."""
        with self.lock:
            return self._touch.drain()

    def allow_ground_contact(self, robot: str, names: Sequence[str]) -> None:
        """Set the geoms of a robot that may touch the ground; by default those that carry it in its model's pose.

        Args:
            robot: Name of the robot.
            names: Names of the geoms in the robot's model, without the robot's prefix.

        Raises:
            UnknownName: The robot's model has no such geom.
        """
        self.body(robot)
        self._touch.allow_ground(robot, [self._id("geom", robot, name) for name in names])

    def ground_contact(self, robot: str) -> str:
        """Name of a geom of a robot that touches the ground and should not; empty if there is none."""
        geom = self._touch.grounded.get(robot)
        if geom is None:
            return ""
        body = self.model.geom_bodyid[geom]
        return str(self.model.geom(geom).name or self.model.body(body).name).removeprefix(f"{robot}/")

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
        """Whether the line of sight between the bases of two robots is free, at a height over the floor [m]."""
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

    def _turn_objects(self) -> None:
        for slot, turn in self._turns.items():
            w, _, _, k = self.data.mocap_quat[slot].tolist()
            half = math.atan2(k, w) + 0.5 * turn
            self.data.mocap_quat[slot] = math.cos(half), 0.0, 0.0, math.sin(half)

    def _push(self) -> None:
        """Set the forces of the next physics step, through the origins of the bases."""
        data, pushes = self.data, self._pushes
        self._pushes = [push for push in pushes if self._steps < push[0]]
        for _, body, _ in pushes:
            data.xfrc_applied[body.root] = 0.0
        for _, body, force in self._pushes:
            arm = np.zeros(3)  # from the centre of mass to the origin of the base, world frame [m]
            self._mj.mju_rotVecQuat(arm, -self.model.body_ipos[body.root], data.qpos[body.q + 3 : body.q + 7])
            data.xfrc_applied[body.root, :3] += force
            data.xfrc_applied[body.root, 3:] += np.cross(arm, force)

    def _aim(self, motors: Motors, speeds: Sequence[float]) -> None:
        motors.target[:] = speeds
        if motors.settled:
            motors.settled = False
            self._ramping.append(motors)

    def _ramp(self) -> None:
        ctrl = self._ctrl
        for motors in self._ramping:
            motors.settled, change = True, motors.change
            for i, target in zip(motors.ids, motors.target, strict=True):
                now = ctrl[i]
                if abs(target - now) <= change:
                    ctrl[i] = target
                else:
                    ctrl[i] = now + math.copysign(change, target - now)
                    motors.settled = False
        self._ramping = [motors for motors in self._ramping if not motors.settled]

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
