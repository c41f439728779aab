"""The two reflexes, as published and put right: what they do to a reading, and what the defects cost."""

from __future__ import annotations

import math
import re
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.paper.campaign import Job, play
from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import Catalog
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.expression import Environment
from rocs_bt.reactive import Reflex, RuleModel, load_rules

from . import reflexes

CATALOG = Catalog()
PAGE = reflexes.PAGE.read_text("utf-8")
SIGNALS = stub_agent(CATALOG.load_robot("pioneer_p3dx"), CATALOG.load_class).knowledge.signals
RADIUS = 0.0975  # [m]
WEIGHTS = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6]  # the published ones, of the left wheel, from left to right

ranges = st.lists(st.one_of(st.just(math.inf), st.floats(0.02, 1.0)), min_size=8, max_size=8)


@cache
def model_of(rules: str) -> RuleModel:
    return RuleModel(load_rules(CATALOG.find("rules", rules).path, Environment.of(SIGNALS), ACTIONS))


def react(rules: str, beams: list[float]) -> Reflex | None:
    """What a rule file wants when the eight front sonars, from left to right, read this [m]."""
    model = model_of(rules)
    model.reset()
    x = SIGNALS.snapshot(0.0)
    for name, values in (("left_gap", beams[:4]), ("right_gap", beams[:3:-1])):
        x[SIGNALS.slice_of(name)] = values
    wanted = [reflex for reflex in model.react(x, 0.0) if reflex.latched]
    return wanted[0] if wanted else None


def wheels(rules: str, beams: list[float]) -> list[float] | None:
    """The wheels' speeds that a Braitenberg reflex wants [rad/s], left and right."""
    reflex = react(rules, beams)
    return None if reflex is None else [speed / RADIUS for speed in reflex.parameters["speeds"]]


def published(distance: float) -> float:
    """What the published program makes of a distance [m]: what is *farther* than 0.10 m becomes 0.10 m."""
    if not distance < 0.3:
        return 0.0
    return 1.0 - ((0.1 if distance > 0.1 else distance) - 0.1) / (0.3 - 0.1)


def proportional(distance: float) -> float:
    return 1.0 - (min(max(distance, 0.1), 0.3) - 0.1) / (0.3 - 0.1)


@pytest.mark.parametrize(("near", "as_published", "put_right"), [((3, 4), -0.3, 1.41), ((2, 3, 4, 5), -2.1, 1.32)])
def test_an_echo_that_just_begins_counts_in_full_as_published_and_hardly_put_right(near, as_published, put_right):
    beams = [0.29 if i in near else math.inf for i in range(8)]
    assert wheels("braitenberg_published", beams) == pytest.approx([as_published] * 2)
    left, right = wheels("braitenberg", beams) or [1.5, 1.5]
    assert (left + right) / 2.0 == pytest.approx(put_right, abs=0.01)
    assert left != right, "straight ahead it turns all the same"


@given(ranges)
def test_braitenberg_as_published_is_the_programs_own_formula(beams):
    seen = [published(d) for d in beams]
    left = 1.5 - sum(w * s for w, s in zip(WEIGHTS, seen, strict=True))
    right = 1.5 - sum(w * s for w, s in zip(reversed(WEIGHTS), seen, strict=True))
    fires = max(1.5 - left, 1.5 - right) > 0.1
    found = wheels("braitenberg_published", beams)
    assert (found is not None) == fires
    assert found is None or found == pytest.approx([left, right], abs=1e-9)


@given(ranges)
def test_braitenberg_put_right_is_in_proportion_and_never_drives_straight_at_what_is_ahead(beams):
    seen = [proportional(d) for d in beams]
    both = 3.0 - 1.8 * sum(seen)
    found = wheels("braitenberg", beams)
    assert (found is None) == (
        max(
            sum(w * s for w, s in zip(weights, seen, strict=True)) + sign * turn(beams, seen)
            for weights, sign in ((WEIGHTS, 1.0), (WEIGHTS[::-1], -1.0))
        )
        <= 0.1
    )
    if found is not None:
        assert sum(found) == pytest.approx(both, abs=1e-9)


def turn(beams: list[float], seen: list[float]) -> float:
    room = sum(min(d, 1.0) for d in beams[:4]) - sum(min(d, 1.0) for d in beams[:3:-1])
    return math.copysign(max(seen[2:6]), room if room else 1.0)


@pytest.mark.parametrize(("near", "turned"), [((0, 1, 4), -60.0), ((7, 6, 3), 60.0), ((3, 4), 0.0), ((0, 7), 0.0)])
def test_avoid_collision_as_published_counts_beams_and_does_not_turn_for_what_is_straight_ahead(near, turned):
    reflex = react("avoid_collision_published", [0.2 if i in near else math.inf for i in range(8)])
    assert reflex is not None
    assert math.degrees(reflex.parameters["turn"]) == pytest.approx(turned)
    assert react("avoid_collision_published", [0.31] * 8) is None


def test_the_inverted_clamp_keeps_the_robot_from_its_goal_and_the_right_one_does_not():
    one, other = (play(Job("exp1", 1, rules=(name,))).agents["R2"] for name in ("braitenberg_published", "braitenberg"))
    assert one.outcome != "success"
    assert other.outcome == "success"
    assert one.route_switches > 2 * other.route_switches


def test_the_page_has_the_commands_table_for_every_reflex():
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if "m/s |" in line]
    assert {(rules.strip("`"), cruise) for rules, cruise, *_ in rows} == {
        (rules, cruise) for rules in reflexes.REFLEXES for cruise in reflexes.CRUISES
    }
    assert "| " + " | ".join(reflexes.HEADS) + " |" in PAGE
    assert re.search(r"python -m tests\.experiments\.reflexes --seeds (\d+)", PAGE)


@pytest.mark.soak
def test_the_command_gives_the_pages_table_again():
    seeds = int(re.search(r"python -m tests\.experiments\.reflexes --seeds (\d+)", PAGE)[1])
    assert seeds >= 50
    assert reflexes.table(range(1, seeds + 1)) in PAGE
