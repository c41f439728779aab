"""Run the agents of a scenario on hardware, without simulation.

Missions, rules, blocks and rates are the same as in simulation. Only the drivers in each robot.toml differ: classes of
the user (`driver = "file.py:Class"`) that communicate with the robot.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial

import msgspec

from ..agent import Agent, RuleWatch, Runtime, ThreadedRunner
from ..agent.lateness import load
from ..catalog import Catalog, RobotSpec, ScenarioSpec
from ..clock import WallClock, wait_until
from ..drivers.isolated import IsolatedActuator
from ..drivers.last_neutral import repeat_neutral
from ..event import BodyMoved, EventSink, Stuck
from ..record import RunHeader
from ..simulation.outcome import Judge
from .build_agents import build_agents
from .clock_watch import ClockWatch
from .control import CommandDesk, HardwarePause, rule_files_of
from .go import MotionPermission
from .hardware_devices import HardwareDevices, hardware_clock
from .header import drive_command, plain_header, without_world
from .judge_panel import JudgePanel, brake
from .memory import Memory
from .options import RunOptions
from .preflight import Preflight, preflight_sensors
from .ready_run import Relay, refuse_requirements, sharing_counts
from .run_end import RunEnd
from .run_files import ReportWriter
from .run_record import RunRecord
from .run_result import RunResult
from .sink_thread import SinkThread
from .summary import Unrecorded
from .swaps import SwapSchedule


def drive_robots(spec: ScenarioSpec, catalog: Catalog, options: RunOptions, write_report: ReportWriter) -> RunResult:
    """Run the agents of a scenario on their robots; see `rocs_bt.drive`.

    Args:
        spec: The scenario.
        catalog: Source of the content.
        options: Options of the run.
        write_report: Writes report.html.

    Raises:
        InputError: The content is invalid, or an option needs a simulated world.
        DeviceError: A driver cannot reach its device, or a needed sensor gave no fresh values in time.
        KeyboardInterrupt: A signal ended the run.
    """
    options.refuse_simulation()
    end, relay = RunEnd(options, write_report), Relay()
    robots = {agent.name: catalog.load_robot(agent.robot) for agent in spec.agents}
    with end.guarded() as stack:  # callbacks of this stack run before the report is written
        end.listen()
        clock = hardware_clock(list(robots.values()), stack, options.wait, lambda: end.signals.reason)
        devices = HardwareDevices(clock, spec.rate.control_rate.period, relay, options)
        agents = _agents(spec, catalog, options, robots, devices, stack)
        memory = Memory(options.knowledge, agents)
        stack.callback(end.files.attempt, "the knowledge", memory.close)
        header = plain_header(
            spec, agents, seed=options.seed, mode="threaded", digest=catalog.digest(spec), simulated=False
        )
        refuse_requirements(spec, header.agents)
        preflight = _preflight(agents, robots, devices, spec.rate.control_rate.period, options)
        poll = _poll(devices, robots, options)
        ready = preflight.run(lambda: end.signals.reason, partial(poll, limit=options.wait))
        header = msgspec.structs.replace(header, start=clock.now())
        command = options.command or drive_command(spec.name, options)
        _begin(stack, end, without_world(header, spec, robots, command=command), agents, options)
        heard = [*([] if options.live is None else [options.live]), *options.sinks]
        record = RunRecord(header, end.files.recorder, heard, batched=False)
        memory.start(f"{spec.name}-{options.seed}", patient=False)

        rules = RuleWatch(rule_files_of(agents), clock, relay, watching=options.watch_rules)
        between = _desk(options, agents, devices, catalog, rules, relay)

        def check(t: float) -> None:
            record.check()
            poll()
            between(t)
            if options.progress is not None:
                options.progress(t - header.start)

        episode = HardwareEpisode(
            agents,
            devices,
            clock=clock,
            start=header.start,
            duration=spec.duration if options.duration is None else options.duration,
            period=spec.rate.control_rate.period,
            sink=relay,
            ended=lambda: end.signals.reason,
            check=check,
            meanwhile=poll,
        )

        def play() -> None:
            with SinkThread(record.sink) as thread, rules:
                relay.open(thread)
                episode.run() if ready else episode.interrupt()

        end.attempt(play)
        end.attempt(record.check)
        end.files.attempt("the knowledge", memory.close)
        took = episode.t - header.start
        unrecorded = Unrecorded(wall_time=took, sharing=sharing_counts(agents), knowledge=memory.summary())
        end.summarise(record.summary(episode.t, unrecorded))
    return end.result()


def _agents(
    spec: ScenarioSpec,
    catalog: Catalog,
    options: RunOptions,
    robots: Mapping[str, RobotSpec],
    devices: HardwareDevices,
    stack: ExitStack,
) -> list[Agent]:
    """Open the devices and build the agents; the stack closes both."""
    opened = stack.enter_context(ExitStack())
    for name, robot in robots.items():
        rates = {s.name: spec.rate.sensor_rate(s.rate, s.name) for s in robot.sensors}
        devices.open(name, robot, rates, catalog, stack, opened)
    runtime = Runtime(devices.clock, devices.sink, time.perf_counter)
    agents = build_agents(spec, catalog, devices.robots, runtime, seed=options.seed, missions=options.missions)
    opened.pop_all()  # from here on the agents close their devices
    for agent in agents:
        stack.callback(agent.close)
    return agents


def _preflight(
    agents: Sequence[Agent],
    robots: Mapping[str, RobotSpec],
    devices: HardwareDevices,
    period: float,
    options: RunOptions,
) -> Preflight:
    """Preflight check of all sensors, and of topics that need a node; starts the clock."""
    devices.clock.start()
    sensors = [sensor for agent in agents for sensor in preflight_sensors(agent, robots[agent.name])]
    return Preflight([*sensors, *devices.topics], devices.clock, period, wait=options.wait, show=options.preflight)


def _poll(devices: HardwareDevices, robots: Mapping[str, RobotSpec], options: RunOptions) -> Callable[..., str]:
    """Function that checks the clock, and returns the reason why a robot must not move (`MotionPermission.poll`)."""
    permission = MotionPermission(list(devices.stops.values()), options.go, devices.watches)
    watch = ClockWatch(devices.clock, devices.gates, options.notice)
    watch.report_isolation(robots.values())

    def poll(ready: bool = True, limit: float = math.inf) -> str:
        watch.check(limit)
        return permission.poll(ready)

    return poll


def _desk(
    options: RunOptions,
    agents: Sequence[Agent],
    devices: HardwareDevices,
    catalog: Catalog,
    rules: RuleWatch,
    sink: EventSink,
) -> Callable[[float], None]:
    """Function that applies the commands of a person; call it once per control period."""
    swaps, pause = SwapSchedule((), agents, catalog), HardwarePause(list(devices.stops.values()))
    only_pause = not options.full_control
    desk = CommandDesk(options.control, swaps, rules, devices.clock, sink, pause, only_pause=only_pause)

    def between(t: float) -> None:
        swaps.step(t)
        desk.period(lambda: "")

    return between


def _begin(stack: ExitStack, end: RunEnd, header: RunHeader, agents: Sequence[Agent], options: RunOptions) -> None:
    """Begin the live page and the files of the run, if requested."""
    if options.live is not None:
        options.live.begin(header)
    end.files.begin(header, agents if options.btlog else ())
    stack.callback(end.files.abandon)


class HardwareEpisode:
    """One run on hardware. Without ground truth, the outcomes are determined from the robots' own estimates.

    Args:
        agents: Agents of the scenario.
        devices: Devices of their robots.
        clock: Wall clock, running.
        start: Time of the first control period [s].
        duration: Maximum duration [s].
        period: Control period [s].
        sink: Sink for all events.
        ended: Returns the reason of a signal that ends the run, or an empty text.
        check: Called once per control period with the time [s]; an exception ends the run.
        meanwhile: Called each 50 ms of wall time within a control period; an exception ends the run.

    Attributes:
        t: Time of the last control period [s].
    """

    def __init__(
        self,
        agents: Sequence[Agent],
        devices: HardwareDevices,
        *,
        clock: WallClock,
        start: float,
        duration: float,
        period: float,
        sink: EventSink,
        ended: Callable[[], str],
        check: Callable[[float], None],
        meanwhile: Callable[[], object],
    ) -> None:
        self.t = start
        self._agents = agents
        self._gates = devices.gates
        self._motion = devices.motion
        self._links = devices.links
        self._late: set[tuple[str, str]] = set()  # agents, and their actuators whose processes are late
        self._clock = clock
        self._end = start + duration
        self._period = period
        self._sink = sink
        self._ended = ended
        self._check = check
        self._meanwhile = meanwhile
        self._judges = {agent.name: Judge(end_on_stuck=False, start=start) for agent in agents}
        self._panel = JudgePanel(agents, self._judges, sink)
        self._stuck: set[str] = set()

    def run(self) -> None:
        """Run until every agent has an outcome, the duration is over, or a signal ends the run."""
        clock, never, due = self._clock, threading.Event(), self.t
        try:
            with ExitStack() as stack:
                for agent in self._agents:
                    stack.enter_context(ThreadedRunner(agent, clock))
                stack.callback(brake, self._agents)
                while wait_until(clock, due, never, self._ended, self._meanwhile):
                    self.t = clock.now()
                    self._check_all()
                    if why := self._ended():
                        self._panel.interrupt(why, at_once=True)
                    if self._panel.over or self.t >= self._end:
                        break
                    due += self._period * max(1.0, math.ceil((self.t - due) / self._period))
        except BaseException as error:  # raised again after the robots stopped
            self._panel.abort(error, self.t)
            raise
        finally:
            repeat_neutral(self._neutral)
        self._panel.finish(self.t)

    def _neutral(self) -> None:
        for gate in self._gates:
            with suppress(Exception):  # a driver that fails is reported already, and the others must stop
                gate.neutral()

    def interrupt(self) -> None:
        """Give every agent the outcome of a run that a signal ended before the robots could start."""
        self._panel.interrupt(self._ended(), at_once=True)
        self._panel.finish(self.t)

    def _check_all(self) -> None:
        """Check the devices of all agents, and determine the agents' outcomes."""
        self._check(self.t)
        for gate in self._gates:
            gate.check()
        for agent in self._agents:
            for link in self._links[agent.name]:
                if (error := link.check()) is not None:
                    agent.fail(link.name, error.kind, str(error), error, owner="content")
                else:
                    self._watch(agent, link)
            self._judge(agent)

    def _watch(self, agent: Agent, link: IsolatedActuator) -> None:
        """Hold an agent while the process of its actuator waits for a processor."""
        key, source = (agent.name, link.name), f"late process of {link.name}"
        if link.late and key not in self._late:
            self._late.add(key)
            agent.hold(f"the process of actuator {link.name} is late: it waits for a processor{load()}", source)
        elif not link.late and key in self._late:
            self._late.remove(key)
            agent.resume(source, f"{link.name}, on time again")

    def _judge(self, agent: Agent) -> None:
        name, judge, pose = agent.name, self._judges[agent.name], agent.knowledge.robot.pose()
        if math.isfinite(pose.x):
            self._sink.emit(BodyMoved(t=self.t, agent=name, body=name, x=pose.x, y=pose.y, yaw=pose.yaw))
        if judge.decided:
            return
        gate = self._motion[name]
        if judge.update(self.t, pose, agent, commanded=gate.active, paused=bool(gate.held)):
            agent.brake()
        if not judge.stuck:
            self._stuck.discard(name)
        elif name not in self._stuck:
            self._stuck.add(name)
            self._sink.emit(Stuck(t=self.t, agent=name, reason=judge.stuck, rule=judge.stuck_rule))
