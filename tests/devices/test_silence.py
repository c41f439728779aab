"""Silence: when the process of an isolated actuator counts as late, and when as hung."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.devices.isolated import silence
from rocs_bt.devices.isolated.silence import GRACE, HUNG, TICK, Silence

from .. import needs
from ..awake import one_processor
from ..waiting import until

MAX_AGE = 0.2  # [s]


@pytest.fixture
def waited(monkeypatch):
    """Time for which the process has waited for a processor [s], as a list of one value."""
    waited = [0.0]
    monkeypatch.setattr(silence, "waited_for_processor", lambda process: waited[0])
    monkeypatch.setattr(silence, "ready_threads", lambda process: {})
    return waited


@given(
    max_age=st.floats(0.1, 2.0),
    pauses=st.lists(st.floats(0.2 * TICK, TICK), min_size=1, max_size=50),
    answers=st.integers(0, 100),
)
def test_silence_is_found_in_time_and_never_before(max_age, pauses, answers):
    """The process answers for a while, then never again; requests come all the time."""
    watch, t, last = Silence(max_age, 1), 0.0, 0.0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(silence, "ready_threads", lambda process: {})
        patch.setattr(silence, "waited_for_processor", lambda process: 0.0)
        for count in itertools.count():
            pause = pauses[count % len(pauses)]
            t, progress = t + pause, count < answers
            last = t if progress else last
            if watch.after(pause, progress=progress, waiting=not progress):
                break
            assert t - last <= max_age + GRACE + 1e-9
    assert count >= answers
    assert t - last > max_age + GRACE - 1e-9
    assert t - last <= max_age + 0.1


def test_a_main_process_that_is_held_up_finds_no_silence(waited):
    watch = Silence(MAX_AGE, 1)
    assert not watch.after(60.0, progress=False, waiting=True)
    assert not watch.after(60.0, progress=True, waiting=False)


def test_a_device_at_rest_has_time_for_its_next_request(waited):
    watch = Silence(MAX_AGE, 1)
    for _ in range(1000):
        assert not watch.after(TICK, progress=False, waiting=False)
    for _ in range(10):
        assert not watch.after(TICK, progress=False, waiting=True)


def test_a_process_that_waits_for_a_processor_is_late_and_not_hung(waited):
    watch, late = Silence(MAX_AGE, 1), []
    for _ in range(40):  # 0.8 s
        waited[0] += TICK
        assert not watch.after(TICK, progress=False, waiting=True)
        late.append(watch.late)
    assert late.index(True) == round((MAX_AGE + GRACE) / TICK)
    assert all(late[late.index(True) :])
    assert not watch.after(TICK, progress=True, waiting=False)
    assert not watch.late


def test_a_silent_process_is_late_first_where_another_way_to_the_device_exists(waited):
    watch, found, late = Silence(MAX_AGE, 1, patient=True), "", []
    while not found:
        found = watch.after(TICK, progress=False, waiting=True)
        late.append(watch.late)
    assert late.index(True) == round((MAX_AGE + GRACE) / TICK)
    assert found == "has not answered for 1 s"
    assert len(late) * TICK == pytest.approx(HUNG, abs=1.5 * TICK)


def test_a_wait_that_lasts_counts_before_the_system_adds_it(waited, monkeypatch):
    ran = [0.0]
    monkeypatch.setattr(silence, "ready_threads", lambda process: {"1": ran[0]})
    watch = Silence(MAX_AGE, 1)
    for _ in range(40):  # 0.8 s, of which it runs for a tenth
        ran[0] += 0.1 * TICK
        assert not watch.after(TICK, progress=False, waiting=True)
    assert watch.late


def test_a_process_that_computes_is_hung(waited, monkeypatch):
    ran = [0.0]
    monkeypatch.setattr(silence, "ready_threads", lambda process: {"1": ran[0]})
    watch = Silence(MAX_AGE, 1)
    for _ in range(round((MAX_AGE + GRACE) / TICK) - 1):
        ran[0] += TICK
        assert not watch.after(TICK, progress=False, waiting=True)
    ran[0] += 2 * TICK
    assert watch.after(2 * TICK, progress=False, waiting=True)


def test_a_process_that_waits_for_a_processor_for_too_long_is_hung(waited):
    watch, found, count = Silence(MAX_AGE, 1), "", 0
    while not found:
        waited[0] += TICK
        found, count = watch.after(TICK, progress=False, waiting=True), count + 1
    assert found == "has not answered for 1 s"
    assert count * TICK == pytest.approx(HUNG, abs=1.5 * TICK)


def test_half_of_the_time_without_a_processor_doubles_the_time_to_hung(waited):
    watch, found, count = Silence(MAX_AGE, 1), "", 0
    while not found:
        waited[0] += 0.5 * TICK
        found, count = watch.after(TICK, progress=False, waiting=True), count + 1
    assert found == "has not answered for 0.24 s"
    assert count * TICK == pytest.approx(2 * (MAX_AGE + GRACE), abs=0.5 * MAX_AGE)


@needs.linux("tells how long a thread waits for a processor")
def test_the_time_without_a_processor_is_that_of_the_system():
    with one_processor():
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        until(lambda: silence.waited_for_processor(busy[0].pid) > 0.1)
        os.kill(busy[0].pid, signal.SIGSTOP)
        os.waitid(os.P_PID, busy[0].pid, os.WSTOPPED)
        before = silence.waited_for_processor(busy[0].pid)
        run = silence.waited_for_processor(busy[1].pid)
        until(lambda: silence.waited_for_processor(busy[1].pid) >= run)
        assert silence.waited_for_processor(busy[0].pid) == before
    finally:
        for each in busy:
            each.kill()
            each.wait()
    assert silence.waited_for_processor(busy[0].pid) == 0.0
