"""Flight controller of the quadrotor: twists to rotor thrusts, at the rate of the physics.

Velocity and position loops give a desired acceleration; the thrust axis is turned to it by a geometric attitude loop.
Source of the attitude loop: Lee, Leok and McClamroch, Geometric tracking control of a quadrotor UAV on SE(3), CDC 2010,
here with the error of the thrust axis apart from that of the yaw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rocs_bt import Metres
from rocs_bt.devices.mujoco import MujocoActuator

GRAVITY = 9.81  # [m/s2]
MAX_TILT = math.tan(math.radians(20.0))  # tangent of the maximum tilt that is commanded
MAX_CHANGE = 3.0  # [m/s2, rad/s2] maximum rate of change of the velocity that is tracked
SPEED_UP = 1.2  # [m/s2] the same in the plane while it becomes faster, as after a take-off
SMOOTH = 0.05  # [s] time constant with which a command is smoothed: one control period
VELOCITY_GAIN, POSITION_GAIN = 3.0, 1.5  # [1/s]
WIND_GAIN, MAX_WIND = 1.5, 2.0  # [1/s2], [m/s2] integral of the velocity error, against wind and a wrong mass
ATTITUDE_RATE, ATTITUDE_DAMPING = 12.0, 0.9  # [rad/s], [1] of the closed attitude loop
YAW_RATE = 5.0  # [rad/s] of the closed yaw loop, critically damped
MAX_YAW_ERROR, MAX_YAW_TORQUE = 0.3, 0.1  # [rad], [N m] so that the rotors keep their thrust for roll and pitch
SLOW = 0.08  # [m/s] speed below which a body that is commanded to rest holds its position
TAKE_OFF_SPEED = 0.5  # [m/s]
REACHED = 0.03  # [m] height that is left when the take-off ends
TOUCHED = 0.25  # [s] duration of a descent without motion after which it has landed


class Rotors(MujocoActuator):
    """Body twists: forward, left, up [m/s] and turn [rad/s].

    The rotors are off on the ground. The first command to move starts a take-off; the body moves in the plane after it.
    A command to rest pauses the take-off.
    Commanded to rest, it holds position, height and yaw. It stops the rotors when a descent ends on something solid.

    Attributes:
        take_off_height: Height of the hover after a take-off, above the place of the take-off [m].
        arm: Distance from the centre to the axis of a rotor [m].
        torque_ratio: Torque of a rotor per thrust [m].
    """

    size = 4
    take_off_height: Metres
    arm: Metres
    torque_ratio: Metres

    def set_up(self) -> None:
        """Find the body and the rotors in the model."""
        world, robot = self.world, self.robot
        model, data = world.model, world.data
        joint, base = model.joint(f"{robot}/base"), model.body(f"{robot}/base")
        q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._q, self._v = memoryview(data.qpos)[q : q + 7], memoryview(data.qvel)[v : v + 6]
        self._rotors = world.controls(robot, ["front", "left", "back", "right"])
        self._step = world.step
        self._mass = float(model.body_subtreemass[base.id])
        self._inertia, self._yaw_inertia = float(base.inertia[0]), float(base.inertia[2])
        self._most = float(self._rotors.high[0])
        self._wanted = [0.0] * 4
        self._flies = self._takes_off = False
        self._top = 0.0  # [m] height at the end of the take-off
        self._x = self._y = self._z = self._yaw = 0.0  # pose to hold, and the yaw that is tracked [m, rad]
        self._holds = self._keeps_height = False
        self._touched = 0.0  # [s] duration of a descent without motion
        self._tracked = [0.0] * 4  # velocity along x, y, z [m/s] and turn rate [rad/s], world frame
        self._wind = [0.0] * 3  # acceleration against wind [m/s2]

    def command(self, values: Sequence[float]) -> None:
        self._wanted = list(values)

    def neutral(self) -> None:
        self._wanted = [0.0] * 4
        self._takes_off = False  # it hovers at the height that it has reached

    def before_step(self, t: float) -> None:
        """Compute the thrusts of the four rotors for the next physics step."""
        x, y, z, w, i, j, k = self._q.tolist()
        yaw = math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))
        if not self._flies and not self._starts((x, y, z), yaw):
            return
        forward, left, up, turn = self._wanted
        if self._takes_off and any(self._wanted):
            forward = left = turn = 0.0
            up = self._rise(z)
        c, s = math.cos(yaw), math.sin(yaw)
        wanted = forward * c - left * s, forward * s + left * c, up, turn
        vx, vy, vz, *turning = self._v.tolist()
        acceleration = self._acceleration(wanted, (x, y, z), (vx, vy, vz))
        if self._touches(up, vz):
            self._stop()
        else:
            thrusts = self._thrusts((w, i, j, k), yaw, turning, acceleration, self._follow(3, turn))
            self.world.set_controls(self._rotors, thrusts)

    def _rise(self, z: float) -> float:
        """Vertical speed of the take-off [m/s]; at its end, the commanded one."""
        left = self._top - z
        if left > REACHED:
            return min(TAKE_OFF_SPEED, POSITION_GAIN * left)
        self._takes_off, self._keeps_height, self._z = False, True, self._top
        return self._wanted[2]

    def _acceleration(
        self, wanted: Sequence[float], position: Sequence[float], velocity: Sequence[float]
    ) -> tuple[float, float, float]:
        """Acceleration, without gravity, that leads to the velocity; at rest, to the position to hold.

        Args:
            wanted: Commanded velocity along x, y, z [m/s] and turn rate, world frame.
            position: x, y, z [m].
            velocity: Velocity along x, y, z [m/s].

        Returns:
            Acceleration along x, y, z, world frame [m/s2].
        """
        (x, y, z), (vx, vy, vz), tracked = position, velocity, self._tracked
        ax, ay, az = self._follow(0, wanted[0]), self._follow(1, wanted[1]), self._follow(2, wanted[2])
        ex, ey, ez = tracked[0] - vx, tracked[1] - vy, tracked[2] - vz
        if wanted[0] != 0.0 or wanted[1] != 0.0:
            self._holds = False
        elif self._holds or math.hypot(vx, vy) < SLOW:
            if not self._holds:
                self._holds, self._x, self._y = True, x, y
            ex += POSITION_GAIN * max(-0.5, min(0.5, self._x - x))
            ey += POSITION_GAIN * max(-0.5, min(0.5, self._y - y))
        if wanted[2] != 0.0:
            self._keeps_height = False
        elif self._keeps_height or abs(vz) < SLOW:
            if not self._keeps_height:
                self._keeps_height, self._z = True, z
            ez += POSITION_GAIN * max(-0.5, min(0.5, self._z - z))
        wind, gain = self._wind, WIND_GAIN * self._step
        wind[0] = max(-MAX_WIND, min(MAX_WIND, wind[0] + gain * ex))
        wind[1] = max(-MAX_WIND, min(MAX_WIND, wind[1] + gain * ey))
        wind[2] = max(-MAX_WIND, min(MAX_WIND, wind[2] + gain * ez))
        az += VELOCITY_GAIN * ez + wind[2]
        return ax + VELOCITY_GAIN * ex + wind[0], ay + VELOCITY_GAIN * ey + wind[1], max(-4.0, min(4.0, az))

    def _thrusts(
        self,
        attitude: Sequence[float],
        yaw: float,
        turning: Sequence[float],
        acceleration: Sequence[float],
        turn_change: float,
    ) -> tuple[float, float, float, float]:
        """Thrusts of the rotors front, left, back, right for an acceleration [N].

        Args:
            attitude: Quaternion w, x, y, z of the body.
            yaw: Yaw of the body [rad].
            turning: Turn rates of the body, body frame [rad/s].
            acceleration: Desired acceleration along x, y, z, without gravity, world frame [m/s2].
            turn_change: Desired rate of change of the turn rate [rad/s2].
        """
        (w, i, j, k), (ax, ay, az) = attitude, acceleration
        az += GRAVITY
        across, most = math.hypot(ax, ay), MAX_TILT * az
        if across > most:
            ax, ay = ax * most / across, ay * most / across
        size = math.sqrt(ax * ax + ay * ay + az * az)
        # Error of the thrust axis: its cross product with the desired one, in the body frame.
        zx, zy, zz = 2.0 * (i * k + w * j), 2.0 * (j * k - w * i), 1.0 - 2.0 * (i * i + j * j)
        nx, ny, nz = (zy * az - zz * ay) / size, (zz * ax - zx * az) / size, (zx * ay - zy * ax) / size
        roll = (1.0 - 2.0 * (j * j + k * k)) * nx + 2.0 * (i * j + w * k) * ny + 2.0 * (i * k - w * j) * nz
        pitch = 2.0 * (i * j - w * k) * nx + (1.0 - 2.0 * (i * i + k * k)) * ny + 2.0 * (j * k + w * i) * nz
        stiff, damped = ATTITUDE_RATE * ATTITUDE_RATE, 2.0 * ATTITUDE_DAMPING * ATTITUDE_RATE
        x_part = 0.5 * self._inertia * (stiff * roll - damped * turning[0]) / self.arm
        y_part = 0.5 * self._inertia * (stiff * pitch - damped * turning[1]) / self.arm
        z_part = 0.25 * self._yaw_torque(yaw, turning[2], turn_change) / self.torque_ratio
        # The mean thrust is limited so that roll and pitch keep their differences.
        mean = 0.25 * self._mass * (ax * zx + ay * zy + az * zz)
        mean = max(0.05 * self._most, min(0.85 * self._most, mean))
        return mean - y_part + z_part, mean + x_part - z_part, mean + y_part + z_part, mean - x_part - z_part

    def _yaw_torque(self, yaw: float, rate: float, change: float) -> float:
        """Torque for the yaw and the turn rate [N m], within what leaves room for roll and pitch."""
        spin = self._tracked[3]
        self._yaw += spin * self._step
        off = math.remainder(self._yaw - yaw, math.tau)
        if abs(off) > MAX_YAW_ERROR:
            off = math.copysign(MAX_YAW_ERROR, off)
            self._yaw = yaw + off
        torque = self._yaw_inertia * (change + YAW_RATE * (YAW_RATE * off + 2.0 * (spin - rate)))
        return max(-MAX_YAW_TORQUE, min(MAX_YAW_TORQUE, torque))

    def _touches(self, up: float, climb: float) -> bool:
        """Whether a commanded descent has ended on something solid."""
        descent = self._tracked[2]
        descends = up < -0.1 or descent < -0.1
        self._touched = self._touched + self._step if descends and climb > 0.3 * descent else 0.0
        return self._touched > TOUCHED

    def _starts(self, position: Sequence[float], yaw: float) -> bool:
        """Whether a body on the ground is commanded to move, but not down only; it then begins its take-off."""
        forward, left, up, turn = self._wanted
        if up < 0.0 or forward == left == up == turn == 0.0:
            return False
        self._flies = self._takes_off = True
        self._top = position[2] + self.take_off_height
        self._begin(position, yaw)
        return True

    def _stop(self) -> None:
        """Stop the rotors after the touchdown."""
        self._flies = self._takes_off = False
        self.world.set_controls(self._rotors, (0.0, 0.0, 0.0, 0.0))

    def _begin(self, position: Sequence[float], yaw: float) -> None:
        """Reset the loops at a pose."""
        self._x, self._y, self._z = position
        self._yaw, self._touched = yaw, 0.0
        self._holds = self._keeps_height = False
        self._tracked, self._wind = [0.0] * 4, [0.0] * 3

    def _follow(self, axis: int, wanted: float) -> float:
        """Move the tracked velocity of an axis toward the desired one; returns its rate of change [m/s2, rad/s2]."""
        change = (wanted - self._tracked[axis]) / SMOOTH
        most = SPEED_UP if axis < 2 and change * self._tracked[axis] >= 0.0 else MAX_CHANGE
        change = max(-most, min(most, change))
        self._tracked[axis] += change * self._step
        return change
