"""The time that tests of threads run on (tests/awake.py)."""

import pytest

from ..awake import MOST, TURN, Awake
from ..waiting import until


def test_a_gap_between_two_turns_counts_little_and_turns_in_time_count_in_full():
    wall = [100.0]
    awake = Awake(lambda: wall[0])
    for gap, counted in ((TURN, TURN), (0.5, MOST), (TURN, TURN), (3600.0, MOST)):
        before = awake.monotonic()
        wall[0] += gap
        assert awake.monotonic() - before == pytest.approx(counted)
        awake.turn()
        assert awake.monotonic() - before == pytest.approx(counted)


def test_it_goes_on_while_its_witness_does_and_as_the_wall_clock_afterwards():
    wall = [0.0]

    def tick():
        wall[0] += 0.001
        return wall[0]

    with Awake(tick) as awake:
        before = awake.monotonic()
        until(lambda: awake.monotonic() - before > 20 * MOST)
    after = awake.monotonic()  # whoever still waits for it then must not wait for ever
    wall[0] += 1000.0
    assert awake.monotonic() - after > 1000.0
