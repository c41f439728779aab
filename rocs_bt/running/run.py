"""Run: one run of a scenario on a stage, simulated or on hardware, from its content to its files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

from msgspec.structs import replace

from ..agent import Agent, RuleWatch
from ..catalog import Catalog, ScenarioSpec
from ..errors import InputError
from ..record import AgentInfo, RunHeader, SubtreeSwap, Summary, environment_of, write_report
from ..simulation.simulated_world import SimulatedWorld
from .control import CommandDesk
from .episode import Episode, Stage
from .hardware_stage import HardwareStage
from .header import plain_header
from .memory import Memory
from .options import RunOptions
from .requirements import requirement_faults
from .run_files import RunFiles
from .run_record import RunRecord
from .run_result import RunResult
from .simulated_stage import SimulatedStage
from .sink_thread import Relay, SinkThread
from .stop_signals import EndedAtOnce, StopSignals
from .summary import Unrecorded
from .swaps import SwapSchedule, swapped_content

_DEFAULTS = RunOptions()


class RunStage(Stage, Protocol):
    """Stage with the agents of a scenario."""

    @property
    def agents(self) -> Sequence[Agent]:
        """Agents of the scenario."""
        ...

    @property
    def swaps(self) -> Sequence[SubtreeSwap]:
        """Swaps of subtrees at given times."""
        ...

    @property
    def start(self) -> float:
        """Time of the first control period [s]; valid after `ready`."""
        ...

    def ready(self, ended: Callable[[], str]) -> bool:
        """Wait until the run may start; False if a signal ended it before."""
        ...

    def describe(self, header: RunHeader, recalled: Mapping[str, str]) -> RunHeader:
        """Complete the header of the run by the command that repeats it, and by what figures show."""
        ...


class Run:
    """One run of a scenario.

        result = Run(spec, catalog, options).conduct()

    `conduct` does `prepare`, `play` and `finish`, and closes everything, however the run ends: the robots go to neutral
    first, then the files are completed. A check of a scenario only prepares, and closes.

    Args:
        spec: The scenario.
        catalog: Source of the content.
        options: Options of the run.
        on_hardware: Whether the robots themselves are the stage; else their world is simulated.

    Attributes:
        stage: Stage of the run, from `prepare` on.

    Raises:
        InputError: An option is for the other kind of stage.
    """

    stage: RunStage
    header: RunHeader

    def __init__(
        self, spec: ScenarioSpec, catalog: Catalog, options: RunOptions = _DEFAULTS, *, on_hardware: bool = False
    ) -> None:
        options.refuse_simulation() if on_hardware else options.refuse_hardware()
        self.spec = spec
        self.catalog = catalog
        self.options = options
        self._on_hardware = on_hardware
        self._files = RunFiles(None if options.out is None else Path(options.out))
        self._signals = StopSignals() if options.signals is None else options.signals
        self._relay = Relay()
        self._stack = ExitStack()  # closes all that was opened, before the report is written
        self._summary: Summary | None = None
        self._failure: Exception | None = None
        self._page: Path | None = None

    def conduct(self) -> RunResult:
        """Prepare, play and finish the run, and write its report.

        Raises:
            InputError: The content is invalid; nothing was written.
            DeviceError: A driver cannot reach its device, or a needed sensor gave no fresh values in time.
            RocsError: The engine failed.
            EndedAtOnce: A second signal was received; its note names the missing files.
            KeyboardInterrupt: A signal ended the run.
        """
        try:
            with ExitStack() as last:
                last.callback(self._files.unlock)  # after the report
                last.enter_context(self._signals)
                try:
                    with self._stack:
                        self.prepare()
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
        return self._result()

    def prepare(self) -> None:
        """Build the stage, the agents and the header. Nothing is written, and no robot moves.

        Raises:
            InputError: The content is invalid.
            DeviceError: A driver cannot reach its device.
        """
        spec, catalog, options = self.spec, self.catalog, self.options
        if self._on_hardware:
            self.stage = HardwareStage(spec, catalog, options, self._relay, self._stack, self._ended)
        else:
            self.stage = SimulatedStage.of(spec, catalog, options, self._relay)
        stage, agents = self.stage, self.stage.agents
        for agent in agents:
            self._stack.callback(agent.close)
        self._memory = Memory(options.knowledge, agents)
        self._stack.callback(self._files.attempt, "the knowledge", self._memory.close)
        self._swaps = SwapSchedule(stage.swaps, agents, catalog)
        files = [(agent.name, file) for agent in agents for file in agent.rule_files]
        self._rules = RuleWatch(files, stage.clock, self._relay, watching=options.watch_rules)
        self.header = plain_header(
            spec,
            agents,
            seed=options.seed,
            mode="lockstep" if stage.time_stops else "threaded",
            digest=catalog.digest(spec, swapped_content(stage.swaps, spec, catalog)),
            swaps=tuple(stage.swaps),
            simulated=not self._on_hardware,
        )
        refuse_requirements(spec, self.header.agents)

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
        self.header = replace(self.header, start=stage.start)
        self._begin()
        heard = [*([] if options.live is None else [options.live]), *options.sinks]
        record = self._record = RunRecord(self.header, self._files.recorder, heard, batched=lockstep)
        self._stack.callback(record.flush)
        self._memory.start(f"{self.spec.name}-{options.seed}", patient=lockstep)
        only_pause = self._on_hardware and not options.full_control
        desk = CommandDesk(options.commands, self._swaps, self._rules, self._relay, stage, only_pause=only_pause)

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
        self._episode = episode = Episode(
            stage, stage.agents, self._relay, duration=limit, start=stage.start, between=between, ended=self._ended
        )
        self._attempt(lambda: self._play(episode, record, ready))

    def _play(self, episode: Episode, record: RunRecord, ready: bool) -> None:
        if self.stage.time_stops:
            self._relay.open(record.sink)
            episode.run()
            return
        with SinkThread(record.sink) as thread, self._rules:
            self._relay.open(thread)
            episode.run() if ready else episode.interrupt()

    def finish(self) -> None:
        """Make the summary, and complete the recording with it."""
        self._attempt(self._record.check)
        self._files.attempt("the knowledge", self._memory.close)
        result, agents = self._episode.result(), self.stage.agents
        sharing = {a.name: None if a.sharing is None else a.sharing.statistics() for a in agents}
        unrecorded = Unrecorded(result.wall_time, result.trajectory_hash, sharing, self._memory.summary())
        self._summary = self._record.summary(self._episode.t, unrecorded)
        self._files.end(self._summary)

    def close(self) -> None:
        """Close what `prepare` has opened, of a run that is not played."""
        self._stack.close()

    def _begin(self) -> None:
        """Begin the live page and the files of the run, if requested."""
        live = self.options.live
        if live is None and self.options.out is None:
            return
        self.header = self.stage.describe(self.header, self._memory.recalled)
        if live is not None:
            live.begin(self.header)
        self._files.begin(self.header, self.stage.agents if self.options.btlog else ())
        self._stack.callback(self._files.abandon)

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


def refuse_requirements(spec: ScenarioSpec, agents: Sequence[AgentInfo]) -> None:
    """Check that the scenario's requirements use only signals that their agents have.

    Raises:
        InputError: A requirement does not fit its agent; lists every fault.
    """
    faults = [f for info in agents for f in requirement_faults(spec, info.name, environment_of(info, truth=True))]
    if faults:
        raise InputError(*dict.fromkeys(faults))
