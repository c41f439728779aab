"""Blocks that are late: the robot is held and goes on; too often or for too long is a failure."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.agent.lateness import LONGEST, MOST, WINDOW, Lateness
from rocs_bt.agent.threaded import Heartbeat
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.event import BlockFailed, MotionHeld, MotionReleased, SensorFailed

BEAT = 0.05


@given(st.lists(st.booleans(), max_size=400))
def test_a_block_fails_by_its_delays_alone(beats):
    """Against a count of all delays so far, from the definition."""
    lateness, begun, lasted = Lateness(BEAT), [], 0
    for count, late in enumerate(beats):
        now = count * BEAT
        begun += [now] if late and not lasted else []
        lasted = lasted + 1 if late else 0
        often = len([at for at in begun if at >= now - WINDOW]) > MOST
        long = lasted * BEAT > LONGEST + 1e-9
        assert bool(lateness.after(late, now)) == (late and (often or long))
        assert lateness.late == late


@dataclass
class Block:
    """Worker whose block is late or ended as a test says."""

    name: str = "monitor range"
    optional: bool = False
    doing: str = ""
    overdue: str = "one cycle has not ended"
    thread: threading.Thread = field(default_factory=threading.main_thread)

    def late(self):
        return self.doing or None


@pytest.fixture
def heartbeat(make_agent):
    agent, _, sink, _ = make_agent(SimulatedClock(BEAT))
    heartbeat = Heartbeat(agent, agent.clock, 0.0, threading.Event())

    def beat(block, times=1):
        for _ in range(times):
            heartbeat._watch(block)
            agent.clock.advance()

    return agent, sink, beat


def of(sink, *kinds):
    return [event for event in sink.events if isinstance(event, kinds)]


def test_a_late_block_holds_the_robot_until_it_is_on_time(heartbeat):
    agent, sink, beat = heartbeat
    beat(Block(doing="monitor range"), 10)
    assert agent.actuators["wheels"].held.startswith("monitor range is late")
    assert "load" in agent.actuators["wheels"].held
    beat(Block(), 10)
    assert not agent.actuators["wheels"].held
    assert [type(event) for event in of(sink, MotionHeld, MotionReleased, BlockFailed)] == [MotionHeld, MotionReleased]
    assert agent.going


def test_a_robot_that_is_stopped_otherwise_stays_so(heartbeat):
    agent, _, beat = heartbeat
    agent.actuators["wheels"].hold("emergency stop: the button")
    beat(Block(doing="plan", name="plan"), 3)
    beat(Block(name="plan"))
    assert agent.actuators["wheels"].held == "emergency stop: the button"
    beat(Block(doing="plan", name="plan"), 3)
    agent.actuators["wheels"].release()
    assert agent.actuators["wheels"].held.startswith("plan is late")


def test_a_block_that_is_late_for_long_or_often_has_failed(heartbeat):
    agent, sink, beat = heartbeat
    for _ in range(MOST):
        beat(Block(doing="plan", name="plan"), 3)
        beat(Block(name="plan"), 3)
    assert agent.going
    beat(Block(doing="plan", name="plan"))
    (failed,) = of(sink, BlockFailed)
    assert (failed.block, failed.kind) == ("plan", "hung")
    assert "late 6 times in 10 s" in failed.detail


@pytest.mark.parametrize("ended", [True, False])
def test_a_monitor_of_optional_sensors_stops_nothing(heartbeat, ended):
    agent, sink, beat = heartbeat
    monitor = agent.monitors[0]
    block = Block(name=f"monitor {monitor.name}", optional=True)
    block = replace(block, thread=threading.Thread()) if ended else replace(block, doing=block.name)
    beat(block, 400)
    assert agent.going
    assert not of(sink, BlockFailed, MotionHeld)
    assert [event.sensor for event in of(sink, SensorFailed)] == [each.sensor.name for each in monitor.monitored]
    beat(replace(block, doing="reflexes", thread=threading.main_thread()))  # they run on the thread of any monitor
    assert of(sink, MotionHeld)
