"""Table of the options of a run, `RunOptions`: the command line and `run` take each of its fields."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, runtime_checkable

from ..base.errors import Fault, InputError, UnknownName, unknown
from ..base.units import NOT_NEGATIVE, Count, PositiveSeconds, Seconds
from ..declare import Option, Value, given_of, options_of, replaced, values_of
from ..event import EventSink
from ..record import RunHeader, SubtreeSwap
from ..simulation.simulated_world import SimulatedWorld
from .preflight import PreflightReport
from .run_command import CommandSource
from .stop_signals import StopSignals

Build = Callable[..., Any]
"""Mission function: returns the tree or the Plan of a mission."""


@runtime_checkable
class LiveView(EventSink, CommandSource, Protocol):
    """Live view of a run, such as `rocs_bt.studio.live.LivePage`, with the commands of the people in front of it."""

    def begin(self, header: RunHeader) -> None:
        """Show the start of a run."""


class RunOptions(Value):
    """Options of a run, in simulation with `run` or on hardware with `drive`, which is always `threaded`."""

    seed: Annotated[Count, "Seed of the episode, and of random choices of missions.", Option(("--seed",))] = 1
    mode: Annotated[
        Literal["lockstep", "threaded"],
        "lockstep: simulated time, repeatable; threaded: wall time, a thread per block.",
        Option(("--mode",), stage="simulation"),
    ] = "lockstep"
    duration: Annotated[
        PositiveSeconds | None,
        "End this time after the start [s]; by default that of the scenario.",
        Option(("--for",)),
    ] = None
    out: Annotated[
        Path | None,
        "Output folder; by default runs/SCENARIO-SEED on the command line, and none in a program.",
        Option(("--out",), path="", late=True),
    ] = None
    report: Annotated[bool, "Write report.html.", Option(("--report/--no-report",), late=True)] = True
    btlog: Annotated[
        bool,
        "Write AGENT.btlog, which Groot2 replays, for each agent with a tree.",
        Option(("--btlog",), late=True),
    ] = False
    missions: Annotated[
        Mapping[str, Build] | None, "Mission functions that replace the scenario's, by agent.", Option()
    ] = None
    prepare: Annotated[
        Callable[[SimulatedWorld], None] | None,
        "Function called with the simulated world before the agents are built; it may replace devices.",
        Option(stage="simulation"),
    ] = None
    sinks: Annotated[Sequence[EventSink], "Sinks for all events.", Option(late=True)] = ()
    progress: Annotated[
        Callable[[float], None] | None, "Function called once per control period with the time [s].", Option(late=True)
    ] = None
    watch_rules: Annotated[
        bool,
        "Reload rule files that change during the run; it may then not be repeatable.",
        Option(("--watch-rules",)),
    ] = False
    knowledge: Annotated[
        Path | None,
        "File with knowledge of earlier runs; this run's replaces it.",
        Option(("--knowledge",), "FILE"),
    ] = None
    swaps: Annotated[
        tuple[SubtreeSwap, ...],
        "Replace this subtree of the mission by that of an XML mission at this time [s]; may be repeated.",
        Option(("--swap",), "NODE=FILE[:TREE]@TIME", stage="simulation"),
    ] = ()
    view: Annotated[bool, "Show MuJoCo's viewer.", Option(("--view",), stage="simulation", late=True)] = False
    video: Annotated[
        Path | None, "Render a video of the run to this file.", Option(("--video",), stage="simulation", late=True)
    ] = None
    follow: Annotated[
        str,
        "Robot that the camera of the video follows; by default it shows the whole world.",
        Option(("--follow",), "ROBOT", stage="simulation", late=True),
    ] = ""
    live: Annotated[
        LiveView | None,
        "Live page, with its context entered; the run then keeps pace with wall time.",
        Option(late=True),
    ] = None
    command: Annotated[
        str,
        "Beginning of the command line that repeats this run, for the report; else `rocs-bt run SCENARIO`.",
        Option(),
    ] = ""
    signals: Annotated[
        StopSignals | None,
        "Object that stores stop signals such as SIGTERM, for a caller that handles them after the run. Without "
        "it, a signal has its usual effect, such as a KeyboardInterrupt, once the run has been ended properly.",
        Option(late=True),
    ] = None
    wait: Annotated[
        Seconds,
        NOT_NEGATIVE,
        "Give up if a needed sensor has no fresh values for this time [s].",
        Option(("--wait",), stage="hardware"),
    ] = 10.0
    dry_run: Annotated[
        bool,
        "Send nothing to any actuator, not even neutral; the command line prints what would be sent.",
        Option(("--dry-run", "--dry"), stage="hardware"),
    ] = False
    confirm: Annotated[
        bool, "Start only when a person presses Enter, or a driver says go.", Option(("--confirm",), stage="hardware")
    ] = False
    go: Annotated[
        Callable[[], bool] | None,
        "Function called once per control period; returns whether a person said go since its last call.",
        Option(stage="hardware"),
    ] = None
    preflight: Annotated[
        Callable[[PreflightReport], None] | None,
        "Observer of the preflight check, called at each check.",
        Option(stage="hardware"),
    ] = None
    notice: Annotated[
        Callable[[str], None] | None,
        "Function called with each notice, such as that a simulator's time stopped, or that a goal of an action "
        "may go on after the run.",
        Option(stage="hardware"),
    ] = None
    control: Annotated[
        CommandSource | None,
        "Source of the commands of a person during the run: pause, step, continue ...; else the live page.",
        Option(),
    ] = None
    full_control: Annotated[
        bool, "Accept commands of the live page other than a pause.", Option(("--control",), stage="hardware")
    ] = False

    @property
    def commands(self) -> CommandSource | None:
        """Source of the commands during the run; None without."""
        return self.live if self.control is None else self.control

    def __post_init__(self) -> None:
        values, faults = values_of(self), list[Fault]()
        for name, (each, _) in options_of(RunOptions).items():
            faults += each.faults(values[name], f"the option {name}")
            if isinstance(values[name], str) and each.hint is Path:
                self.__dict__[name] = Path(values[name])
            if isinstance(values[name], list):
                self.__dict__[name] = tuple(values[name])
        if faults:
            raise InputError(*faults)
        if self.follow and self.video is None:
            raise InputError(f"a camera that follows '{self.follow}' needs a video: name its file with --video FILE.")

    def changed(self, **changes: Any) -> RunOptions:
        """These options with other values.

        Args:
            changes: New values by attribute.

        Raises:
            UnknownName: There is no such option.
            InputError: A value is invalid.
        """
        if wrong := [name for name in changes if name not in self._names]:
            raise UnknownName(*(unknown("option of a run", name, self._names) for name in wrong))
        return replaced(self, **changes)

    def refuse_other(self, stage: Literal["simulation", "hardware"]) -> None:
        """Refuse the options of the other kind of run than `stage`, except `mode`.

        Raises:
            InputError: One of them is given.
        """
        given = [name for name in given_of(self) if name != "mode"]
        if names := " and ".join(name for name in given if options_of(RunOptions)[name][1].stage not in ("", stage)):
            if stage == "hardware":
                raise InputError(f"on hardware nothing is simulated: remove the option {names}.")
            raise InputError(f"these options are for `drive` only: remove {names}.")

    def command_line(self, begin: str) -> str:
        """Command line that repeats a run with these options; `begin` is its part before the options."""
        words, given = [begin], {"seed": self.seed, **given_of(self)}
        for name, (each, option) in options_of(RunOptions).items():
            if name in given and option.flags and not option.late:
                for value in given[name] if each.many else (given[name],):
                    text = str(value).removesuffix(".0") if isinstance(value, float) else str(value)
                    words += [option.flags[0], *([] if value is True else [shlex.quote(text)])]
        return " ".join(words)


RunOptions.__doc__ = f"{RunOptions.__doc__}\n\n    Attributes:" + "".join(
    f"\n        {name}: {each.doc}" for name, (each, _) in options_of(RunOptions).items()
)
