"""Robots that move sideways: EXP1 unchanged, a person passed with a fixed heading, and a circle around an object."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import pytest

from rocs_bt import Summary, run
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.event import BodyMoved, ContactBegan, ListSink

CATALOG = Catalog()
ROBOTS = {
    "exp1_humanoid": "humanoid",
    "exp1_mecanum": "rosbot_xl",
    "exp1_omni": "robotino",
    "exp1_quadrotor": "quadrotor",
    "exp1_quadruped": "quadruped",
}
BOX = (-0.5, 1.0)
RADIUS = 0.9  # [m]
SHELF = math.radians(-90.0)  # heading to the shelf
HULL = (0.332, 0.325)  # length and width of rosbot_xl [m]
PERSON = 0.25  # radius of the person [m]


@cache
def episode(scenario: str, seed: int) -> tuple[Summary, dict[str, list[Pose2]], list[ContactBegan]]:
    """Summary, poses of each body in each control period, and contacts of one run."""
    sink = ListSink()
    summary = run(scenario, CATALOG, seed=seed, sinks=[sink]).summary
    poses: dict[str, list[Pose2]] = {}
    for e in sink.events:
        if isinstance(e, BodyMoved):
            poses.setdefault(e.body, []).append(Pose2(e.x, e.y, e.yaw))
    return summary, poses, [e for e in sink.events if isinstance(e, ContactBegan)]


@pytest.mark.parametrize(("scenario", "robot"), ROBOTS.items())
def test_only_the_robot_differs_from_exp1(scenario: str, robot: str) -> None:
    spec, base = CATALOG.load_scenario(scenario), CATALOG.load_scenario("exp1")
    assert [a.robot for a in spec.agents] == [robot]
    assert [replaced(a, robot="") for a in spec.agents] == [replaced(a, robot="") for a in base.agents]
    assert spec.world == base.world
    assert spec.duration == (120.0 if robot == "humanoid" else base.duration), "only the slow one has more time"
    assert str(spec.places) == str(base.places)
    assert [(a.name, a.robot, a.parameters) for a in spec.actors] == [
        (a.name, a.robot, a.parameters) for a in base.actors
    ]


@pytest.mark.parametrize(
    "scenario", [pytest.param(s, marks=pytest.mark.soak) if s == "exp1_humanoid" else s for s in ROBOTS]
)  # the humanoid is slow: make test walks it in tests/robots only
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.soak)])
def test_exp1_is_clean_on_each_robot(scenario: str, seed: int) -> None:
    summary, _, touched = episode(scenario, seed)
    found = summary.agents["R2"]
    assert found.outcome == "success"
    assert not touched
    assert found.time_reactive > 0.0
    assert found.time_deliberative > 0.0


def seen_from(frame: Pose2, other: Pose2) -> tuple[float, float]:
    """Position of `other`, ahead and to the left of `frame` [m]."""
    dx, dy, c, s = other.x - frame.x, other.y - frame.y, math.cos(frame.yaw), math.sin(frame.yaw)
    return c * dx + s * dy, c * dy - s * dx


def hull_gap(robot: Pose2, person: Pose2) -> float:
    """Distance between the person and the box around the hull of rosbot_xl [m]."""
    ahead, left = seen_from(robot, person)
    return math.hypot(max(abs(ahead) - 0.5 * HULL[0], 0.0), max(abs(left) - 0.5 * HULL[1], 0.0)) - PERSON


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 22))])
def test_a_person_is_passed_sideways_with_one_heading(seed: int) -> None:
    summary, poses, touched = episode("pass_person", seed)
    robot, person = poses["R2"], poses["person"]
    assert summary.agents["R2"].outcome == "success"
    assert not touched
    assert max(abs(wrap_angle(pose.yaw - SHELF)) for pose in robot) < math.radians(8.0)
    abreast = [i for i, (r, p) in enumerate(zip(robot, person, strict=True)) if abs(p.x - r.x) < PERSON + 0.5 * HULL[1]]
    assert abreast, "they pass each other"
    assert robot[abreast[0]].x < person[abreast[0]].x
    steps = [seen_from(robot[i - 1], robot[i]) for i in abreast]
    assert all(left > 2.0 * abs(ahead) for ahead, left in steps), "sideways, to the left"
    assert max(abs(wrap_angle(robot[i].yaw - SHELF)) for i in abreast) < math.radians(4.0)
    assert 0.3 < min(hull_gap(robot[i], person[i]) for i in abreast) < 0.8, "near, but apart"
    assert robot[-1].y - min(pose.y for pose in robot) > 0.25, "out of the way and back to the line"


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.soak)])
def test_a_circle_is_driven_once_around_the_box_with_the_box_ahead(seed: int) -> None:
    summary, poses, touched = episode("circle_box", seed)
    assert summary.agents["R2"].outcome == "success"
    assert not touched
    robot = poses["R2"]
    offsets = [(p.x - BOX[0], p.y - BOX[1]) for p in robot]
    begin = next(i for i, p in enumerate(offsets) if math.hypot(*p) < RADIUS + 0.03)
    angles = [math.atan2(y, x) for x, y in offsets[begin:]]
    turned = math.fsum(wrap_angle(b - a) for a, b in pairwise(angles))
    assert turned == pytest.approx(2.0 * math.pi, abs=0.15)
    assert all(math.hypot(*p) == pytest.approx(RADIUS, abs=0.05) for p in offsets[begin:])
    looking = [
        abs(wrap_angle(math.atan2(-y, -x) - p.yaw)) for (x, y), p in zip(offsets[begin:], robot[begin:], strict=True)
    ]
    assert max(looking) < math.radians(10.0)
