"""Running the agents of a scenario on robots that are real, or stand in for one; nothing is simulated.

The same missions, rules, blocks and rates as in simulation. What differs is each robot's table of drivers, whose
classes (`driver = "file.py:Class"`) speak with the robot.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path

from ..agent import RuleWatch
from ..catalog import ActuatorSpec, Catalog, RobotSpec, ScenarioSpec
from ..clock import WallClock
from ..device import Actuator, Sensor
from ..drivers.host import Host
from ..drivers.isolated import IsolatedActuator
from ..event import EventSink
from ..safety import SafetyGate
from .devices import make_hardware, make_isolated
from .hardware_episode import HardwareEpisode
from .header import plain_header, without_world
from .minds import build_minds
from .ready_run import Relay, refuse_requirements
from .run_end import RunEnd, RunResult
from .run_record import RunRecord
from .sink_thread import SinkThread
from .stop_signals import StopSignals


def drive(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    *,
    duration: float | None = None,
    out: Path | str | None = None,
    report: bool = True,
    sinks: Sequence[EventSink] = (),
    watch_rules: bool = False,
    signals: StopSignals | None = None,
) -> RunResult:
    """Let the agents of a scenario drive their robots, threaded, on wall time; movers and the world are not played.

    It ends when every agent has its outcome, when time is over, or by SIGINT, SIGTERM or SIGHUP: wheels to neutral
    first, then all files. After that the signal has its usual effect, such as a KeyboardInterrupt.

    Args:
        scenario: A scenario, or its name or file. Every driver of its agents' robots must be a user's class.
        catalog: Where content is found; the project around the current folder by default.
        duration: The longest it may take [s]; the scenario's own by default.
        out: Folder for summary.json, run.mcap and report.html; None writes nothing.
        report: Whether to write report.html.
        sinks: More sinks for all events.
        watch_rules: Whether rule files that change are read again.
        signals: The signals that end the run, of a caller who looks at them afterwards: `drive` then returns.

    Returns:
        The result; in its summary collisions and clearance are None, and poses are the robots' own estimates.

    Raises:
        InputError: Something in the content is wrong.
        DeviceError: A driver cannot reach its device.
        KeyboardInterrupt: A signal ended the run.
    """
    catalog = catalog or Catalog.here()
    spec = catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
    end, relay, clock = RunEnd(out, report, signals), Relay(), WallClock(running=False)
    period = spec.rate.control_rate.period
    robots = {agent.name: catalog.load_robot(agent.robot) for agent in spec.agents}
    with end.guarded() as stack:  # what is pushed on it is closed before the report is written
        end.listen()
        devices, opened = _Devices(), stack.enter_context(ExitStack())
        for name, robot in robots.items():
            devices.make(name, robot, catalog, clock, period, relay, stack, opened)
        rates = {n: {s.name: spec.rate.sensor_rate(s.rate, s.name) for s in r.sensors} for n, r in robots.items()}
        agents = build_minds(
            spec,
            catalog,
            robots,
            devices.sensors,
            devices.gates,
            rates,
            clock=clock,
            sink=relay,
            timer=time.perf_counter,
        )
        opened.pop_all()  # from here on the agents close their devices
        for agent in agents:
            stack.callback(agent.close)
        header = plain_header(spec, agents, seed=0, mode="threaded", digest=catalog.digest(spec), simulated=False)
        refuse_requirements(spec, header.agents)
        end.files.begin(without_world(header, spec, robots))
        stack.callback(end.files.abandon)
        record = RunRecord(header, end.files.recorder, sinks, batched=False)
        episode = HardwareEpisode(
            agents,
            devices.gates,
            {name: devices.gates[name][robot.drive.actuator] for name, robot in robots.items()},
            devices.links,
            clock=clock,
            duration=spec.duration if duration is None else duration,
            period=period,
            sink=relay,
            ended=lambda: end.signals.reason,
            check=record.check,
        )
        files = [(agent.name, file) for agent in agents for file in agent.rule_files if watch_rules]

        def play() -> None:
            with SinkThread(record.sink) as thread, RuleWatch(files, clock, relay):
                relay.open(thread)
                episode.run()

        end.attempt(play)
        end.attempt(record.check)
        shared = {a.name: {"sharing": None if a.sharing is None else a.sharing.told()} for a in agents}
        end.summarise(record.summary(episode.t, {"wall_time": episode.t, "agents": shared}))
    return end.result()


class _Devices:
    """The devices of all robots.

    Attributes:
        sensors: By agent, then by name.
        gates: The gates of the actuators, likewise.
        links: By agent, the links to the actuators that live in processes of their own.
    """

    def __init__(self) -> None:
        self.sensors: dict[str, dict[str, Sensor]] = {}
        self.gates: dict[str, dict[str, SafetyGate]] = {}
        self.links: dict[str, list[IsolatedActuator]] = {}

    def make(
        self,
        name: str,
        robot: RobotSpec,
        catalog: Catalog,
        clock: WallClock,
        period: float,
        sink: EventSink,
        shared: ExitStack,
        opened: ExitStack,
    ) -> None:
        """Make an agent's devices; what they share ends with `shared`, and they with `opened`."""
        host = Host(clock)
        shared.callback(host.close)
        self.sensors[name] = {
            s.name: opened.enter_context(closing(make_hardware(catalog, robot, s, host))) for s in robot.sensors
        }
        made = {a.name: opened.enter_context(closing(_actuator(catalog, robot, a, host))) for a in robot.actuators}
        self.links[name] = [device for device in made.values() if isinstance(device, IsolatedActuator)]
        self.gates[name] = {a.name: a.guard(made[a.name], clock, period, sink, name) for a in robot.actuators}


def _actuator(catalog: Catalog, robot: RobotSpec, spec: ActuatorSpec, host: Host) -> Actuator:
    """An actuator's device; of an isolated one the link to its process."""
    if spec.isolated:
        return make_isolated(catalog, robot, spec)
    device: Actuator = make_hardware(catalog, robot, spec, host)
    return device
