"""No command gets past the safety gate: every shipped robot, on mock devices and in MuJoCo, lockstep and threaded."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import threading
from functools import cache

import numpy as np
import pytest

import rocs_bt
from rocs_bt.agent import AgentRuntime, Controller, ThreadedRunner
from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.event import ActuatorCommanded, CommandLimited, ListSink
from rocs_bt.interfaces.action import ActionFailed
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.reactive import Reflex
from rocs_bt.running.hardware_devices import on_hardware
from rocs_bt.testing.mock_agent import mock_agent

CATALOG = Catalog()
LOAD = Catalog.load_robot
ROBOTS = [e.name for e in CATALOG.list("robot") if not on_hardware(CATALOG, CATALOG.load_robot(e.name))]
WITHOUT_DRIVERS = [name for name in ROBOTS if not CATALOG.load_robot(name).code]
"""Robots without Python drivers of their own, which are drivers of MuJoCo."""

CHANGE = 4.0  # [m/s2] limit of change in these tests
PERIODS = {"lockstep": 60, "threaded": 30}
MODES = list(PERIODS)


class Read(WallClock):
    """A wall clock that keeps what each thread last read [s]: a gate decides by it, and then commands."""

    def __init__(self, *, running=False):
        self.last = threading.local()
        super().__init__(running=running)

    def now(self):
        self.last.t = super().now()
        return self.last.t


class Logged(rocs_bt.Actuator):
    """A device that notes what reaches it, with the time by which its gate decided."""

    def __init__(self, device, clock):
        super().__init__(device.name, device.size)
        self.device, self.clock, self.log = device, clock, []

    def command(self, values):
        self.log.append((self.clock.last.t if isinstance(self.clock, Read) else self.clock.now(), list(values)))
        self.device.command(values)

    def neutral(self):
        self.log.append((self.clock.now(), None))
        self.device.neutral()


def wild(rng, size):
    """What no driver should be given: too fast, too sudden, not finite, of another length, no numbers at all."""
    kind = rng.integers(8)
    if kind == 0:
        return [math.nan] * size
    if kind == 1:
        return [math.inf, *[0.0] * (size - 1)]
    if kind == 2:
        return [1.0] * (size + 1)
    if kind == 3:
        return "fast"
    return (rng.normal(0.0, 10.0 ** rng.integers(-1, 7), size)).tolist()


class Tried:
    """Commands a handle with wild values, and lets nothing of it through."""

    rng = np.random.default_rng(0)
    handles: list = []  # noqa: RUF012 - shared by everything that attacks in one run

    @classmethod
    def attack(cls, handle):
        with contextlib.suppress(rocs_bt.InputError, rocs_bt.RocsError):
            handle.command(wild(cls.rng, handle.size))


class Berserk(rocs_bt.AtomicAction):
    """Commands wildly, several times a period, and fails or ends now and then."""

    def act(self, body):
        Tried.handles = [body.motion, *body.actuators.values()]
        for _ in range(3):
            Tried.attack(body.motion)
        ends = Tried.rng.integers(6)
        if ends == 0:
            body.motion.command(wild(Tried.rng, body.motion.size))  # may raise InputError
        if ends == 1:
            raise ActionFailed(rocs_bt.Reason.OTHER, "on purpose")
        return rocs_bt.Progress.SUCCEEDED if ends == 2 else rocs_bt.Progress.RUNNING


class Fury(rocs_bt.ReactiveModel):
    """A reflex that is as wild."""

    def react(self, x, t):
        latched = int(t / 0.3) % 2 == 1
        return [Reflex("fury/Fury", 50, "Berserk", level=True, latched=latched, reading="always")]


class Havoc(rocs_bt.Plan):
    """Submits wild actions and commands every handle that it ever saw, itself and from a thread of its own."""

    thread = None

    def run(self, t):
        for handle in Tried.handles:
            Tried.attack(handle)
        if self.thread is None and Tried.handles:
            self.thread = threading.Thread(target=lambda: [Tried.attack(h) for _ in range(300) for h in Tried.handles])
            self.thread.start()
            if isinstance(self.clock, SimulatedClock):
                self.thread.join()  # in lockstep at a time of its own, so that the run repeats
        if not self.pipeline.held:
            self.submit("Berserk")


def build(mission):
    mission.knowledge.reactive_models.append(Fury())
    return Havoc("havoc", **mission.parts)


@cache
def limited_robot(name):
    """A shipped robot whose wheels also have a limit of change."""
    robot = LOAD(CATALOG, name)
    actuators = tuple(replaced(a, limits=dataclasses.replace(a.limits, max_change=CHANGE)) for a in robot.actuators)
    return replaced(robot, actuators=actuators)


def assert_held(log, limits, period, mode):
    """Every command within the range, and within the change that the time since the one before allows."""
    assert len([values for _, values in log if values is not None]) >= PERIODS[mode]
    limits = limits.of_size(len(next(values for _, values in log if values is not None)))
    last, at, before, before_at = [0.0], -math.inf, [0.0], -math.inf
    for t, values in log:
        if values is None:
            last = before = [0.0]
            continue
        assert all(low <= v <= high for low, v, high in zip(limits.low, values, limits.high, strict=True))
        if t > at:
            before, before_at, at = last, at, t
        last = values
        for i, (value, change) in enumerate(zip(values, limits.changes, strict=True)):
            allowed = change * min(t - before_at, period) * (1.0 + 1e-6) + 1e-9
            assert abs(value - before[i % len(before)]) <= allowed


def start(seed):
    Tried.rng, Tried.handles = np.random.default_rng(seed), []


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("robot", ROBOTS)
def test_nothing_gets_past_the_gate_in_mujoco(robot, mode, monkeypatch, awake):
    start(1)
    monkeypatch.setattr(Catalog, "load_robot", lambda self, name: limited_robot(name))
    monkeypatch.setattr("rocs_bt.running.simulated_stage.WallClock", Read)
    assert_held_in_mujoco(limited_robot(robot).actuators[0].limits, robot, mode)


@pytest.mark.parametrize("robot", ROBOTS)
def test_nothing_gets_past_the_gate_of_a_robot_as_it_is_shipped(robot):
    start(3)
    assert_held_in_mujoco(CATALOG.load_robot(robot).actuators[0].limits, robot, "lockstep")


def assert_held_in_mujoco(limits, robot, mode):
    exp1 = CATALOG.load_scenario("exp1")
    agent = replaced(exp1.agents[0], robot=robot, rules=(), pose=Pose2(-1.5, -1.5, 0.0))
    scenario = replaced(exp1, agents=(agent,), actors=(), end_on_collision=False)
    logs, sink = [], ListSink()

    def prepare(stage):
        for gate in stage.actuators[agent.name].values():
            gate.wrap(lambda device: logs.append(Logged(device, stage.clock)) or logs[-1])

    rocs_bt.run(
        scenario,
        CATALOG,
        missions={agent.name: build},
        prepare=prepare,
        sinks=[sink],
        mode=mode,
        duration=PERIODS[mode] * 0.05,
    )
    (device,) = logs
    assert device.log[-1][1] is None, "at its end it is in neutral"
    assert_held(device.log, limits, 0.05, mode)
    limited = [e for e in sink.events if isinstance(e, CommandLimited)]
    assert {e.action for e in limited} == {"Berserk", ""}
    given = {e.given for e in limited if e.action}
    assert given & {tuple(e.values) for e in sink.events if isinstance(e, ActuatorCommanded)}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("robot", WITHOUT_DRIVERS)
def test_nothing_gets_past_the_gate_on_mock_devices(robot, mode, awake):
    start(2)
    threaded = mode == "threaded"
    spec, logs, sink = limited_robot(robot), [], ListSink()
    clock = Read() if threaded else SimulatedClock(0.05)

    def prepare(stage):
        for gate in stage.actuators.values():
            gate.wrap(lambda device: logs.append(Logged(device, clock)) or logs[-1])

    mind = Controller(build=build, actions=[Berserk])
    agent, stage = mock_agent(spec, mind, AgentRuntime(clock, sink), prepare=prepare, load=CATALOG.load_class)
    if threaded:
        clock.start()
        with ThreadedRunner(agent, clock):
            clock.wait_until(PERIODS[mode] * 0.05, threading.Event())
    else:
        for count in range(PERIODS["lockstep"]):
            agent.step(count)
            stage.world.advance(0.05)
            clock.advance()
    (device,) = logs
    assert device.log[-1][1] is None or not threaded, "at its end it is in neutral"
    assert_held(device.log, spec.actuators[0].limits, 0.05, mode)


def test_the_gate_is_what_holds_them_off(monkeypatch):
    """The same attack on a robot without limits of its own: the test above can fail."""
    start(1)
    spec, logs, clock = CATALOG.load_robot("pioneer_p3dx"), [], SimulatedClock(0.05)
    monkeypatch.setattr(ActuatorLimits, "apply", lambda self, wanted, last, period: list(wanted))
    agent, _ = mock_agent(
        spec,
        Controller(build=build, actions=[Berserk]),
        AgentRuntime(clock, ListSink()),
        load=CATALOG.load_class,
        prepare=lambda stage: stage.actuators["wheels"].wrap(lambda d: logs.append(Logged(d, clock)) or logs[-1]),
    )
    for count in range(PERIODS["lockstep"]):
        agent.step(count)
        clock.advance()
    with pytest.raises(AssertionError):
        assert_held(logs[0].log, limited_robot("pioneer_p3dx").actuators[0].limits, 0.05, "lockstep")
