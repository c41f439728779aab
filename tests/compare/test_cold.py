"""Cold comparisons: losses paired by scene and seed, their keys, and the walk outward."""

from __future__ import annotations

from math import sqrt

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.compare import Comparison, ScenarioScene
from rocs_bt.compare.cold import POOLED, losses, walk_outward
from rocs_bt.compare.key import EpisodeKeys
from rocs_bt.compare.report import cold_rows
from rocs_bt.declare import replaced

from .records import episode, table

CATALOG = Catalog()
SHIPPED = CATALOG.load_perturbations()
TREE = CATALOG.load_planner("tree")


def test_a_loss_and_its_interval_are_those_computed_by_hand():
    found = losses(Comparison([*table("a", "ssss"), *table("a~noise=3", "fsss")]), ["success"])
    (loss,) = found
    assert (loss.planner, loss.perturbation, loss.warm.value, loss.cold.value) == ("a", "noise=3", 1.0, 0.75)
    # Differences 1, 0, 0, 0 and one additional scene with the square 1; t quantile for 3 degrees of freedom: 3.182446.
    error, quantile = sqrt(((1.0 + 1.0) / 4.0 - 0.25**2) / 3.0), 3.182446
    assert loss.verdict.difference == pytest.approx(0.25)
    assert loss.verdict.low == pytest.approx(0.25 - quantile * error, abs=1e-5)
    assert loss.verdict.high == 1.0  # bounded by the greatest possible loss


def test_a_loss_is_positive_where_cold_is_worse_in_any_metric():
    warm = [episode("a", f"field-{i}", time=10.0 + i) for i in range(4)]
    cold = [episode("a~delay=0.1", f"field-{i}", time=12.5 + i) for i in range(4)]
    (loss,) = losses(Comparison([*warm, *cold]), ["time"])
    assert loss.verdict.difference == pytest.approx(2.5)


def test_losses_are_paired_whatever_the_order_of_the_scenes():
    warm = [episode("a", f"field-{i}", time=10.0 + 5.0 * i) for i in range(4)]
    cold = [episode("a~delay=0.1", f"field-{i}", time=11.0 + 5.0 * i) for i in reversed(range(4))]
    (loss,) = losses(Comparison([*warm, *cold]), ["time"])
    assert loss.verdict.difference == pytest.approx(1.0)
    assert 0.0 < loss.verdict.low < 1.0 < loss.verdict.high < 2.0  # unpaired, the spread of the scenes would be in it


def test_all_perturbations_together_are_repetitions_of_the_same_scenes():
    records = [*table("a", "sssss"), *table("a~noise=3", "fssss"), *table("a~delay=0.1", "ffsss")]
    *_, pooled = losses(Comparison(records), ["success"])
    assert (pooled.perturbation, pooled.cold.value, pooled.warm.value) == (POOLED, 0.7, 1.0)
    assert (pooled.verdict.scenes, pooled.verdict.episodes, pooled.verdict.apart) == (5, 10, 3)
    assert pooled.verdict.difference == pytest.approx(0.3)


def test_seeds_are_the_sample_of_a_single_scene():
    records = [*table("a", "ssss", 4), *table("a~noise=3", "fsss", 4), *table("a~delay=0.1", "ffss", 4)]
    *_, pooled = losses(Comparison(records), ["success"])
    assert pooled.verdict.difference == pytest.approx(0.375)
    one = [*table("a", "s"), *table("a~noise=3", "f"), *table("a~delay=0.1", "f")]
    assert [each.perturbation for each in losses(Comparison(one), ["success"])] == ["noise=3", "delay=0.1"]


def test_each_planner_has_its_own_losses():
    records = [*table("a", "ss"), *table("a~noise=3", "sf"), *table("ab", "sf"), *table("ab~noise=3", "ff")]
    found = losses(Comparison(records), ["success"])
    assert [(each.planner, each.verdict.difference) for each in found] == [("a", 0.5), ("ab", 0.5)]


def test_a_loss_without_an_interval_has_only_its_value():
    records = [episode("a", "field-0", time=10.0), episode("a~noise=3", "field-0", time=12.5)]
    assert [row[-1] for row in cold_rows(losses(Comparison(records), ["success", "time"]))] == ["+0.0 points", "+2.5 s"]


def walk(shares, warm=1.0):
    """Walk of the delay with these successes in ten episodes at each strength."""
    left = iter(shares)

    def play(planner):
        wins = next(left)
        if wins is None:
            raise InputError("delay must be 0 to 10 s.")
        return table(planner.name, "s" * wins + "f" * (10 - wins))

    return walk_outward(TREE, SHIPPED["delay"], warm, play)


def test_a_walk_ends_where_less_than_half_of_the_success_is_left():
    found = walk([10, 8, 5, 4])
    assert [each.strength.value for each, _ in found.shares] == pytest.approx([0.1, 0.2, 0.4, 0.8])
    assert found.breaks is not None
    assert found.breaks.strength.value == pytest.approx(0.8)
    assert str(found) == "tree with delay: breaks at 0.8 s (success 40 %), holds at 0.4 s"


def test_half_of_what_the_planner_reaches_warm_counts():
    assert walk([3, 2], warm=0.5).breaks == SHIPPED["delay"].at(0.2)


def test_a_walk_without_a_break_has_its_reason():
    assert "the last of 7 strengths" in str(walk([10] * 7))
    assert "holds up to 0.2 s (0.4 s is not possible: delay must be" in str(walk([10, 10, None]))
    assert "never succeeds" in str(walk([], warm=0.0))


def test_a_key_covers_the_perturbation_its_strength_and_its_definition():
    scene = ScenarioScene("exp1")
    cold = [TREE.under(each) for each in SHIPPED.values()]
    stronger = [TREE.under(each.next()) for each in SHIPPED.values()]
    assert len({EpisodeKeys(CATALOG).of(each, scene, 1) for each in (TREE, *cold, *stronger)}) == 1 + 2 * len(SHIPPED)
    other = replaced(SHIPPED["delay"], change="times")
    assert EpisodeKeys(CATALOG).of(TREE.under(other), scene, 1) != EpisodeKeys(CATALOG).of(
        TREE.under(SHIPPED["delay"]), scene, 1
    )
