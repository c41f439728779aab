"""The first sentence of `--why` against an independent reading of the recording."""

import re

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.record import Recording
from rocs_bt.record.tracks import Tracks
from rocs_bt.record.why import Why

from .why_oracle import Oracle

SCENARIOS = [("exp1", 1, 16.0), ("exp3", 910030, 13.0), ("rounds", 2, 20.0), ("dock", 1, 15.0), ("exp2", 3, 15.0)]


def long_numbers(lines: list[str]) -> list[str]:
    """Numbers with more than three digits, except times and positions."""
    text = "\n".join(line for line in lines if not line.startswith("true pose"))
    numbers = re.findall(r"\d+\.\d+(?! s)\b", re.sub(r"t ?= ?\d+\.\d+|\d+\.\d+ s\b", "", text))
    return [number for number in numbers if len(number.replace(".", "").lstrip("0")) > 3]


def faults(recording: Recording, every: int) -> tuple[list[str], set[str]]:
    """Wrong sentences, one in `every` periods, and what the agents did in all of them."""
    found, kinds = [], set()
    period = 1.0 / recording.header.rates["control"]
    end = max(e.t for e in recording.events())
    times = [k * period for k in range(0, int(end / period), every)] + [end]
    tracks = Tracks.of_recording(recording)
    for info in recording.header.agents:
        oracle = Oracle(recording, info.name)
        for t in times:
            why = Why(tracks, t, info.name)
            answer = why.answer
            kinds.add(oracle.kind(why.t))
            found += [f"t = {why.t:.2f} s: {fault}: {answer}" for fault in oracle.check(why.t, period, answer)]
            lines = str(why).splitlines()
            assert len(lines) <= 12  # the answer, a title and at most ten lines of evidence
            assert lines[0] == answer
            assert not long_numbers(lines), "\n".join(lines)
    return found, kinds


def played(scenario: str, seed: int, duration: float | None, folder) -> Recording:
    return Recording.open(
        rocs_bt.run(scenario, Catalog.here(), seed=seed, duration=duration, out=folder, report=False).recording
    )


@pytest.mark.parametrize(("scenario", "seed", "duration"), SCENARIOS, ids=lambda value: str(value))
def test_the_first_sentence_is_true_in_every_20th_period(scenario, seed, duration, tmp_path) -> None:
    found, kinds = faults(played(scenario, seed, duration, tmp_path), every=20)
    assert not found, "\n".join(found)
    assert "action" in kinds


# All but those on hardware.
SIMULATED = [entry.name for entry in Catalog.here().list("scenario") if entry.name != "exp1_ros2"]


@pytest.mark.soak
@pytest.mark.parametrize("scenario", SIMULATED)
def test_the_first_sentence_is_true_in_every_period(scenario, tmp_path) -> None:
    found, _ = faults(played(scenario, 1, None, tmp_path), every=1)
    assert not found, "\n".join(found[:20])
