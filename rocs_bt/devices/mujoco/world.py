"""MujocoWorld: the simulated world, a compiled model of an arena and robots that moves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base.clock import Clock, SimulatedClock
from ...base.errors import BlockError, DeviceError, Fault, InputError
from ...base.geometry import Pose2
from ...interfaces.safety_gate import SafetyGate
from .body import Controls, FreeBody, Motors, RobotElements
from .carrying_geoms import carrying_geoms
from .rays import Scan
from .state import WorldState
from .touch import Contact, ContactDetector

__all__ = ["Contact", "MujocoWorld"]

PROPELLED = 0.1
"""Mean speed of its wheels above which a robot moves by itself [m/s]."""

SETTLING = 0.5
"""Time after its last command in which a robot without wheels still moves by itself [s]."""

_UNSTABLE = (
    "MuJoCo found NaN, infinite or huge positions, velocities or accelerations. Use weaker forces, larger masses or a "
    "shorter physics step."
)


class MujocoWorld(WorldState):
    """Simulated world: an arena, robots and time in MuJoCo. `Scene` describes the members that it declares.

    Args:
        model: Compiled MjModel; elements of robots have the robot's name as prefix.
        robots: Names of the robots.
        clock: Clock of the world; a simulated clock is advanced by each physics step.
    """

    def __init__(self, model: Any, robots: Sequence[str], clock: Clock) -> None:
        super().__init__(model, robots, clock)
        self._ctrl: memoryview[float] = memoryview(self.data.ctrl)
        kinds = self._mj.mjtWarning
        bad = slice(int(kinds.mjWARN_BADQPOS), int(kinds.mjWARN_BADQACC) + 1)  # of positions, velocities, accelerations
        self._bad: memoryview[int] = memoryview(self.data.warning.number)[bad]
        self._drift = np.zeros((model.nmocap, 3))  # [m] displacements of scripted objects per physics step
        self._turns: dict[int, float] = {}  # [rad] turns of scripted objects per physics step, by slot
        self._pushes: list[tuple[int, RobotElements, npt.NDArray[np.float64]]] = []  # end [steps], robot, force [N]
        self._simulated = isinstance(clock, SimulatedClock)
        self._tick: Callable[[], None] = clock.advance if isinstance(clock, SimulatedClock) else lambda: None
        self._motors: dict[str, list[Motors]] = {name: [] for name in robots}
        self._late: list[Motors] = []  # motors with a delay
        self._steps = 0  # number of physics steps since the start
        self._ramping: list[Motors] = []  # motors that have not reached their targets
        self._gates: list[SafetyGate] = []
        self._loops: list[Callable[[float], None]] = []  # inner loops of actuators
        self._motion: dict[str, SafetyGate] = {}  # gates of robots' motion actuators without velocity motors
        self._active: dict[str, float] = {}  # [s] times at which these actuators last had a command
        self._touch = ContactDetector(model, self.robots, self.objects)
        for name, body in self.robots.items():
            self._touch.allow_ground(name, carrying_geoms(model, self.data, body))

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

    def velocity(self, name: str, at: npt.NDArray[np.float64] | None = None) -> npt.NDArray[np.float64]:
        """Horizontal velocity of a robot or an object, shape (2,), world frame [m/s].

        Args:
            name: Name of the robot or object.
            at: A point of a robot, shape (2,), world frame [m]; by default its base.
        """
        with self.lock:
            if (robot := self.robots.get(name)) is not None:
                x, y = self._qpos[robot.q : robot.q + 2]
                vx, vy, _, _, _, turn = self._qvel[robot.v : robot.v + 6].tolist()
                px, py = (x, y) if at is None else at
                return np.array([vx - turn * (py - y), vy + turn * (px - x)])
            body = self.objects[name]
            if isinstance(body, FreeBody):
                return np.array(self._qvel[body.v : body.v + 2])
            return self._drift[body.slot, :2] / self.step

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

    def motors(
        self,
        robot: str,
        names: Sequence[str],
        max_change: float = math.inf,
        delay: float = 0.0,
        radius: float = 1.0,
        slip: Sequence[float] = (),
    ) -> Motors:
        """Handle of velocity motors of the model, created once; limits and delay as of the actuator."""
        self.body(robot)
        late = round(delay / self.step)
        if abs(late * self.step - delay) > 1e-6 * self.step:
            near = f"{1e3 * self.step * late:g} ms"
            message = f"the delay of {robot}'s motors, {1e3 * delay:g} ms, is not a whole number of physics steps of "
            raise InputError(Fault(f"{message}{1e3 * self.step:g} ms.", hint=f"Use {near}."))
        ids = [self._id("actuator", robot, name) for name in names]
        turned = [int(self.model.actuator_trnid[i, 0]) for i in ids]
        joints, angles = ([int(adr[j]) for j in turned] for adr in (self.model.jnt_dofadr, self.model.jnt_qposadr))
        motors = Motors(ids, joints, angles, [0.0] * len(ids), max_change * self.step, delay=late, radius=radius)
        self._motors[robot].append(motors)
        if any(slip):
            self._grip |= {joint: 1.0 - slip[i % len(slip)] for i, joint in enumerate(joints)}
        if late:
            self._late.append(motors)
        return motors

    def scan(self, robot: str, site: str, bearings: Sequence[float], reach: float, sweep: float) -> Scan:
        """Scanner at a site, with rays at bearings [rad] up to `reach` [m]; a scan takes `sweep` [s]."""
        return Scan(self, robot, site, bearings, reach, sweep)

    def drive(self, motors: Motors, speeds: Sequence[float]) -> None:
        """Command the speeds of motors [rad/s], which are approached after the delay, at the maximum rate of change."""
        with self.lock:
            if self._grip:
                speeds = [s * self._grip.get(joint, 1.0) for s, joint in zip(speeds, motors.joints, strict=True)]
            if motors.delay:
                motors.coming.append((self._steps + motors.delay, speeds))
            else:
                self._aim(motors, speeds)

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

    def attach(self, loop: Callable[[float], None]) -> None:
        """Call a function before each physics step with the time [s], in the order of attachment, with `lock` held.

        The function reads the present state, also the pose of a robot and `stamp`.
        """
        self._loops.append(loop)

    def watch_motion(self, robot: str, gate: SafetyGate) -> None:
        """Register the safety gate of a motion actuator without velocity motors, for `commanded` and `propelled`."""
        self._motion[robot] = gate

    def guard(self, gate: SafetyGate) -> None:
        """Register a safety gate; its watchdog is then checked before each physics step."""
        self._gates.append(gate)

    def commanded(self, robot: str) -> bool:
        """Whether a robot is commanded to move: motors turn or brake, or the motion actuator has a command."""
        for m in self._motors[robot]:
            if not m.settled or any(m.target) or any(any(speeds) for _, speeds in m.coming):
                return True
        return robot in self._motion and self._motion[robot].active

    def propelled(self, robot: str) -> bool:
        """Whether a robot moved by itself before the last step.

        Its wheels turned, or its motion actuator had a command until just now.
        """
        if motors := self._motors[robot]:
            speeds = [m.radius * abs(self._touch.before[j]) for m in motors for j in m.joints]
            return bool(sum(speeds) > PROPELLED * len(speeds))
        return self.stamp - self._active.get(robot, -math.inf) <= SETTLING

    def advance(self, steps: int) -> None:
        """Advance the world by a number of physics steps.

        Raises:
            BlockError: The simulation has become unstable.
        """
        with self.lock:
            touch, data, model, step, now = self._touch, self.data, self.model, self._mj.mj_step, self.clock.now
            self._active |= {robot: self.stamp for robot, gate in self._motion.items() if gate.active}
            expiry = min([gate.expiry for gate in self._gates], default=math.inf)
            safe = self._simulated and now() + steps * self.step <= expiry
            for i in range(steps):
                if not safe and now() > expiry:
                    for gate in self._gates:
                        gate.check()
                if self._past.maxlen:
                    self._past.append((data.qpos.copy(), data.mocap_pos.copy(), data.mocap_quat.copy()))
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
                touch.begin(self._qvel)
                step(model, data)
                self._steps += 1
                self._tick()
                if self._loops:
                    self.stamp = now()
                    self._revision += 1
                if i == steps - 1 or data.ncon != touch.usual:
                    touch.update(data, now(), self.propelled)
            self.stamp = now()
            self._revision += 1
            if any(self._bad):
                raise BlockError(
                    "physics", "raised", f"the simulation became unstable by {self.stamp:.2f} s: {_UNSTABLE}"
                )

    def add_part(self, name: str, whole: str) -> None:
        """Declare an object to be a part of another, such as a leg of a person, which contacts are counted with."""
        self.parts.add(name)
        self._touch.join(self.mocap_body(name).geoms, whole)

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
