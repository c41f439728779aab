"""The time that tests of threads run on (tests/awake.py)."""

import time

from ..awake import MOST, Awake


def test_it_stands_still_while_its_witness_does_and_goes_on_afterwards():
    with Awake() as awake:
        before = awake.monotonic()
        with awake._lock:  # the witness cannot take its turn, as if the machine were gone
            time.sleep(0.5)
        assert awake.monotonic() - before <= 5 * MOST
        end = time.monotonic() + 30.0
        while awake.monotonic() - before < 20 * MOST:
            assert time.monotonic() < end
            time.sleep(0.01)
    after = awake.monotonic()  # whoever still waits for it then must not wait for ever
    time.sleep(0.1)
    assert awake.monotonic() - after > 4 * MOST
