"""Quadratic program of the follower: linearised, condensed, move-blocked, and solved in one CasADi Function.

The plan consists of the coordinates q of the motion at the ends of a few blocks, with linear interpolation between
them. The speed limits of a command's values are bounds at the block ends, the acceleration limits are constraints on
neighbours; both are exact. A braking plan from the commanded speed always exists, so the program is feasible by
construction.

The condensing uses the group structure of planar motions. The discretised pose moves by
p+ = p + dt R(yaw + dt w / 2) v, which commutes with rigid motions of the world. A small change of q during stage j
therefore changes every later pose by the same *spatial* twist (c, t): dp_k = c + J p_k t, dyaw_k = t, with J the
quarter turn. After the end of a block its sensitivity is constant, and a Hessian block between two settled variables is
one product of 3-vectors. The work is linear in the horizon instead of quadratic.

Sources: Gros et al., From linear to nonlinear MPC: bridging the gap via the real-time iteration, Int. J. Control
93(1), 2020; Frison, Algorithms and methods for high-performance MPC, 2015 (condensing); Arnstrom, Bemporad and
Axehill, A dual active-set solver for embedded quadratic programming, IEEE TAC 67(8), 2022 (DAQP); Lynch and Park,
Modern Robotics, 2017, 3.3.2 (spatial twists).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError
from .locomotion import Array, Locomotion


@dataclass(frozen=True)
class Weights:
    """Weights of the squared errors, summed over the stages.

    Attributes:
        along: Weight of the position error along the reference's heading [1/m2].
        across: Weight of the position error across the reference's heading [1/m2].
        heading: Weight of the heading error [1/rad2].
        speed: Weight of the difference of a command's values, such as wheel speeds, from the reference [s2/m2].
        acceleration: Weight of the rates of change of these values [s4/m2].
        terminal: Factor on the last stage, instead of a terminal set [1].
    """

    along: float = 20.0
    across: float = 20.0
    heading: float = 1.0
    speed: float = 0.2
    acceleration: float = 0.02
    terminal: float = 5.0


@dataclass(frozen=True, eq=False)
class Layout:
    """Sizes and constant matrices of the quadratic program.

    Attributes:
        locomotion: Locomotion with its limits.
        blocks: Lengths of the move blocks, in stages.
        dt: Duration of a stage [s].
    """

    locomotion: Locomotion
    blocks: tuple[int, ...]
    dt: float

    def __post_init__(self) -> None:
        if not self.blocks or any(b < 1 for b in self.blocks) or not self.dt > 0.0:
            raise InputError(
                f"a plan needs blocks of 1 or more stages of positive length, found {self.blocks}, {self.dt} s."
            )

    @cached_property
    def _content(self) -> tuple[object, ...]:
        """All data that determine the program, for equality and hash."""
        locomotion = self.locomotion
        arrays = (locomotion.twist_from_q, locomotion.values_from_q, locomotion.max_speed, locomotion.max_acceleration)
        return tuple((a.shape, a.tobytes()) for a in arrays), self.blocks, self.dt

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Layout) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @property
    def n(self) -> int:
        """Number of coordinates q."""
        return int(self.locomotion.twist_from_q.shape[1])

    @property
    def stages(self) -> int:
        """Number of stages of the horizon."""
        return sum(self.blocks)

    @property
    def size(self) -> int:
        """Number of variables of the program."""
        return self.n * len(self.blocks)

    @cached_property
    def ends(self) -> Array:
        """Times of the plan's nodes: now (0) and the end of each block, shape (blocks + 1,) [s]."""
        return self.dt * np.concatenate([[0.0], np.cumsum(self.blocks)])

    @cached_property
    def _distinct(self) -> list[int]:
        """Indices of the r values of a command that depend on q and are not limited like an earlier one."""
        loco, kept = self.locomotion, list[int]()
        for i, row in enumerate(loco.values_from_q):
            same = (
                k for k in kept if np.allclose(row, loco.values_from_q[k]) or np.allclose(row, -loco.values_from_q[k])
            )
            limits = [(loco.max_speed[k], loco.max_acceleration[k]) for k in same]
            if row.any() and (loco.max_speed[i], loco.max_acceleration[i]) not in limits:
                kept.append(i)
        return kept

    @cached_property
    def rows(self) -> Array:
        """Matrix from the coordinates q to the r distinct values of a command, shape (r, n)."""
        return np.asarray(self.locomotion.values_from_q[self._distinct])

    @property
    def speeds(self) -> Array:
        """Speed limits of the distinct values, shape (r,)."""
        return np.asarray(self.locomotion.max_speed[self._distinct])

    @cached_property
    def speed_rows(self) -> Array:
        """Matrix from (present q, plan) to values as shares of their limits, shape (r * blocks, size + n)."""
        pick = np.eye(len(self.blocks) + 1)[1:]
        limits = np.tile(self.speeds, len(self.blocks))[:, None]
        return np.asarray(np.kron(pick, self.rows) / limits, dtype=float)

    @cached_property
    def acceleration_rows(self) -> Array:
        """Matrix from (present q, plan) to accelerations as shares of their limits, shape (r * blocks, size + n)."""
        differences = np.diff(np.eye(len(self.blocks) + 1), axis=0) / np.diff(self.ends)[:, None]
        limits = np.tile(self.locomotion.max_acceleration[self._distinct], len(self.blocks))[:, None]
        return np.asarray(np.kron(differences, self.rows) / limits, dtype=float)

    def interpolation(self, times: npt.NDArray[np.floating[Any]]) -> Array:
        """Interpolation weights of the nodes at times (k,) [s], constant after the last, shape (k, blocks + 1)."""
        unit = np.eye(len(self.ends))
        return np.column_stack([np.interp(times, self.ends, column) for column in unit])


@lru_cache(maxsize=32)  # building takes as long as a hundred solves
def build(layout: Layout, weights: Weights, iterations: int) -> Any:
    """Build the program as a CasADi Function of one vector; equal arguments return the same Function.

    The input vector is: pose (3,), present q (n,), the plan to linearise at (blocks * n,), and the reference x, y, yaw
    and q of each stage (stages * (3 + n)). The output is the new plan (blocks * n,). The Function does not report
    whether the solver succeeded: check the plan. The plan of a solve truncated after `iterations` violates limits.
    """
    import casadi as ca

    p = ca.SX.sym("p", 3 + layout.n + layout.size + layout.stages * (3 + layout.n))
    hessian, gradient, now, plan = _linearise(ca, layout, weights, p)
    boxed = layout.rows.shape == (layout.n, layout.n) and np.array_equal(layout.rows, np.eye(layout.n))
    rows = layout.acceleration_rows if boxed else np.vstack([layout.acceleration_rows, layout.speed_rows])
    offset = ca.DM(rows) @ ca.vertcat(now, plan)
    free = ca.DM(rows[:, layout.n :])
    speed = ca.DM(np.tile(layout.speeds, len(layout.blocks))) if boxed else np.inf
    bounds = [-speed - plan, speed - plan, -1.0 - offset, 1.0 - offset]
    linearise = ca.Function("linearise", [p], [hessian, gradient, *bounds], {"cse": True})
    shape = {"h": hessian.sparsity(), "a": free.sparsity()}
    quiet: dict[str, Any] = {"error_on_fail": False, "daqp": {"iter_limit": iterations}}
    solver = ca.conic("solver", "daqp", shape, quiet)
    x = ca.MX.sym("p", p.shape[0])
    h, g, lbx, ubx, lba, uba = linearise(x)
    step = solver(h=h, g=g, a=free, lbx=lbx, ubx=ubx, lba=lba, uba=uba)["x"]
    start = 3 + layout.n
    return ca.Function("follow", [x], [x[start : start + layout.size] + step])


def _linearise(ca: Any, layout: Layout, weights: Weights, p: Any) -> tuple[Any, Any, Any, Any]:
    """Hessian, gradient, present q and plan to linearise at, as expressions of the input vector p."""
    n, size = layout.n, layout.size
    now, plan = p[3 : 3 + n], p[3 + n : 3 + n + size]
    wanted = ca.reshape(p[3 + n + size :], 3 + n, layout.stages)
    nodes = ca.horzcat(now, ca.reshape(plan, n, len(layout.blocks)))
    hessian, gradient = _speed_cost(ca, layout, weights, nodes, wanted)
    pose_hessian, pose_gradient = _pose_cost(ca, layout, weights, p[:3], nodes, wanted)
    return hessian + pose_hessian, gradient + pose_gradient, now, plan


def _speed_cost(ca: Any, layout: Layout, weights: Weights, nodes: Any, wanted: Any) -> tuple[Any, Any]:
    """Hessian and gradient of the exactly quadratic cost: values at stage ends, and their rates of change."""
    rows = layout.rows * (layout.speeds[0] / layout.speeds)[:, None]  # limits weigh turn rates like speeds
    metric = rows.T @ rows * (layout.n / len(rows))
    ends = layout.interpolation(layout.dt * np.arange(1, layout.stages + 1))
    worth = np.full(layout.stages, weights.speed)
    worth[-1] *= weights.terminal
    lengths = np.array(layout.blocks, dtype=float)
    slopes = np.diff(np.eye(len(layout.ends)), axis=0) / np.diff(layout.ends)[:, None]
    curvature = ends.T @ (worth[:, None] * ends) + weights.acceleration * slopes.T @ (lengths[:, None] * slopes)
    pull = nodes @ ca.DM(curvature[:, 1:]) - wanted[3:, :] @ ca.DM(worth[:, None] * ends[:, 1:])
    return ca.DM(np.kron(curvature[1:, 1:], metric)), ca.vec(ca.DM(metric) @ pull)


def _pose_cost(ca: Any, layout: Layout, weights: Weights, pose: Any, nodes: Any, wanted: Any) -> tuple[Any, Any]:
    """Gauss-Newton Hessian and gradient of the pose errors, with respect to the plan."""
    twists, metrics, pulls = _roll_out(ca, layout, weights, pose, nodes, wanted)
    for k in reversed(range(layout.stages - 1)):  # cost of a spatial twist at stage k in all later stages
        metrics[k] = metrics[k] + metrics[k + 1]
        pulls[k] = pulls[k] + pulls[k + 1]
    middles = layout.interpolation(layout.dt * (np.arange(layout.stages) + 0.5))[:, 1:]
    supports = [np.flatnonzero(middles[:, b]) for b in range(len(layout.blocks))]
    weighted = [metrics[k] @ twists[k] for k in range(layout.stages)]  # (3, n) each
    own = [twists[k].T @ weighted[k] for k in range(layout.stages)]

    def total(terms: list[Any], b: int) -> Any:
        return sum(float(middles[k, b]) * terms[k] for k in supports[b])

    settled = [total(twists, b) for b in range(len(layout.blocks))]
    forces = [total(weighted, b) for b in range(len(layout.blocks))]
    gradient = [sum(float(middles[k, b]) * (twists[k].T @ pulls[k]) for k in supports[b]) for b in range(len(supports))]
    hessian = [[None] * len(supports) for _ in supports]
    for a, b in combinations_with_replacement(range(len(supports)), 2):
        if supports[a][-1] < supports[b][0]:
            block = settled[a].T @ forces[b]
        else:
            block = _overlap(ca, twists, weighted, own, middles[:, a].tolist(), middles[:, b].tolist())
        hessian[a][b], hessian[b][a] = block, block.T
    return ca.vertcat(*(ca.horzcat(*row) for row in hessian)), ca.vertcat(*gradient)


def _overlap(ca: Any, twists: list[Any], weighted: list[Any], own: list[Any], a: list[float], b: list[float]) -> Any:
    """Hessian block (n, n) of a variable with itself or with a later one that shares stages with it."""
    acted_a = acted_b = tail = ca.SX(*twists[0].shape)
    block = ca.SX(*own[0].shape)
    for k, (share_a, share_b) in enumerate(zip(a, b, strict=True)):
        if any(a[k:]):
            block = block + share_a * share_b * own[k] + share_b * (acted_a.T @ weighted[k])
            block = block + share_a * (acted_b.T @ weighted[k]).T
        else:
            tail = tail + share_b * weighted[k]
        acted_a, acted_b = acted_a + share_a * twists[k], acted_b + share_b * twists[k]
    return block + acted_a.T @ tail


def _roll_out(ca: Any, layout: Layout, weights: Weights, pose: Any, nodes: Any, wanted: Any) -> tuple[Any, Any, Any]:
    """Spatial twist of q (3, n), metric (3, 3) and pull (3, 1) of the pose error at the end of each stage.

    Positions are relative to the robot, so numbers stay small in a large world.
    """
    linear, turn = ca.DM(layout.locomotion.twist_from_q[:2]), ca.DM(layout.locomotion.twist_from_q[2:])
    middles = nodes @ ca.DM(layout.interpolation(layout.dt * (np.arange(layout.stages) + 0.5)).T)
    at, yaw = ca.SX(2, 1), pose[2]
    twists, metrics, pulls = [], [], []
    for k in range(layout.stages):
        q = middles[:, k]
        half = 0.5 * layout.dt * (turn @ q)
        c, s = ca.cos(yaw + half), ca.sin(yaw + half)
        rotated = ca.vertcat(ca.horzcat(c, -s), ca.horzcat(s, c)) @ linear  # (2, n)
        moved = layout.dt * (rotated @ q)
        middle = at + 0.5 * moved
        spun = ca.vertcat(middle[1], -middle[0]) @ turn  # -J middle, for each coordinate's turn
        twists.append(layout.dt * ca.vertcat(rotated + spun, turn))
        at, yaw = at + moved, yaw + 2.0 * half
        factor = weights.terminal if k == layout.stages - 1 else 1.0
        metric, pull = _pose_error(ca, weights, factor, at, yaw, wanted[:3, k], pose)
        metrics.append(metric)
        pulls.append(pull)
    return twists, metrics, pulls


def _pose_error(ca: Any, weights: Weights, factor: float, at: Any, yaw: Any, wanted: Any, pose: Any) -> tuple[Any, Any]:
    """Metric (3, 3), the Gauss-Newton Hessian, and pull (3, 1), the gradient, of one pose error for spatial twists."""
    c, s = ca.cos(wanted[2]), ca.sin(wanted[2])
    more = factor * (weights.along - weights.across)
    metric = factor * weights.across * ca.DM.eye(2) + more * ca.vertcat(c, s) @ ca.horzcat(c, s)
    spin = ca.vertcat(-at[1], at[0])  # J p: velocity of the position under a rotation of the world about the origin
    position = metric @ (at - (wanted[:2] - pose[:2]))
    heading = factor * weights.heading * (yaw - wanted[2])
    lever = metric @ spin
    full = ca.vertcat(ca.horzcat(metric, lever), ca.horzcat(lever.T, spin.T @ lever + factor * weights.heading))
    return full, ca.vertcat(position, spin.T @ position + heading)
