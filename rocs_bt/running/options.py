"""Options of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, get_type_hints

import msgspec

from ..base.errors import InputError, UnknownName, unknown
from ..base.units import FINITE, NOT_NEGATIVE, POSITIVE, Bounds
from ..event import EventSink
from ..record import RunHeader, SubtreeSwap
from ..simulation.simulated_world import SimulatedWorld
from .command import Control
from .preflight import PreflightReport
from .stop_signals import StopSignals

MODES = ("lockstep", "threaded")

Build = Callable[..., Any]
"""Mission function: returns the tree or the Plan of a mission."""


class Option(msgspec.Struct, frozen=True):
    """Declaration of an option of a run: what its documentation and the command line need.

    Attributes:
        help: Meaning of the option.
        flags: Names on the command line, such as `--for`; empty if only programs give the option.
        metavar: Name of the value on the command line.
        bounds: Range of valid numbers; a number that is not whole is a time [s].
        choices: Possible values of a text.
        stage: Kind of run that has the option, `simulation` or `hardware`; empty for both.
    """

    help: str
    flags: tuple[str, ...] = ()
    metavar: str | None = None
    bounds: Bounds = FINITE
    choices: tuple[str, ...] = ()
    stage: Literal["", "simulation", "hardware"] = ""


class LiveView(EventSink, Control, Protocol):
    """Live view of a run, such as `rocs_bt.studio.live.LivePage`, with the commands of the people in front of it."""

    def begin(self, header: RunHeader) -> None:
        """Show the start of a run."""
        ...


class RunOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Options of a run, in simulation with `run` or on hardware with `drive`, which is always `threaded`."""

    seed: Annotated[
        int, Option("Seed of the episode, and of random choices of missions.", ("--seed",), bounds=NOT_NEGATIVE)
    ] = 1
    mode: Annotated[
        str,
        Option(
            "lockstep: simulated time, repeatable; threaded: wall time, a thread per block.",
            ("--mode",),
            choices=MODES,
            stage="simulation",
        ),
    ] = "lockstep"
    duration: Annotated[
        float | None,
        Option("End this time after the start [s]; by default that of the scenario.", ("--for",), bounds=POSITIVE),
    ] = None
    out: Annotated[
        Path | str | None,
        Option("Output folder; by default runs/SCENARIO-SEED on the command line, and none in a program.", ("--out",)),
    ] = None
    report: Annotated[bool, Option("Write report.html.", ("--report/--no-report",))] = True
    btlog: Annotated[
        bool, Option("Write AGENT.btlog, which Groot2 replays, for each agent with a tree.", ("--btlog",))
    ] = False
    missions: Annotated[
        Mapping[str, Build] | None, Option("Mission functions that replace the scenario's, by agent.")
    ] = None
    prepare: Annotated[
        Callable[[SimulatedWorld], None] | None,
        Option(
            "Function called with the simulated world before the agents are built; it may replace devices.",
            stage="simulation",
        ),
    ] = None
    sinks: Annotated[Sequence[EventSink], Option("Sinks for all events.")] = ()
    progress: Annotated[
        Callable[[float], None] | None, Option("Function called once per control period with the time [s].")
    ] = None
    watch_rules: Annotated[
        bool,
        Option("Reload rule files that change during the run; it may then not be repeatable.", ("--watch-rules",)),
    ] = False
    knowledge: Annotated[
        Path | None, Option("File with knowledge of earlier runs; this run's is added.", ("--knowledge",), "FILE")
    ] = None
    swaps: Annotated[
        Sequence[SubtreeSwap],
        Option(
            "Replace this subtree of the mission by that of an XML mission at this time [s]; may be repeated.",
            ("--swap",),
            "NODE=FILE[:TREE]@TIME",
            stage="simulation",
        ),
    ] = ()
    view: Annotated[bool, Option("Show MuJoCo's viewer.", ("--view",), stage="simulation")] = False
    video: Annotated[
        Path | None, Option("Render a video of the run to this file.", ("--video",), stage="simulation")
    ] = None
    follow: Annotated[
        str,
        Option(
            "Robot that the camera of the video follows; by default it shows the whole world.",
            ("--follow",),
            "ROBOT",
            stage="simulation",
        ),
    ] = ""
    live: Annotated[
        LiveView | None,
        Option("Live page, with its context entered; the run then keeps pace with wall time."),
    ] = None
    command: Annotated[
        str, Option("Command line that repeats this run, for the report; by default that of `rocs-bt`.")
    ] = ""
    signals: Annotated[
        StopSignals | None,
        Option(
            "Object that stores stop signals such as SIGTERM, for a caller that handles them after the run. Without "
            "it, a signal has its usual effect, such as a KeyboardInterrupt, once the run has been ended properly."
        ),
    ] = None
    wait: Annotated[
        float,
        Option(
            "Give up if a needed sensor has no fresh values for this time [s].",
            ("--wait",),
            bounds=NOT_NEGATIVE,
            stage="hardware",
        ),
    ] = 10.0
    dry_run: Annotated[
        bool,
        Option(
            "Send nothing to any actuator, not even neutral; the command line prints what would be sent.",
            ("--dry-run", "--dry"),
            stage="hardware",
        ),
    ] = False
    confirm: Annotated[
        bool, Option("Start only when a person presses Enter, or a driver says go.", ("--confirm",), stage="hardware")
    ] = False
    go: Annotated[
        Callable[[], bool] | None,
        Option(
            "Function called once per control period; returns whether a person said go since its last call.",
            stage="hardware",
        ),
    ] = None
    preflight: Annotated[
        Callable[[PreflightReport], None] | None,
        Option("Observer of the preflight check, called at each check.", stage="hardware"),
    ] = None
    notice: Annotated[
        Callable[[str], None] | None,
        Option(
            "Function called with each notice, such as that a simulator's time stopped, or that a goal of an action "
            "may go on after the run.",
            stage="hardware",
        ),
    ] = None
    control: Annotated[
        Control | None,
        Option("Source of the commands of a person during the run: pause, step, continue ...; else the live page."),
    ] = None
    full_control: Annotated[
        bool,
        Option("Accept commands of the live page other than a pause.", ("--control",), stage="hardware"),
    ] = False

    @property
    def commands(self) -> Control | None:
        """Source of the commands during the run; None without."""
        return self.live if self.control is None else self.control

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise InputError(f"unknown mode '{self.mode}'. Modes: {', '.join(MODES)}.")
        if self.follow and self.video is None:
            raise InputError(f"a camera that follows '{self.follow}' needs a video: name its file with --video FILE.")
        for name, (_, each) in declared_options().items():
            value = getattr(self, name)
            if isinstance(value, (int, float)) and not each.bounds.admit(value):
                raise InputError(f"the option {name} must be {each.bounds}, found {value:g}.")

    def changed(self, **changes: Any) -> RunOptions:
        """These options with other values.

        Args:
            changes: New values by attribute.

        Raises:
            UnknownName: There is no such option.
            InputError: A value is invalid.
        """
        if wrong := [name for name in changes if name not in self.__struct_fields__]:
            raise UnknownName(*(unknown("option of a run", name, self.__struct_fields__) for name in wrong))
        return msgspec.structs.replace(self, **changes)

    def refuse_simulation(self) -> None:
        """Refuse the options that need a simulated world.

        Raises:
            InputError: One of them is given.
        """
        if names := self._given("simulation", apart=("mode",)):
            raise InputError(f"on hardware nothing is simulated: remove the option {' and '.join(names)}.")

    def refuse_hardware(self) -> None:
        """Refuse the options that need hardware.

        Raises:
            InputError: One of them is given.
        """
        if names := self._given("hardware"):
            raise InputError(f"these options are for `drive` only: remove {' and '.join(names)}.")

    def _given(self, stage: str, apart: tuple[str, ...] = ()) -> list[str]:
        """Options of a kind of run with another value than their default."""
        found = [name for name, (_, each) in declared_options().items() if each.stage == stage and name not in apart]
        return [name for name in found if (value := getattr(self, name)) and value != getattr(_DEFAULTS, name)]


@cache
def declared_options() -> Mapping[str, tuple[Any, Option]]:
    """Type and declaration of each option of a run, by attribute of `RunOptions`."""
    hints = get_type_hints(RunOptions, include_extras=True)
    return {name: (hints[name].__origin__, hints[name].__metadata__[0]) for name in RunOptions.__struct_fields__}


_DEFAULTS = RunOptions()
RunOptions.__doc__ = f"{RunOptions.__doc__}\n\n    Attributes:" + "".join(
    f"\n        {name}: {each.help}" for name, (_, each) in declared_options().items()
)
