from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.follower import Command, Follower, FollowerSettings
from rocs_bt.control.locomotion import Locomotion, Response
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.control.path import Path
from rocs_bt.control.profile import speed_profile
from rocs_bt.control.reference import PathReference, Preview, Reference, TimedReference, TurnReference

from .conftest import LIMITS, LOCOMOTIONS, PERIOD, Plant

FOLLOWERS = {kind: Follower(LOCOMOTIONS[kind]) for kind in ("differential", "mecanum")}
Array = npt.NDArray[np.float64]


class Fixed(Reference):
    """Always the same preview."""

    def __init__(self, stages: Array) -> None:
        self.stages = stages

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        return Preview(self.stages, 0.0, 0.0)


def along(drive: Locomotion, path: Path, cruise: float = 0.5) -> PathReference:
    return PathReference(path, speed_profile(path, drive, cruise=cruise))


def drive_on(
    follower: Follower, plant: Plant, reference: Reference, steps: int, period: float = PERIOD
) -> list[Command]:
    commands = []
    for _ in range(steps):
        commands.append(follower.step(plant.pose, None, reference, period))
        plant.move(commands[-1].values, period)
    return commands


def check_limits(drive: Locomotion, commands: list[Command], period: float = PERIOD) -> None:
    speeds = np.vstack([np.zeros(len(drive.wheels)), *(c.values for c in commands)])
    assert np.isfinite(speeds).all()
    assert np.abs(speeds).max() <= drive.max_speed.min() * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() <= drive.max_acceleration.min() * period * (1 + 1e-9)


def tour() -> Path:
    t = np.linspace(0.0, 2.0 * np.pi, 600)
    loop = 1.25 * np.column_stack([np.sin(t), np.sin(t) * np.cos(t)])
    return Path(np.vstack([loop, loop[-1] + [1.5, 1.5], loop[-1] + [0.5, 2.5]]))


@pytest.mark.parametrize("period", [0.05, 0.02])
def test_a_curved_path_with_a_corner_is_tracked_within_the_limits(drive: Locomotion, period: float) -> None:
    plant, path = Plant(drive, Pose2(0.25, 0.25, 0.3)), tour()
    commands = drive_on(Follower(drive), plant, along(drive, path, 0.7), round(18.0 / period), period)
    assert all(c.rung == "solved" for c in commands)
    check_limits(drive, commands, period)
    cross = np.array([c.cross_track for c in commands])[round(3.0 / period) :]
    assert np.sqrt(np.mean(cross**2)) < 0.008
    assert np.abs(cross).max() < 0.04
    end = path.position(path.length)
    assert math.hypot(plant.pose.x - end[0], plant.pose.y - end[1]) < 0.005


def test_every_kind_of_drive_arrives(any_drive: Locomotion) -> None:
    path = Path.through([(0, 0), (1.5, 0), (1.5, 1.0)], corner_radius=0.3)
    plant, reference = Plant(any_drive, Pose2(0.0, 0.1, 0.2)), along(any_drive, path)
    commands = drive_on(Follower(any_drive), plant, reference, 200)
    check_limits(any_drive, commands)
    assert reference.remaining < 0.02
    assert plant.pose.distance(Pose2(1.5, 1.0)) < 0.02
    assert np.abs(plant.twist).max() < 0.05


def test_a_turn_on_the_spot_stays_on_the_spot(any_drive: Locomotion) -> None:
    plant = Plant(any_drive, Pose2(1.0, 2.0, -0.5), slip=1.0)
    drive_on(Follower(any_drive), plant, TurnReference(2.5, 1.0, 2.0), 120)
    assert plant.pose.yaw == pytest.approx(2.5, abs=0.01)
    assert plant.pose.distance(Pose2(1.0, 2.0)) < 0.01


def test_a_drive_whose_pivot_is_known_stays_on_a_curve_that_it_skids_in() -> None:
    numbers = {"effective_wheel_separation": 0.5, **LIMITS}
    skidding = make_locomotion("skid", icr_offset=0.15, **numbers)
    strays = []
    for believed in (skidding, make_locomotion("skid", **numbers)):
        plant = Plant(skidding, Pose2(0.0, 0.0))
        angles = np.linspace(0.0, math.tau, 200)
        circle = Path(np.column_stack([np.sin(angles), 1.0 - np.cos(angles)]))
        commands = drive_on(Follower(believed), plant, along(believed, circle), 200)
        strays.append(max(abs(command.cross_track) for command in commands))
    assert strays[0] < 0.5 * strays[1]


def test_backward_it_believes_in_no_pivot() -> None:
    numbers = {"effective_wheel_separation": 0.5, **LIMITS}
    follower, plain = Follower(make_locomotion("skid", icr_offset=0.15, **numbers)), make_locomotion("skid", **numbers)
    assert follower.backward.locomotion.twist_from_q == pytest.approx(plain.twist_from_q)
    assert follower.backward is follower.backward
    strays = []
    for each in (follower.backward, follower):
        plant = Plant(plain, Pose2(0.0, 0.0))  # that looks behind, where it turns about its base
        angles = np.linspace(0.0, math.tau, 200)
        circle = Path(np.column_stack([np.sin(angles), 1.0 - np.cos(angles)]))
        commands = drive_on(each, plant, along(each.locomotion, circle), 200)
        strays.append(max(abs(command.cross_track) for command in commands))
    assert strays[0] < 0.5 * strays[1]
    level = Follower(plain)
    assert level.backward is level


def test_a_timetable_is_kept(drive: Locomotion) -> None:
    t = np.linspace(0.0, 10.0, 101)
    heading = 0.4 * t
    poses = np.column_stack([np.sin(heading), 1.0 - np.cos(heading), heading])
    now = [0.0]
    reference, plant, follower = TimedReference(t, poses, lambda: now[0]), Plant(drive, Pose2(0, 0)), Follower(drive)
    for k in range(160):
        now[0] = k * PERIOD
        plant.move(follower.step(plant.pose, None, reference, PERIOD).values)
    angle = 0.4 * 160 * PERIOD
    assert plant.pose.distance(Pose2(math.sin(angle), 1.0 - math.cos(angle))) < 0.03


@pytest.mark.parametrize(("lag", "better"), [(0.02, 1.01), (0.04, 1.2), (0.1, 0.7), (0.2, 0.45)])
def test_declaring_the_true_lag_does_not_make_following_worse(lag: float, better: float) -> None:
    """On the reference path of the benchmark, with its plant; a lag below a period is hardly worth declaring (M14)."""
    t = np.linspace(0.0, math.tau, 2000)
    loop = 1.25 * np.column_stack([np.sin(t), np.sin(t) * np.cos(t)])
    onward, left = np.array([1.0, 1.0]) / math.sqrt(2.0), np.array([-1.0, 1.0]) / math.sqrt(2.0)
    path = Path(np.vstack([loop, loop[-1] + 3.0 * onward, loop[-1] + 3.0 * onward + 5.0 * left]))
    drive = make_locomotion("differential", wheel_separation=0.33, **LIMITS)

    def error(response: Response) -> float:
        plant, reference, offs, s = Plant(drive, Pose2(0.0, 0.0, math.pi / 4), lag), along(drive, path, 0.7), [], 0.0
        follower = Follower(replace(drive, response=response))
        for _ in range(260):
            plant.move(follower.step(plant.pose, None, reference, PERIOD).values)
            s = path.project(plant.pose.x, plant.pose.y, s)
            offs.append(plant.pose.distance(Pose2(*path.position(s))))
        return float(np.sqrt(np.mean(np.square(offs))))

    assert error(Response(lag=lag)) < better * error(Response())


@pytest.mark.parametrize("delay", [0.02, 0.07, 0.1, 0.33])
def test_the_pose_is_predicted_over_exactly_the_delay(drive: Locomotion, delay: float) -> None:
    seen: list[Pose2] = []

    class Spy(PathReference):
        def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
            seen.append(pose)
            assert lead == delay
            return super().sample(pose, twist, times, lead)

    line = Path.line((0, 0), (9, 0))
    reference = Spy(line, speed_profile(line, drive, cruise=0.5))
    follower, plant = Follower(replace(drive, response=Response(delay=delay))), Plant(drive, Pose2(0, 0, 0))
    drive_on(follower, plant, reference, 80)
    here = plant.pose
    follower.step(here, None, reference, PERIOD)
    assert seen[-1] == pytest.approx((here.x + 0.5 * delay, here.y, here.yaw), abs=1e-3)


@pytest.mark.parametrize(("delay", "lag"), [(0.0, 0.04), (0.1, 0.0), (0.07, 0.2), (0.12, 0.013), (0.3, 0.3)])
def test_the_predicted_pose_is_that_of_a_plant_with_this_delay_and_lag(
    drive: Locomotion, delay: float, lag: float
) -> None:
    """The oracle integrates the delayed, lagging wheels in steps of 0.1 ms."""
    rng = np.random.default_rng(3)
    follower = Follower(replace(drive, response=Response(delay=delay, lag=lag)))
    size, fine, sent = len(drive.wheels), 1e-4, []
    wheels, pose, t = np.zeros(size), Pose2(0.0, 0.0, 0.0), 0.0

    def move(seconds: float, wheels: Array, pose: Pose2, t: float) -> tuple[Array, Pose2, float]:
        for _ in range(round(seconds / fine)):
            acting = next((c for at, c in reversed(sent) if at + delay <= t + 1e-9), np.zeros(size))
            wheels = acting if lag == 0.0 else wheels + (acting - wheels) * (1.0 - math.exp(-fine / lag))
            twist = drive.twist(wheels)
            ahead = Pose2(*pose.transform(fine * twist.forward, fine * twist.left), pose.yaw)
            pose, t = Pose2(ahead.x, ahead.y, pose.yaw + fine * twist.turn), t + fine
        return wheels, pose, t

    for _ in range(20):
        follower._values = follower.locomotion.saturate(rng.normal(0.0, 0.5, size))  # what a period commands
        sent.append((t, follower._values))
        follower._send(PERIOD)
        wheels, pose, t = move(PERIOD, wheels, pose, t)
    found, turning = follower._predict(pose)
    wheels, pose, t = move(delay, wheels, pose, t)
    assert tuple(found) == pytest.approx(tuple(pose), abs=2e-3)
    assert turning == pytest.approx(wheels, abs=2e-3)


coordinates = st.floats(-6.0, 6.0)
numbers = coordinates | st.sampled_from([math.nan, math.inf, -math.inf, 1e300])
poses = st.tuples(numbers, numbers, numbers)


@given(
    st.lists(st.tuples(poses, st.none() | st.lists(numbers, min_size=4, max_size=4)), min_size=1, max_size=12),
    st.sampled_from(["differential", "mecanum"]),
    st.sampled_from([0.01, 0.05, 0.2]),
)
@settings(max_examples=60, deadline=None)
def test_no_input_breaks_the_limits_or_brings_out_nan(
    ticks: list[tuple[tuple[float, float, float], list[float] | None]], kind: str, period: float
) -> None:
    follower = FOLLOWERS[kind]
    drive = follower.locomotion
    follower.reset()
    reference, last = along(drive, tour(), 0.7), np.zeros(len(drive.wheels))
    for pose, given_speeds in ticks:
        wheels = None if given_speeds is None else np.array(given_speeds[: len(drive.wheels)])
        if wheels is not None and np.isfinite(wheels).all():
            last = drive.saturate(wheels)
        command = follower.step(Pose2(*pose), wheels, reference, period)
        assert np.isfinite(command.values).all()
        assert np.abs(command.values).max() <= drive.max_speed.min() * (1 + 1e-9)
        allowed = drive.max_acceleration.min() * period * (1 + 1e-9) + 1e-9
        assert np.abs(command.values - last).max() <= allowed
        last = command.values


@given(st.lists(st.floats(-9.0, 9.0), min_size=120, max_size=120), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
@settings(max_examples=40, deadline=None)
def test_any_reference_is_solved_within_the_limits(stages: list[float], left: float, right: float) -> None:
    follower, now = FOLLOWERS["differential"], np.array([left, right])
    follower.reset()
    command = follower.step(Pose2(0, 0, 0), now, Fixed(np.array(stages).reshape(20, 6)), PERIOD)
    assert command.rung == "solved"
    assert np.abs(command.values - now).max() <= 1.5 * PERIOD * (1 + 1e-9)
    assert np.abs(command.values).max() <= 1.2 * (1 + 1e-9)


def rolling(drive: Locomotion) -> tuple[Follower, Plant, PathReference]:
    follower, plant = Follower(drive), Plant(drive, Pose2(0, 0, 0))
    reference = along(drive, Path.line((0, 0), (9, 0)))
    drive_on(follower, plant, reference, 40)
    return follower, plant, reference


@pytest.mark.parametrize("lost", [Pose2(math.nan, 0, 0), Pose2(0, math.inf, 0), Pose2(0, 0, math.nan)])
def test_without_a_pose_it_brakes_at_once_keeping_the_curvature_then_recovers(drive: Locomotion, lost: Pose2) -> None:
    follower, plant, reference = rolling(drive)
    before = follower.step(plant.pose, np.array([0.2, 0.4]), reference, PERIOD).values
    for k in range(1, 8):
        command = follower.step(lost, None, reference, PERIOD)
        assert command.rung == "braking"
        assert math.isnan(command.cross_track)
        fastest = max(0.0, np.abs(before).max() - k * 1.5 * PERIOD)
        np.testing.assert_allclose(command.values, before * fastest / np.abs(before).max(), atol=1e-12)
    assert follower.step(plant.pose, None, reference, PERIOD).rung == "solved"


def test_a_reference_or_wheel_speeds_that_are_no_numbers_brake(drive: Locomotion) -> None:
    follower, plant, reference = rolling(drive)
    speed = follower.step(plant.pose, None, reference, PERIOD).values.mean()
    broken = follower.step(plant.pose, None, Fixed(np.full((20, 6), math.nan)), PERIOD)
    assert broken.rung == "braking"
    assert broken.values.mean() == pytest.approx(speed - 1.5 * PERIOD, abs=1e-6)
    unknown = follower.step(plant.pose, np.array([math.nan, 0.1]), reference, PERIOD)
    assert unknown.rung == "braking"
    assert unknown.values.mean() == pytest.approx(speed - 3.0 * PERIOD, abs=1e-6)


@pytest.mark.parametrize("garbage", [math.nan, math.inf, 50.0, 1.3])
def test_a_failing_solver_falls_back_on_the_plan_then_brakes_then_recovers(
    drive: Locomotion, monkeypatch: pytest.MonkeyPatch, garbage: float
) -> None:
    follower, plant, reference = rolling(drive)
    solve = follower._program.solve
    starts: list[Array] = []

    def fail(pose: Pose2, q: Array, start: Array, stages: Array) -> Array:
        starts.append(np.array(start))
        nodes = solve(pose, q, start, stages).copy()
        nodes[1:] = garbage
        return nodes

    monkeypatch.setattr(follower._program, "solve", fail)
    commands = drive_on(follower, plant, reference, 12)
    assert [c.rung for c in commands] == ["previous plan"] * 3 + ["braking"] * 9
    np.testing.assert_allclose([c.values for c in commands[:3]], 0.5, atol=0.02)
    np.testing.assert_allclose(commands[-1].values, 0.0, atol=1e-9)
    assert starts[0].shape == (8, 2)  # the plan that had worked
    assert starts[1].shape == (2,)  # afresh, from the present speed
    monkeypatch.setattr(follower._program, "solve", solve)
    assert drive_on(follower, plant, reference, 1)[0].rung == "solved"


def test_a_solver_that_writes_nothing_is_noticed(drive: Locomotion, monkeypatch: pytest.MonkeyPatch) -> None:
    follower, plant, reference = rolling(drive)
    monkeypatch.setattr(follower._program, "_trigger", lambda: None)
    assert follower.step(plant.pose, None, reference, PERIOD).rung == "previous plan"


def test_a_truncated_solve_never_breaks_a_limit(drive: Locomotion) -> None:
    follower = Follower(drive, FollowerSettings(iterations=5))
    rng = np.random.default_rng(3)
    rungs, commands = set(), []
    for _ in range(150):
        pose = Pose2(*rng.normal(0.0, 2.0, 3))
        commands.append(follower.step(pose, None, Fixed(rng.normal(0.0, 3.0, (20, 6))), PERIOD))
        rungs.add(commands[-1].rung)
    assert "braking" in rungs
    check_limits(drive, commands)


def test_a_kidnapped_robot_forgets_its_plan_and_finds_the_path_again(
    drive: Locomotion, monkeypatch: pytest.MonkeyPatch
) -> None:
    follower, plant, reference = rolling(drive)
    solve, starts = follower._program.solve, []

    def spy(pose: Pose2, q: Array, start: Array, stages: Array) -> Array:
        starts.append(start.shape)
        return solve(pose, q, start, stages)

    monkeypatch.setattr(follower._program, "solve", spy)
    plant.pose = Pose2(6.0, 1.0, 2.0)
    commands = drive_on(follower, plant, reference, 240)
    assert starts[:2] == [(2,), (8, 2)]
    assert all(c.rung == "solved" for c in commands)
    assert plant.pose.distance(Pose2(9.0, 0.0)) < 0.02


def test_it_goes_on_from_the_speed_that_a_reflex_left(drive: Locomotion) -> None:
    follower, plant, reference = rolling(drive)
    command = follower.step(plant.pose, np.array([-0.3, -0.3]), reference, PERIOD)
    np.testing.assert_allclose(command.values, -0.3 + 1.5 * PERIOD, atol=1e-6)


def test_same_inputs_give_the_same_bits(any_drive: Locomotion) -> None:
    def run(follower: Follower) -> bytes:
        follower.reset()
        plant = Plant(any_drive, Pose2(0.25, 0.25, 0.3))
        commands = drive_on(follower, plant, along(any_drive, tour(), 0.7), 60)
        return b"".join(c.values.tobytes() for c in commands)

    one, other = Follower(any_drive), Follower(any_drive)
    first = run(one)
    assert run(one) == first
    assert run(other) == first


def test_commands_belong_to_the_caller(drive: Locomotion) -> None:
    follower, plant, reference = rolling(drive)
    command = follower.step(plant.pose, None, reference, PERIOD)
    kept = command.values.copy()
    command.values[:] = 9.0
    then = follower.step(plant.pose, None, reference, PERIOD).values
    assert np.abs(then - kept).max() <= 1.5 * PERIOD * (1 + 1e-9)


def test_time_is_what_the_injected_timer_says(drive: Locomotion) -> None:
    ticks = iter([10.0, 10.25])
    reference = along(drive, Path.line((0, 0), (1, 0)))
    assert Follower(drive, timer=lambda: next(ticks)).step(Pose2(0, 0), None, reference, PERIOD).solve_time == 0.25
    assert math.isnan(Follower(drive).step(Pose2(0, 0), None, reference, PERIOD).solve_time)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda f, r: f.step(Pose2(0, 0), None, r, 0.0), "control period"),
        (lambda f, r: f.step(Pose2(0, 0), None, r, math.nan), "control period"),
        (lambda f, r: f.step(Pose2(0, 0), np.zeros(3), r, PERIOD), "left, right, found 3"),
    ],
)
def test_misuse_is_named(drive: Locomotion, wrong: Callable[[Follower, Reference], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        wrong(Follower(drive), along(drive, Path.line((0, 0), (1, 0))))
