"""Simulated run of a scenario, with outcome and files (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from ..catalog import Catalog, ScenarioSpec
from ..simulation.pace import Pace
from ..simulation.simulated_world import SimulatedWorld
from .header import run_command, with_scenery
from .memory import Memory
from .options import RunOptions
from .ready_run import ReadyRun, set_up
from .run_end import RunEnd
from .run_files import ReportWriter
from .run_record import RunRecord
from .run_result import RunResult


def simulate(spec: ScenarioSpec, catalog: Catalog, options: RunOptions, write_report: ReportWriter) -> RunResult:
    """Simulate a scenario; see `rocs_bt.run`.

    Args:
        spec: The scenario.
        catalog: Source of the content.
        options: Options of the run.
        write_report: Writes report.html.

    Raises:
        InputError: The content is invalid; nothing was written.
        RocsError: The engine failed.
        KeyboardInterrupt: A signal ended the run.
    """
    options.refuse_hardware()
    end = RunEnd(options, write_report)
    with end.guarded() as stack:  # callbacks of this stack run before the report is written
        end.listen()
        ready = set_up(spec, catalog, options)
        for agent in ready.agents:
            stack.callback(agent.close)
        memory = Memory(options.knowledge, ready.agents)
        stack.callback(end.files.attempt, "the knowledge", memory.close)
        # All checks that can still fail come before the files of an earlier run in the folder are replaced.
        watch = _watchers(stack, ready.simulated, options)
        _begin(stack, end, ready, memory, options)
        heard = [*([] if options.live is None else [options.live]), *options.sinks]
        record = RunRecord(ready.header, end.files.recorder, heard, batched=ready.clock is None)
        stack.callback(record.flush)
        memory.start(f"{spec.name}-{options.seed}", patient=ready.clock is None)
        episode = ready.episode(options.duration, record.before(watch), lambda: end.signals.reason)
        end.attempt(lambda: ready.play(episode, record.sink))
        end.attempt(record.check)
        end.files.attempt("the knowledge", memory.close)
        end.summarise(ready.summary(record, episode, memory))
    return end.result()


def _begin(stack: ExitStack, end: RunEnd, ready: ReadyRun, memory: Memory, options: RunOptions) -> None:
    """Begin the live page and the files of the run, if requested."""
    live = options.live
    if live is None and options.out is None:
        return
    spec = ready.spec
    again = options.command or run_command(spec.name, options.seed, options.mode, options.duration, ready.header.swaps)
    header = with_scenery(ready.header, spec, ready.simulated, command=again, recalled=memory.recalled)
    if live is not None:
        live.begin(header)
    end.files.begin(header, ready.agents if options.btlog else ())
    stack.callback(end.files.abandon)


def _watchers(stack: ExitStack, simulated: SimulatedWorld, options: RunOptions) -> Callable[[float], bool]:
    """Combined observer of the run, called once per control period; False if the viewer's window was closed."""
    watchers: list[Callable[[float], bool]] = []
    if options.view:
        from ..simulation.viewer import Viewer

        watchers.append(stack.enter_context(Viewer(simulated.world)))
    if options.video is not None:
        from ..simulation.video import Video

        watchers.append(stack.enter_context(Video(simulated.world, options.video, follow=options.follow)))
    if options.live is not None:
        watchers.append(Pace())
    progress = options.progress

    def watch(t: float) -> bool:
        if progress is not None:
            progress(t)
        going = [watcher(t) for watcher in watchers]  # a list, so that every observer is called
        return all(going)

    return watch
