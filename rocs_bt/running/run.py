"""Run: one run of a scenario on a stage, simulated or on hardware, from its content to its files."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from ..agent import Agent, RuleWatch
from ..base.errors import Fault, InputError, collected, unknown
from ..base.files import read_once
from ..catalog import Catalog, ScenarioSpec
from ..declare import options_of
from ..expression import Environment
from ..record import TRUTH, RunHeader, Summary, write_report
from ..simulation.simulated_world import SimulatedWorld
from .build_agents import worldless_agents
from .control import CommandDesk, taken_commands
from .hardware_devices import on_hardware
from .hardware_stage import HardwareStage
from .header import guards_of, plain_header, with_scenery, without_world
from .memory import Memory
from .requirements import requirement_faults
from .run_files import RunFiles
from .run_loop import RunLoop, Stage
from .run_options import RunOptions
from .run_record import RunRecord
from .run_result import RunResult
from .simulated_stage import SimulatedStage
from .sink_thread import Relay, SinkThread
from .stop_signals import EndedAtOnce, StopSignals
from .summary import Unrecorded
from .swaps import SwapSchedule, rehearse_swaps, swapped_content

_DEFAULTS = RunOptions()


class Run:
    """One run of a scenario.

        result = Run(spec, catalog, options).conduct()

    `conduct` does `prepare`, `play` and `finish`, and closes everything, however the run ends: the robots go to neutral
    first, then the files are completed. A check is `prepare` with a list of faults; the run then goes on with what its
    check has built.

    Args:
        spec: The scenario.
        catalog: Source of the content.
        options: Options of the run.
        on_hardware: Whether the robots themselves are the stage; else their world is simulated.

    Attributes:
        stage: Stage of the run, from `prepare` on.
        agents: Agents that `prepare` has built.
        prepared: Whether `prepare` has built stage and agents without errors.

    Raises:
        InputError: An option is for the other kind of stage.
    """

    stage: Stage
    header: RunHeader

    def __init__(
        self, spec: ScenarioSpec, catalog: Catalog, options: RunOptions = _DEFAULTS, *, on_hardware: bool = False
    ) -> None:
        options.refuse_other("hardware" if on_hardware else "simulation")
        self.spec = spec
        self.catalog = catalog
        self._take(options)
        self.agents: Sequence[Agent] = ()
        self.prepared = False
        self._opened = self._over = False
        self._on_hardware = on_hardware
        self._relay = Relay()
        self._stack = ExitStack()  # closes all that was opened, before the report is written
        self._summary: Summary | None = None
        self._failure: Exception | None = None
        self._page: Path | None = None

    def conduct(self, **later: Any) -> RunResult:
        """Prepare the run unless it is prepared, play and finish it, and write its report.

        Args:
            later: Options of the run that replace those of `options`; for a run that is prepared, only those that do
                not affect its preparation, such as `live`.

        Raises:
            InputError: The content is invalid, the run was conducted before, or an option is unknown or comes too late;
                nothing was written.
            DeviceError: A driver cannot reach its device, or a needed sensor gave no fresh values in time.
            RocsError: The engine failed.
            EndedAtOnce: A second signal was received; its note names the missing files.
            KeyboardInterrupt: A signal ended the run.
        """
        self._refuse_again()
        options = self.options.changed(**later)
        if self.prepared and (late := [name for name in later if not options_of(RunOptions)[name][1].late]):
            given = " and ".join(f"{name} = {getattr(self.options, name)!r}" for name in late)
            raise InputError(f"the run is prepared with {given} already. Make a Run with other options.")
        self._take(options)
        try:
            with ExitStack() as last:
                last.callback(self._files.unlock)  # after the report
                last.enter_context(self._signals)
                try:
                    with self._stack:
                        if not self.prepared:
                            self.prepare()
                        if not self._opened:
                            self.open()
                        self.play()
                        self.finish()
                except Exception as error:  # such as a device that fails to close: the report is still written
                    if self._summary is None:
                        raise
                    self._failure = self._failure or error
                if self._summary is not None and self.options.report:
                    self._attempt(self._write_report)
        except EndedAtOnce as error:
            if text := self._files.unfinished:
                error.add_note(text)
            raise
        finally:
            self._over = True
        return self._result()

    def _refuse_again(self) -> None:
        if self._over:
            raise InputError("this run was conducted or closed before. Make another Run, of the same spec and options.")

    def _take(self, options: RunOptions) -> None:
        self.options = options
        self._files = RunFiles(options.out)
        self._signals = StopSignals() if options.signals is None else options.signals

    def prepare(self, faults: list[Fault] | None = None) -> None:
        """Build the stage and the agents. Nothing is written, and no robot moves.

        Args:
            faults: List to which the errors and warnings of a check are added. No device of hardware is opened then: if
                the world cannot be built, or the robots are real, `agents` are those that can be built without it. By
                default the first errors are raised, and missions are not checked.

        Raises:
            InputError: The content is invalid.
            DeviceError: A driver cannot reach its device.
        """
        self._refuse_again()
        with read_once(), collected(faults):
            for name in sorted((self.options.missions or {}).keys() - {agent.name for agent in self.spec.agents}):
                raise InputError(unknown("agent of the option 'missions'", name, [a.name for a in self.spec.agents]))
            if faults is None or self._simulated():
                self._set_up(faults)
        if faults is not None and not self.agents:
            missions = self.options.missions
            with read_once():
                self.agents = worldless_agents(self.spec, self.catalog, seed=1, missions=missions, faults=faults)
            self._own(self.agents)
        wrong = [fault for agent in self.agents for fault in _requirement_faults(self.spec, agent)]
        if faults is not None:
            faults += wrong
        elif wrong:
            raise InputError(*dict.fromkeys(wrong))
        self.prepared = hasattr(self, "stage") and all(fault.warning for fault in faults or ())

    def open(self) -> None:
        """Apply the options of a prepared run that name files: knowledge, swaps and changes of rules; make the header.

        Raises:
            InputError: A swap is not possible, or the file of knowledge has faults.
            RecordingError: The file of knowledge cannot be written.
        """
        spec, catalog, options, stage, agents = self.spec, self.catalog, self.options, self.stage, self.agents
        self._memory = Memory(options.knowledge, agents)
        self._stack.callback(self._remember)
        limit = spec.duration if options.duration is None else options.duration
        swaps = rehearse_swaps(
            options.swaps, spec, catalog, seed=options.seed, duration=limit, missions=options.missions
        )
        self._swaps = SwapSchedule(swaps, agents, catalog)
        files = [(agent.name, file) for agent in agents for file in agent.reloadable_rules]
        named = {agent.name: agent for agent in agents}
        self._rules = RuleWatch(
            files,
            stage.clock,
            self._relay,
            watching=options.watch_rules,
            describe=lambda agent, rules: guards_of(named[agent], rules),
        )
        self.header = plain_header(
            spec,
            agents,
            seed=options.seed,
            mode="lockstep" if stage.time_stops else "threaded",
            digest=catalog.digest(spec, swapped_content(swaps, spec, catalog)),
            swaps=swaps,
            simulated=not self._on_hardware,
        )
        self._opened = True

    def _simulated(self) -> bool:
        """Whether the robots can be simulated, without code that may not run and without drivers for hardware."""
        robots = [self.catalog.load_robot(name) for name in self.spec.robots]
        robots += [self.catalog.robot_of(agent) for agent in self.spec.agents if agent.overlay]
        code = self.catalog.code or not any(robot.code for robot in robots)
        return code and not self._on_hardware and not any(on_hardware(self.catalog, robot) for robot in robots)

    def _own(self, agents: Sequence[Agent]) -> None:
        for agent in agents:
            self._stack.callback(agent.close)

    def _set_up(self, faults: list[Fault] | None) -> None:
        spec, catalog, options = self.spec, self.catalog, self.options
        if self._on_hardware:
            self.stage = HardwareStage(spec, catalog, options, self._relay, self._stack, self._ended)
        else:
            self.stage = SimulatedStage.of(spec, catalog, options, self._relay, faults)
        self.agents = self.stage.agents
        self._own(self.agents)

    @property
    def world(self) -> SimulatedWorld:
        """Simulated world of the stage; only after `prepare`, and not on hardware."""
        if not isinstance(self.stage, SimulatedStage):
            raise InputError("a run on hardware has no simulated world.")
        return self.stage.simulated

    def play(self) -> None:
        """Wait until the robots may start, begin the files, and play all control periods.

        All checks that can still fail come before the files of an earlier run in the folder are replaced.

        Raises:
            DeviceError: A needed sensor gave no fresh values in time.
        """
        stage, options, lockstep = self.stage, self.options, self.stage.time_stops
        watch = stage.observers(self._stack, options) if isinstance(stage, SimulatedStage) else lambda t: True
        ready = stage.ready(self._ended)
        taken = (
            taken_commands(lockstep, self._on_hardware, options.full_control) if options.commands is not None else ()
        )
        self.header = replace(self.header, start=stage.start, commands=taken)
        self._begin()
        heard = [*([] if options.live is None else [options.live]), *options.sinks]
        record = self._record = RunRecord(self.header, self._files.recorder, heard, batched=lockstep)
        self._stack.callback(record.flush)
        self._memory.start()
        desk = CommandDesk(options.commands, taken, self._swaps, self._rules, self._relay, stage)

        def between(t: float) -> bool:
            if lockstep:  # else a thread watches the rule files, so that control never waits for a file
                self._rules.check()
            self._swaps.step(t)
            desk.period(self._ended)
            record.flush()
            record.check()
            if options.progress is not None:
                options.progress(t - stage.start)
            return watch(t)

        limit = self.spec.duration if options.duration is None else options.duration
        self._loop = loop = RunLoop(
            stage, stage.agents, self._relay, duration=limit, start=stage.start, between=between, ended=self._ended
        )
        self._attempt(lambda: self._play(loop, record, ready))

    def _play(self, loop: RunLoop, record: RunRecord, ready: bool) -> None:
        if self.stage.time_stops:
            self._relay.open(record.sink)
            loop.run()
            return
        with SinkThread(record.sink) as thread, self._rules:
            self._relay.open(thread)
            loop.run() if ready else loop.interrupt()

    def finish(self) -> None:
        """Make the summary, and complete the recording with it."""
        self._attempt(self._record.check)
        self._remember()
        result, agents = self._loop.result(), self.stage.agents
        sharing = {a.name: None if a.sharing is None else a.sharing.statistics() for a in agents}
        unrecorded = Unrecorded(result.wall_time, result.trajectory_hash, sharing, self._memory.summary())
        self._summary = self._record.summary(self._loop.t, unrecorded)
        self._files.end(self._summary)

    def close(self) -> None:
        """Close what `prepare` has opened, of a run that is not played."""
        self._over = True
        self._stack.close()

    def _begin(self) -> None:
        """Begin the live page and the files of the run, if requested."""
        live = self.options.live
        if live is None and self.options.out is None:
            return
        spec, stage, options = self.spec, self.stage, self.options
        begin = options.command or f"rocs-bt {'drive' if self._on_hardware else 'run'} {shlex.quote(spec.name)}"
        command = options.changed(swaps=self.header.swaps).command_line(begin)
        header = replace(self.header, command=command, recalled=self._memory.recalled)
        if isinstance(stage, HardwareStage):
            self.header = without_world(header, spec, stage.robots)
        else:
            self.header = with_scenery(header, spec, self.world)
        if live is not None:
            live.begin(self.header)
        self._files.begin(self.header, self.stage.agents if self.options.btlog else ())
        self._stack.callback(self._files.abandon)

    def _remember(self) -> None:
        """Write the file of knowledge, unless it is written already or the robots never started."""
        self._files.attempt(f"the knowledge '{self.options.knowledge}'", self._memory.write)

    def _ended(self) -> str:
        return self._signals.reason

    def _attempt(self, step: Callable[[], object]) -> None:
        """Do a step of the run, and keep its exception, which is raised after all files are written."""
        try:
            step()
        except Exception as error:  # noqa: BLE001 - boundary: `_result` raises it
            self._failure = self._failure or error

    def _write_report(self) -> None:
        if self._summary is not None:
            self._page = self._files.report(write_report, self._summary)

    def _result(self) -> RunResult:
        """Result of the run; raises its first exception, with the result as a note."""
        if self._summary is None:
            raise RuntimeError("the run ended without a summary")
        files = self._files
        result = RunResult(
            summary=self._summary, recording=files.recording, report=self._page, missing=tuple(files.missing)
        )
        if self._failure is not None:
            self._failure.add_note(f"{result}" + ("" if self._page is None else f"\nReport: {self._page}"))
            raise self._failure
        if self.options.signals is None:
            self._signals.deliver()
        return result


def _requirement_faults(spec: ScenarioSpec, agent: Agent) -> list[Fault]:
    """Faults of requirements that use signals which their agent has not."""
    signals = agent.knowledge.signals
    known = Environment.packed([*(signals.spec(name) for name in signals.names), *TRUTH])
    return requirement_faults(spec, agent.name, known)
