"""The heartbeat's own death, by the times that the wheels themselves were commanded at."""

import threading
import time

import pytest

from rocs_bt.agent import ThreadedRunner
from rocs_bt.agent.worker import Worker
from rocs_bt.base.clock import WallClock
from rocs_bt.event import ActuatorCommanded, BlockFailed
from rocs_bt.testing.mock_agent import MockDevices

from ..waiting import until

LIMIT = 0.35  # [s] from the heartbeat's death to neutral
PATIENCE = 20.0  # [s] far longer than anything here may take


class Gone(KeyboardInterrupt):
    """What ends a thread without a word: no handler of exceptions catches it."""


class Injury:
    """Breaks the heartbeat of a running agent once it drives; notes when, and when the wheels were neutral.

    The heartbeat asks each worker whether it is late; that is where it breaks.
    """

    def __init__(self, monkeypatch, kind, stage: MockDevices):
        self.kind, self.driving, self.stopped, self.over = kind, *(threading.Event() for _ in range(3))
        self.broken_at = self.neutral_at = None
        self._sound, wheels = Worker.late, stage.actuators["wheels"]._device
        self._command, self._neutral = wheels.command, wheels.neutral
        monkeypatch.setattr(Worker, "late", lambda worker: self._break(worker))
        monkeypatch.setattr(wheels, "command", self._drive)
        monkeypatch.setattr(wheels, "neutral", self._stop)
        monkeypatch.setattr(threading, "excepthook", lambda args: None)

    def _break(self, worker):
        if not self.driving.is_set():
            return self._sound(worker)
        self.broken_at = self.broken_at or time.monotonic()
        if self.kind == "hung":
            self.over.wait(PATIENCE)
            return None
        raise {"raised": RuntimeError("a worm"), "ended": Gone(), "exit": SystemExit(7)}[self.kind]

    def _drive(self, values):
        self._command(values)
        if any(values):
            self.driving.set()

    def _stop(self):
        self._neutral()
        if self.broken_at is not None and not self.stopped.is_set():
            self.neutral_at = time.monotonic()
            self.stopped.set()


def of(sink, kind):
    return [e for e in list(sink.events) if isinstance(e, kind)]


WORDS = {
    "raised": ("raised", "RuntimeError: a worm (test_heartbeat.py:"),
    "ended": ("ended", "its thread has ended"),
    "exit": ("ended", "it raised SystemExit(7)"),
    "hung": ("hung", "it was late for more than 1 s"),
}


def injured(make_agent, monkeypatch, kind):
    clock = WallClock(running=False)
    agent, stage, sink, _ = make_agent(clock)
    injury = Injury(monkeypatch, kind, stage)
    clock.start()
    with ThreadedRunner(agent, clock):
        assert injury.stopped.wait(PATIENCE)
        until(lambda: of(sink, BlockFailed))
        injury.over.set()
    (failed,) = of(sink, BlockFailed)
    kind, words = WORDS[injury.kind]
    assert (failed.block, failed.kind) == ("heartbeat", kind)
    assert words in failed.detail
    assert f"block 'R1/heartbeat' {kind}" in agent.reason
    assert not any(any(e.values) for e in of(sink, ActuatorCommanded) if e.t > failed.t)
    assert stage.robot.motion == [0.0, 0.0]
    return injury.neutral_at - injury.broken_at


@pytest.mark.usefixtures("awake")
@pytest.mark.parametrize("kind", WORDS)
def test_a_dead_heartbeat_stops_the_wheels_and_is_reported(make_agent, monkeypatch, kind):
    injured(make_agent, monkeypatch, kind)


@pytest.mark.soak
@pytest.mark.parametrize("kind", WORDS)
def test_a_dead_heartbeat_stops_the_wheels_within_the_limit(make_agent, kind):
    took = []
    for _ in range(20):
        with pytest.MonkeyPatch.context() as patch:
            took.append(injured(make_agent, patch, kind))
    print(f"heartbeat {kind}: wheels neutral after {min(took):.3f} to {max(took):.3f} s")
    assert max(took) <= LIMIT
