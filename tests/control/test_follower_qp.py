"""The quadratic program against an independent roll-out in plain numpy and general-purpose solvers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import LinearConstraint, minimize

from rocs_bt.base.errors import InputError
from rocs_bt.control.follower_qp import Layout, Weights, build
from rocs_bt.control.locomotion import Locomotion

Array = npt.NDArray[np.float64]
BLOCKS, DT = (1, 1, 2, 3), 0.1
WEIGHTS = Weights(along=11.0, across=23.0, heading=1.3, speed=0.2, acceleration=0.02, terminal=5.0)


class Problem:
    """One random tracking problem, stated without any of the product's matrices but the drive's."""

    def __init__(self, drive: Locomotion, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.locomotion, self.n = drive, drive.twist_from_q.shape[1]
        self.pose = np.array([30.0, -20.0, 1.0]) + rng.normal(0.0, 0.5, 3)
        self.q = drive.coordinates(drive.saturate(drive.values_from_q @ rng.normal(0.0, 0.5, self.n)))
        count = sum(BLOCKS)
        yaw = self.pose[2] + rng.normal(0.0, 0.5) + np.linspace(0.0, 0.8, count)
        way = np.cumsum(0.07 * np.column_stack([np.cos(yaw), np.sin(yaw)]), axis=0)
        start = self.pose[:2] + rng.normal(0.0, 0.15, 2)
        self.wanted = np.column_stack([start + way, yaw, rng.normal(0.3, 0.1, (count, self.n))])
        self.linearised_at = np.tile(self.q, len(BLOCKS)) + rng.normal(0.0, 0.05, self.n * len(BLOCKS))

    def residuals(self, plan: Array) -> Array:
        """The square roots of all terms of the cost."""
        rows = np.unique(self.locomotion.values_from_q, axis=0)
        scale = np.sqrt(self.n / len(rows))
        nodes = np.vstack([self.q, plan.reshape(-1, self.n)])
        x, y, yaw = self.pose
        terms, q, stage = [], self.q, 0
        for b, length in enumerate(BLOCKS):
            slope = (nodes[b + 1] - nodes[b]) / (length * DT)
            for _ in range(length):
                forward, left, turn = self.locomotion.twist_from_q @ (q + 0.5 * DT * slope)
                middle = yaw + 0.5 * DT * turn
                x += DT * (np.cos(middle) * forward - np.sin(middle) * left)
                y += DT * (np.sin(middle) * forward + np.cos(middle) * left)
                yaw, q = yaw + DT * turn, q + DT * slope
                wanted = self.wanted[stage]
                factor = np.sqrt(WEIGHTS.terminal if stage == sum(BLOCKS) - 1 else 1.0)
                c, s, ex, ey = np.cos(wanted[2]), np.sin(wanted[2]), x - wanted[0], y - wanted[1]
                terms += [
                    [factor * np.sqrt(WEIGHTS.along) * (c * ex + s * ey)],
                    [factor * np.sqrt(WEIGHTS.across) * (c * ey - s * ex)],
                    [factor * np.sqrt(WEIGHTS.heading) * (yaw - wanted[2])],
                    factor * np.sqrt(WEIGHTS.speed) * scale * (rows @ (q - wanted[3:])),
                    np.sqrt(WEIGHTS.acceleration) * scale * (rows @ slope),
                ]
                stage += 1
        return np.concatenate(terms)

    def limits(self) -> LinearConstraint:
        """Wheel speeds at the block ends and accelerations in between."""
        wheels, count = self.locomotion.values_from_q, len(BLOCKS)
        speed = np.kron(np.eye(count), wheels)
        change = np.eye(count) - np.eye(count, k=-1)
        acceleration = np.kron(change / (np.array(BLOCKS)[:, None] * DT), wheels)
        offset = np.zeros(len(acceleration))
        offset[: len(wheels)] = wheels @ self.q / (BLOCKS[0] * DT)
        a, v = self.locomotion.max_acceleration.min(), self.locomotion.max_speed.min()
        low = np.concatenate([np.full(len(speed), -v), offset - a])
        high = np.concatenate([np.full(len(speed), v), offset + a])
        return LinearConstraint(np.vstack([speed, acceleration]), low, high)

    def solve(self, program: Any, linearised_at: Array) -> Array:
        """The product's answer."""
        p = np.concatenate([self.pose, self.q, linearised_at, self.wanted.ravel()])
        return np.asarray(program(p)).ravel()


def jacobian(problem: Problem, plan: Array) -> Array:
    h = 1e-6
    columns = [problem.residuals(plan + h * e) - problem.residuals(plan - h * e) for e in np.eye(len(plan))]
    return np.column_stack(columns) / (2.0 * h)


def oracle(cost: Any, gradient: Any, start: Array, limits: LinearConstraint) -> Array:
    options = {"ftol": 1e-13, "maxiter": 500}
    found = minimize(cost, start, jac=gradient, constraints=[limits], method="SLSQP", options=options)
    return np.asarray(found.x)


@pytest.mark.parametrize("seed", range(4))
def test_one_solve_is_the_best_step_of_the_linearised_problem(any_drive: Locomotion, seed: int) -> None:
    problem = Problem(any_drive, seed)
    plan = problem.solve(build(Layout(any_drive, BLOCKS, DT), WEIGHTS, 200), problem.linearised_at)
    r, j, at = problem.residuals(problem.linearised_at), jacobian(problem, problem.linearised_at), problem.linearised_at

    def cost(z: Array) -> float:
        return float(np.sum((r + j @ (z - at)) ** 2))

    def gradient(z: Array) -> Array:
        return 2.0 * j.T @ (r + j @ (z - at))

    best = oracle(cost, gradient, np.tile(problem.q, len(BLOCKS)), problem.limits())
    assert cost(plan) == pytest.approx(cost(best), rel=1e-5)
    np.testing.assert_allclose(plan, best, atol=2e-3)
    limits = problem.limits()
    assert (limits.A @ plan <= limits.ub + 1e-6).all()
    assert (limits.A @ plan >= limits.lb - 1e-6).all()


def test_the_limits_matter_in_these_problems(drive: Locomotion) -> None:
    program = build(Layout(drive, BLOCKS, DT), WEIGHTS, 200)
    active = 0
    for seed in range(4):
        problem = Problem(drive, seed)
        limits = problem.limits()
        used = limits.A @ problem.solve(program, problem.linearised_at)
        active += int(np.sum((used > limits.ub - 1e-6) | (used < limits.lb + 1e-6)))
    assert active >= 4


@pytest.mark.parametrize("seed", range(3))
def test_repeated_solves_reach_an_optimum_of_the_nonlinear_problem(any_drive: Locomotion, seed: int) -> None:
    problem = Problem(any_drive, seed)
    program = build(Layout(any_drive, BLOCKS, DT), WEIGHTS, 200)
    plan = problem.linearised_at
    for _ in range(60):
        plan = problem.solve(program, plan)

    def cost(z: Array) -> float:
        return float(np.sum(problem.residuals(z) ** 2))

    def gradient(z: Array) -> Array:
        return 2.0 * jacobian(problem, z).T @ problem.residuals(z)

    best = oracle(cost, gradient, plan, problem.limits())
    assert cost(plan) <= cost(best) * (1.0 + 1e-6) + 1e-9


def test_a_plan_without_stages_is_refused(drive: Locomotion) -> None:
    for blocks, dt in (((), 0.1), ((1, 0), 0.1), ((1, 1), 0.0)):
        with pytest.raises(InputError, match="blocks of 1 or more stages"):
            Layout(drive, blocks, dt)
