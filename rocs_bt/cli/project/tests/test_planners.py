"""Comparison of the planners. The fixture `comparison` is provided by rocs_bt and plays the episodes once."""

import pytest


@pytest.mark.planners("brisk", "careful")
@pytest.mark.scenarios("first", seeds=6)
def test_the_brisk_patrol_is_faster_and_collides_rarely(comparison):
    comparison.assert_better("brisk", "careful", "time")
    comparison.assert_rate("brisk", "collision", upper=0.5)
