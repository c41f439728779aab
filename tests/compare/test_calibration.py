"""Intervals hold the truth as often as they say, and verdicts are rarely false: small here, whole as a campaign.

The whole one prints tables of coverage (docs/statistics.md): pytest -m soak -rP tests/compare/test_calibration.py
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from . import calibration

SWEEPS = 400
NOISE = 3.0  # standard deviations of a share of as many sweeps


def allowed(share, sweeps=SWEEPS):
    return NOISE * np.sqrt(share * (1.0 - share) / sweeps)


@pytest.mark.parametrize(("seeds", "alike", "p"), [(1, 0.0, 0.8), (3, 0.3, 0.9), (3, 1.0, 0.8), (10, 0.7, 0.5)])
def test_a_rates_interval_holds_it(seeds, alike, p):
    held = calibration.cover_rate(np.random.default_rng(1), 100, seeds, alike, p, SWEEPS)
    assert 0.93 - allowed(0.93) <= held <= 0.97 + allowed(0.97)


@pytest.mark.parametrize(
    ("seeds", "alike", "rates"), [(1, 0.0, (0.8, 0.6)), (3, 0.3, (0.97, 0.9)), (10, 0.7, (0.5, 0.5))]
)
def test_a_differences_interval_holds_it(seeds, alike, rates):
    held = calibration.cover_difference(np.random.default_rng(2), 100, seeds, alike, rates, SWEEPS)
    assert 0.93 - allowed(0.93) <= held <= 0.97 + allowed(0.97)


def test_as_if_seeds_were_scenes_it_would_not():
    """What the test would see of an interval that forgets that seeds of a scene are alike."""
    from benchmarks.paper.estimates import share

    rng, held = np.random.default_rng(1), 0
    for _ in range(SWEEPS):
        (ease,) = calibration.eases(rng, 100, 1)
        values = calibration.successes(rng, 0.5, 0.7, ease, 10)
        found = share(int(values.sum()), values.size)
        held += found.low <= 0.5 <= found.high
    assert held / SWEEPS < 0.7


def test_two_equal_planners_are_rarely_told_apart():
    told = calibration.false_verdicts(np.random.default_rng(3), 100, 3, 0.3, 0.8, SWEEPS)
    assert told <= 0.05 + allowed(0.05)
    assert calibration.false_time_verdicts(np.random.default_rng(4), 50, SWEEPS // 4) <= 0.05 + allowed(
        0.05, SWEEPS // 4
    )


def test_nor_by_looking_after_every_scene():
    told = calibration.false_stops(np.random.default_rng(5), 200, 3, 0.3, 0.8, SWEEPS // 4)
    assert told <= 0.05 + allowed(0.05, SWEEPS // 4)


@pytest.mark.soak
def test_the_campaign(capsys):
    """All cells. Bounds are those that docs/statistics.md promises, for 100 scenes and more, and its noise."""
    sweeps = 1000
    calibration.main(sweeps)
    told = capsys.readouterr().out
    print(told)
    parts = re.split(r"\n### ", told)
    rates = [
        float(v) for line in parts[1].splitlines() if re.match(r"\| (100|300) ", line) for v in line.split("|")[4:9]
    ]
    assert min(rates) >= 93.0 - 100 * allowed(0.93, sweeps)
    false = [float(v) for line in parts[4].splitlines() if re.match(r"\| \d", line) for v in line.split("|")[4:9]]
    assert max(false) <= 5.0 + 100 * 1.2 * allowed(0.05, sweeps)  # the greatest of 180
    stops = [float(v) for line in parts[6].splitlines() if re.match(r"\| \d", line) for v in line.split("|")[3:8]]
    assert max(stops) <= 5.0
