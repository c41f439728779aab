"""Baselines of the follower benchmark: the reference problem's path and plant, pure pursuit, and an IPOPT NLP."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca
import numpy as np

from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.follower_qp import Weights
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.control.path import Path
from rocs_bt.control.profile import speed_profile
from rocs_bt.control.reference import PathReference

CRUISE, PERIOD, DT, STAGES = 0.7, 0.05, 0.1, 20
DRIVE = make_locomotion("differential", wheel_separation=0.33, max_wheel_speed=1.2, max_wheel_acceleration=1.5)
START = Pose2(0.25, 0.25, 0.3)


def corners() -> np.ndarray:
    """Reference path: a lemniscate of half-width 1.25 m, a straight, a right-angled corner, a straight [m]."""
    t = np.linspace(0.0, 2.0 * np.pi, 2000)
    loop = 1.25 * np.column_stack([np.sin(t), np.sin(t) * np.cos(t)])
    onward, left = np.array([1.0, 1.0]) / math.sqrt(2.0), np.array([-1.0, 1.0]) / math.sqrt(2.0)
    return np.vstack([loop, loop[-1] + 3.0 * onward, loop[-1] + 3.0 * onward + 5.0 * left])


def distance_to(line: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Exact distances [m] of points (k, 2) from a polyline (m, 2), segment by segment."""
    a, d = line[:-1], np.diff(line, axis=0)
    keep = (d**2).sum(axis=1) > 0.0
    a, d = a[keep], d[keep]
    out = np.empty(len(points))
    for i, p in enumerate(points):
        t = np.clip(((p - a) * d).sum(axis=1) / (d**2).sum(axis=1), 0.0, 1.0)
        out[i] = np.hypot(*(a + t[:, None] * d - p).T).min()
    return out


class Plant:
    """Plant with 40 ms wheel lag, 3 % yaw slip, commands clipped to the wheels' limits; not the follower's model."""

    def __init__(self) -> None:
        self.pose, self.wheels, self.command = START, np.zeros(2), np.zeros(2)

    def move(self, command: np.ndarray) -> None:
        reach = DRIVE.max_acceleration.min() * PERIOD
        self.command = np.clip(command, self.command - reach, self.command + reach)
        self.command = np.clip(self.command, -DRIVE.max_speed.min(), DRIVE.max_speed.min())
        for _ in range(10):
            self.wheels = self.wheels + (self.command - self.wheels) * (1.0 - math.exp(-0.1 * PERIOD / 0.04))
            v, turn = self.wheels.mean(), 0.97 * (self.wheels[1] - self.wheels[0]) / 0.33
            dt, (x, y, yaw) = 0.1 * PERIOD, self.pose
            middle = yaw + 0.5 * dt * turn
            self.pose = Pose2(
                x + dt * v * math.cos(middle),
                y + dt * v * math.sin(middle),
                math.remainder(yaw + dt * turn, math.tau),
            )


def anchored() -> PathReference:
    """Reference of both optimisers: the path at 0.7 m/s, sampled again each tick."""
    path = Path(corners())
    return PathReference(path, speed_profile(path, DRIVE, cruise=CRUISE))


class PurePursuit:
    """Pure pursuit (Coulter, Implementation of the pure pursuit path tracking algorithm, CMU-RI-TR-92-01, 1992)."""

    def __init__(self, look_ahead: float) -> None:
        self.path, self.look_ahead, self.s = Path(corners()), look_ahead, 0.0

    def __call__(self, pose: Pose2, command: np.ndarray) -> np.ndarray:
        self.s = self.path.project(pose.x, pose.y, self.s)
        x, y, _, _ = self.path.sample(self.s + self.look_ahead)
        dx, dy = x - pose.x, y - pose.y
        left = -math.sin(pose.yaw) * dx + math.cos(pose.yaw) * dy
        turn = CRUISE * 2.0 * left / max(dx * dx + dy * dy, 1e-9) if dx or dy else 0.0
        return DRIVE.saturate(DRIVE.command(Twist2(CRUISE, turn)))


class Nlp:
    """The same cost, model and limits as a nonlinear program over all 20 stages, solved by IPOPT each tick.

    Args:
        tuned: Whether to use a warm start, at most 15 iterations and a tolerance of 1e-3, instead of the defaults.
    """

    def __init__(self, tuned: bool) -> None:
        self.reference, self._times = anchored(), DT * np.arange(1, STAGES + 1)
        options: dict[str, Any] = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}}
        if tuned:
            options["ipopt"] |= {
                "max_iter": 15,
                "tol": 1e-3,
                "mu_init": 1e-3,
                "warm_start_init_point": "yes",
                "mu_strategy": "adaptive",
            }
        self._solver = ca.nlpsol("nlp", "ipopt", self._problem(), options)
        limit, gain = DRIVE.max_speed.min(), DRIVE.max_acceleration.min()
        states = np.tile([np.inf, np.inf, np.inf, limit, limit], STAGES)
        self._upper = np.concatenate([states, np.full(2 * STAGES, gain)])
        self._plan = np.zeros(7 * STAGES)

    def _problem(self) -> dict[str, Any]:
        states, inputs = ca.SX.sym("x", 5, STAGES), ca.SX.sym("u", 2, STAGES)
        start, wanted, weights = ca.SX.sym("s", 5), ca.SX.sym("r", 5, STAGES), Weights()
        before, cost, gaps = start, 0.0, []
        for k in range(STAGES):
            v, turn = self._motion(before[3:] + 0.5 * DT * inputs[:, k])
            middle = before[2] + 0.5 * DT * turn
            moved = ca.vertcat(v * ca.cos(middle), v * ca.sin(middle), turn, inputs[:, k])
            gaps.append(states[:, k] - before - DT * moved)
            before, factor = states[:, k], weights.terminal if k == STAGES - 1 else 1.0
            error = before - wanted[:, k]
            cost += factor * (weights.along * ca.sumsqr(error[:2]) + weights.heading * error[2] ** 2)
            cost += factor * weights.speed * ca.sumsqr(error[3:]) + weights.acceleration * ca.sumsqr(inputs[:, k])
        variables = ca.vertcat(ca.vec(states), ca.vec(inputs))
        return {"x": variables, "p": ca.vertcat(start, ca.vec(wanted)), "f": cost, "g": ca.vertcat(*gaps)}

    @staticmethod
    def _motion(wheels: Any) -> tuple[Any, Any]:
        return 0.5 * (wheels[0] + wheels[1]), (wheels[1] - wheels[0]) / 0.33

    def prepare(self, pose: Pose2, command: np.ndarray) -> np.ndarray:
        """Parameters of the next solve; not timed, as for the follower."""
        stages = self.reference.sample(pose, DRIVE.twist(command), self._times, 0.0).stages
        wanted = np.column_stack([stages[:, :3], stages[:, 3:] @ DRIVE.q_from_twist.T])
        return np.concatenate([pose, command, wanted.ravel()])

    def solve(self, p: np.ndarray, command: np.ndarray) -> np.ndarray:
        found = self._solver(x0=self._plan, p=p, lbx=-self._upper, ubx=self._upper, lbg=0.0, ubg=0.0)
        self._plan = np.asarray(found["x"]).ravel()
        return command + PERIOD * self._plan[5 * STAGES : 5 * STAGES + 2]
