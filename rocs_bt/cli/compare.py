"""`rocs-bt compare`: compare planners or robots over scenes and seeds, with statistical verdicts."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from ..base.errors import Fault, InputError
from ..base.files import check_writable, write_whole
from ..base.registered import load
from ..base.units import Bounds, Count
from ..base.words import counted
from ..catalog import Catalog
from ..declare import Option
from .compare_cold import cold_plan, print_cold
from .content import json_option, no_code_option
from .options import EpisodeOptions, declared_options
from .progress import ProgressBar
from .terminal import echo, show_table, show_warnings

if TYPE_CHECKING:
    from ..compare import Comparison
    from ..compare.cold import Loss, StrengthWalk
    from ..compare.episode import SceneRef
    from ..compare.metric import Metric
    from ..compare.record import EpisodeRecord
    from ..compare.statistics import Estimate
    from ..compare.verdict import Verdict

_ERRORS = 3  # maximum number of printed errors
_WIDE = 1000  # characters, wider than any table


class CompareOptions(EpisodeOptions):
    """Options of the command."""

    robots: Annotated[tuple[str, ...], "Play with this robot instead; may be repeated.", Option(("--robot",))] = ()
    families: Annotated[tuple[str, ...], "Use scenes of this family; may be repeated.", Option(("--family",))] = ()
    count: Annotated[int, Bounds(1), "Number of scenes of each family.", Option(("--scenes",))] = 20
    first: Annotated[Count, "Index of the first scene.", Option(("--from",))] = 0
    given: Annotated[
        tuple[str, ...], "A parameter of the families, with its unit.", Option(("--set",), "NAME=VALUE")
    ] = ()
    scenario: Annotated[
        tuple[str, ...], "A scenario, or a scene such as barn_like-17; may be repeated.", Option(("--scenario",))
    ] = ()
    agent: Annotated[
        str, "Agent that the planner controls in such a scenario; by default the first.", Option(("--agent",))
    ] = ""
    seeds: Annotated[int, Bounds(1), "Seeds of each scene: 1, 2, ...", Option(("--seeds",))] = 3
    metrics: Annotated[
        tuple[str, ...], "Judge by this metric; by default success, collision and time.", Option(("--metric",))
    ] = ()
    early: Annotated[
        bool,
        "Stop as soon as every pair has a verdict; verdicts stay valid (anytime tests).",
        Option(("--stop-early",)),
    ] = False
    cold: Annotated[bool, "Also play with each perturbation of the robot, and print the loss.", Option(("--cold",))] = (
        False
    )
    perturb: Annotated[
        tuple[str, ...],
        "As --cold, but with this perturbation; may be repeated.",
        Option(("--perturb",), "NAME[=STRENGTH]"),
    ] = ()
    outward: Annotated[bool, "Make each perturbation stronger until the planner breaks.", Option(("--outward",))] = (
        False
    )
    cluster: Annotated[
        str | None, "Play on the Dask cluster with this scheduler.", Option(("--cluster",), "ADDRESS")
    ] = None
    retry_errors: Annotated[
        bool, "Play episodes again that ended in an error or at the limit.", Option(("--retry-errors",))
    ] = False
    report: Annotated[Path | None, "Write a report as one HTML page.", Option(("--report",))] = None
    markdown: Annotated[Path | None, "Write the tables of the report in Markdown.", Option(("--markdown",))] = None
    export: Annotated[Path | None, "Write the episodes as JSON lines.", Option(("--export",))] = None


@click.command()
@click.argument("planners", nargs=-1)
@declared_options(CompareOptions)
@json_option("Print results and verdicts as JSON; equal content gives equal bytes.")
@no_code_option
def command(planners: Sequence[str], as_json: bool, no_code: bool, **options: Any) -> int:
    """Compare PLANNERS, or robots, in the same scenes with the same seeds, with statistical verdicts.

    With --robot, each planner is compared on each of the robots, as PLANNER@ROBOT; without PLANNERS, the robots are
    compared in the mission and with the rules of the scenario itself. PLANNERS may also be such pairs.

    With --cold, each planner is also played on robots that differ from its model of them, and the loss is printed: in
    body, noise, delay, wheel radius or friction, with an odometer instead of the true pose, or with lost scans.

    An interrupted comparison continues where it stopped when called again. Exits with 1 if an episode ended in an
    error or content raised an exception.
    """
    from ..compare import Comparison, EpisodeStore, SweepOptions, sweep
    from ..compare.metric import DEFAULT_METRICS, metric

    given, catalog = CompareOptions(**options), Catalog.here(code=not no_code)
    judged, seeds, early = given.metrics or DEFAULT_METRICS, given.seeds, given.early
    for name in judged:
        metric(name)
    planners = _named(planners, given.robots, early=early)
    indices = range(given.first, given.first + given.count)
    places = [*_of_families(given.families, indices, given.given), *_by_name(given.scenario, given.agent, catalog)]
    if not places:
        raise InputError(Fault("no scenes given.", hint="Add --family barn_like, or --scenario exp1."))
    _create_folders(given.report, given.markdown, given.export)
    cold = given.cold or given.perturb or given.outward
    plan = cold_plan(planners, places, catalog, given.perturb, early=early) if cold else None
    chosen = [catalog.load_planner(name) for name in planners] if plan is None else plan.planners
    total = len(chosen) * len(places) * seeds
    how = SweepOptions(
        workers=given.jobs,
        wall_limit=given.wall_limit,
        retry_errors=given.retry_errors,
        warned=show_warnings,
        stop_when=(lambda records: Comparison(records).settled(judged)) if early else None,
    )
    with ExitStack() as stack:
        kept = stack.enter_context(EpisodeStore(given.store))
        cluster = None if given.cluster is None else load("rocs_bt.services", "cluster")(given.cluster)
        executor = None if cluster is None else stack.enter_context(cluster)
        progress = stack.enter_context(ProgressBar(" ".join(planners), total, "episodes"))
        found = sweep(
            chosen,
            places,
            range(1, seeds + 1),
            catalog=catalog,
            store=kept,
            executor=executor,
            options=how,
            progress=progress,
        )
        if given.export is not None:
            kept.export(given.export, found.keys)
        records = list(found.records())
        every = Comparison(records)
        comparison = every if plan is None else Comparison(each for each in records if "~" not in each.planner)
        walks = () if plan is None or not given.outward else plan.walk(every, places, seeds, kept, executor, how)
    losses = () if plan is None else plan.losses(every, judged)
    verdicts = comparison.verdicts(judged, any_time=early)
    _write(given, comparison, verdicts, judged, catalog, losses, walks)
    if as_json:
        more = {} if plan is None else plan.as_dict(losses, walks)
        _print_json(records, verdicts, more)
    else:
        _print(comparison, judged, verdicts, f"{found.played} played now, {len(records) - found.played} before")
        print_cold(losses, walks)
        _print_errors(records)
        if given.report is not None:
            echo(f"Report: {given.report}")
    return int(any(map(_is_broken, records)))


def _named(planners: Sequence[str], robots: Sequence[str], *, early: bool) -> Sequence[str]:
    """Names of the planners to compare, each on each of the robots if any are given; raises InputError."""
    if not planners and not robots:
        raise InputError(Fault("nothing to compare.", hint="Name planners, or robots: --robot pioneer_p3dx."))
    if robots:
        planners = [f"{planner}@{robot}" for planner in planners or [""] for robot in robots]
    if early and len(planners) < 2:
        hint = "Give two, or remove --stop-early."
        raise InputError(Fault("--stop-early needs at least two planners or robots.", hint=hint))
    return planners


def _of_families(names: Sequence[str], indices: range, given: Sequence[str]) -> list[SceneRef]:
    """Scenes of the named families, one per index; `given` sets parameters of the families."""
    from ..compare import scenes_of
    from ..compare.replay import parse_parameters

    parameters = parse_parameters(given)
    return [scene for name in names for scene in scenes_of(name, indices, parameters)]


def _by_name(names: Sequence[str], agent: str, catalog: Catalog) -> list[SceneRef]:
    """Find scenes by name; in a scene that is a scenario, the compared planner controls the given agent."""
    from ..compare import ScenarioScene
    from ..compare.replay import scene_by_name

    places = [scene_by_name(name, catalog) for name in names]
    return [replace(place, agent=agent) if isinstance(place, ScenarioScene) else place for place in places]


def _write(
    given: CompareOptions,
    comparison: Comparison,
    verdicts: Sequence[Verdict],
    metrics: Sequence[str],
    catalog: Catalog,
    losses: Sequence[Loss],
    walks: Sequence[StrengthWalk],
) -> None:
    """Write the HTML report and the Markdown tables, if requested."""
    from ..compare.report import markdown, sceneries, write_comparison

    if given.report is not None:
        write_comparison(
            comparison,
            given.report,
            metrics=metrics,
            any_time=given.early,
            sceneries=lambda scenes: sceneries(scenes, catalog),
            command=shlex.join(["rocs-bt", *click.get_current_context().obj]),
            losses=losses,
            walks=walks,
        )
    if given.markdown is not None:
        write_whole(given.markdown, markdown(comparison, metrics, verdicts, losses, walks))


def _print_json(records: Sequence[EpisodeRecord], verdicts: Sequence[Verdict], more: Mapping[str, Any]) -> None:
    """Print results, verdicts and the results of a cold comparison as JSON."""
    plain = {"results": list(map(_plain, records)), "verdicts": [verdict.as_dict() for verdict in verdicts], **more}
    echo(json.dumps(plain, indent=1, sort_keys=True, allow_nan=False))


def _plain(record: EpisodeRecord) -> dict[str, Any]:
    """Record as plain data, without its track, which only figures use."""
    import msgspec

    plain: dict[str, Any] = msgspec.to_builtins(record)
    del plain["track"]
    return plain


def _create_folders(*files: Path | None) -> None:
    """Create the folders of the output files before any episode is played; raises InputError."""
    for file in (file for file in files if file is not None):
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            check_writable(file)
        except OSError as error:
            raise InputError(Fault(f"'{file}' cannot be written: {error.strerror}.")) from error


def _print(comparison: Comparison, metrics: Sequence[str], verdicts: Sequence[Verdict], played: str) -> None:
    """Print a table of the planners, best first, then the verdicts on the pairs."""
    from rich.box import SIMPLE

    from ..compare.metric import metric
    from ..compare.report import BEST_FIRST, extent, pairs, standings

    echo(f"{extent(comparison)}; {played}")
    rows = standings(comparison, metrics)
    others = [name for name in BEST_FIRST if name not in metrics and any(name in row.outcomes for row in rows)]
    cells = [
        [
            row.planner,
            *(_interval(row.estimates[name], metric(name)) for name in metrics),
            *(row.outcomes.get(name, "") for name in others),
        ]
        for row in rows
    ]
    head = ["planner", *(_head(metric(name)) for name in metrics), *others]
    counts = range(1 + len(metrics), len(head))
    show_table(cells, head, right=counts, edge=_WIDE, box=SIMPLE, padding=(0, 1, 0, 0))
    for line in pairs(verdicts, [row.planner for row in rows]):
        echo(line)


def _interval(found: Estimate, of: Metric) -> str:
    """Format an estimate with its interval, if any; shares in percent."""
    from ..compare.metric import SHARES
    from ..compare.report import number

    if of.name in SHARES:
        value, *ends = [f"{100.0 * found.value:.3g}", f"{100.0 * found.low:.0f}", f"{100.0 * found.high:.0f}"]
    else:
        value, *ends = [number(each) for each in (found.value, found.low, found.high)]
    if math.isnan(found.value):
        return "–"
    return value if math.isnan(found.low) else f"{value} ({ends[0]} to {ends[1]})"


def _head(of: Metric) -> str:
    from ..compare.metric import SHARES

    unit = "%" if of.name in SHARES else of.unit
    return f"{of.name} [{unit}]" if unit else of.name


def _print_errors(records: Sequence[EpisodeRecord]) -> None:
    """Print the first episodes with an error or an exception of content, and the commands that repeat them."""
    from ..compare.replay import replay_command

    broken = [record for record in records if _is_broken(record)]
    for record in broken[:_ERRORS]:
        raised = record.metrics.get("exceptions")
        what = f"{counted(int(raised), 'exception')}, {record.outcome}" if raised else record.outcome
        echo(f"{what}: {record.reason or 'goal reached'}\n  repeat: {replay_command(record)}", err=True)
    if (more := len(broken) - _ERRORS) > 0:
        echo(f"and {counted(more, 'more such episode')}", err=True)


def _is_broken(record: EpisodeRecord) -> bool:
    """Whether an episode ended in an error, or content raised an exception in it."""
    return record.outcome in ("error", "limit") or bool(record.metrics.get("exceptions"))
