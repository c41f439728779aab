"""`rocs-bt run`: a scenario to its outcome, its recording and its report."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..catalog import Catalog, is_path
from ..errors import Fault, InputError
from ..event import Event, RulesReplaced
from ..words import counted
from .progress import Progress
from .requirements import told

if TYPE_CHECKING:
    from ..record.live import LivePage
    from ..simulation import RunResult

_FAULTS = 3  # that are told on the screen


@click.command()
@click.argument("scenario")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="The episode's seed.")
@click.option("--out", type=click.Path(path_type=Path), help="Where to write; runs/SCENARIO-SEED if left out.")
@click.option("--mode", type=click.Choice(["lockstep", "threaded"]), default="lockstep", show_default=True)
@click.option("--for", "duration", metavar="SECONDS", type=float, help="End after this simulated time.")
@click.option("--view", is_flag=True, help="Watch in MuJoCo's viewer.")
@click.option("--video", type=click.Path(path_type=Path, dir_okay=False), help="Render a video to this file.")
@click.option("--live", "show_live", is_flag=True, help="Watch in a browser, until Ctrl-C.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="The live page's port; any that is free if left out."
)
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--btlog", is_flag=True, help="Write AGENT.btlog too, which Groot2 replays.")
@click.option("--no-report", is_flag=True, help="Write no report.html.")
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
@click.option(
    "--knowledge",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Remember what is in this file, and go on in it.",
)
@click.option("--watch-rules", is_flag=True, help="Read rule files anew that change meanwhile.")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: str,
    seed: int,
    out: Path | None,
    mode: str,
    duration: float | None,
    view: bool,
    video: Path | None,
    show_live: bool,
    port: int,
    as_json: bool,
    btlog: bool,
    no_report: bool,
    no_code: bool,
    knowledge: Path | None,
    watch_rules: bool,
) -> int:
    """Run SCENARIO, a name or a file, and tell how each agent did.

    Writes summary.json, run.mcap and report.html. Exits with 0 when every agent succeeded, else with 1.
    """
    from ..check import mind_doubts
    from ..simulation import run

    if duration is not None and not 0.0 < duration < float("inf"):
        raise InputError(Fault(f"--for must be a time above zero, found {duration:g} s."))
    catalog = catalog_for(scenario, code=not no_code)
    spec = catalog.load_scenario(scenario)
    for doubt in mind_doubts(spec, catalog):
        click.echo(str(doubt), err=True)
    folder = out or Path("runs") / f"{spec.name}-{seed}"
    with _live(port) if show_live else nullcontext() as live:
        with Progress(spec.name, duration or spec.duration) as progress:
            result = run(
                spec,
                catalog,
                seed=seed,
                mode=mode,
                out=folder,
                duration=duration,
                view=view,
                video=video,
                live=live,
                report=not no_report,
                btlog=btlog,
                progress=progress,
                sinks=[_Replacements()] if watch_rules else (),
                watch_rules=watch_rules,
                knowledge=knowledge,
            )
        click.echo(json.dumps(result.summary, indent=2) if as_json else _told(result, folder))
        if live is not None:
            click.echo("The live page stays until Ctrl-C.", err=True)
            if not live.wait():
                click.echo("The live page does not respond any more, so it was closed.", err=True)
    return 0 if succeeded(result.summary) else 1


@contextmanager
def _live(port: int) -> Iterator[LivePage]:
    """A live page, and where to find it."""
    from ..record.live import LivePage

    with LivePage(port) as live:
        click.echo(f"Live: {live.url}", err=True)
        yield live


class _Replacements:
    """An event sink that says at once what became of rule files that changed."""

    def emit(self, event: Event) -> None:
        """Say it."""
        if isinstance(event, RulesReplaced):
            click.echo(f"{event.t:.2f} s, {event.agent}: {event.rules}: {event.detail}", err=True)


def catalog_for(name: str, *, code: bool = True) -> Catalog:
    """The catalog around a file that was named by its path, else around the current folder."""
    return Catalog.here(Path(name).parent if is_path(name) else None, code=code)


def succeeded(summary: Mapping[str, Any]) -> bool:
    """Whether every agent did."""
    return all(agent["outcome"] == "success" for agent in summary["agents"].values())


def _told(result: RunResult, folder: Path) -> str:
    """The outcome in a few lines for each agent, where the report is, and what to try next."""
    lines: list[str] = []
    for name, agent in result.summary["agents"].items():
        lines += _outcome(name, agent, result.summary)
        lines += [f"  {line}" for line in told({name: agent["requirements"]})]
    where = shlex.quote(str(folder))
    if (kept := result.summary.get("knowledge")) is not None:
        lines += _remembered(kept)
    if result.report is not None:
        lines.append(f"Report: {result.report}")
    why = min(result.summary["sim_time"] / 2, 5.0)
    lines.append(f"Try next: rocs-bt replay {where} --why {why:.1f}   or   rocs-bt plot {where}")
    return "\n".join(lines)


def _remembered(kept: Mapping[str, Any]) -> list[str]:
    """What was remembered at the start, what was not, and where this run's knowledge is."""
    lines = []
    for name, found in kept["remembered"].items():
        lines.append(
            f"{name} remembered {counted(found['nodes'], 'thing')} and {counted(found['edges'], 'relation')}"
            f" of earlier runs{', but not all' if found['refused'] else ''}."
        )
        lines += [f"  not remembered: {reason}" for reason in found["refused"][:_FAULTS]]
    if kept["lost"]:
        lines.append(f"{counted(kept['lost'], 'change')} of knowledge came faster than the disk took them.")
    file = shlex.quote(kept["file"])
    return [*lines, f"Knowledge: {file}   (rocs-bt knowledge show {file})"]


def _outcome(name: str, agent: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    colour = "green" if agent["outcome"] == "success" else "red"
    outcome = click.style(f"{name} {agent['outcome']}", fg=colour, bold=True)
    reason = f": {agent['reason']}" if agent["reason"] else ""
    place = f"{summary['scenario']}, seed {summary['seed']}"
    took = f" in {agent['time_to_goal']:.1f} s" if agent["time_to_goal"] is not None else ""
    reactive, deliberative = agent["time_reactive"], agent["time_deliberative"]
    share = 100.0 * reactive / max(reactive + deliberative, 1e-9)
    refirings = agent["reflex_refirings"]
    again = f" and fired again {counted(refirings, 'time')} while latched" if refirings else ""
    clearance = agent["min_clearance"]
    near = "" if clearance is None else f", never nearer than {max(clearance, 0.0):.2f} m to anything"
    struck = f", struck {counted(agent['struck'], 'time')} while it stood" if agent["struck"] else ""
    kept = [*_followed(agent["following"]), *_located(agent["localisation"])]
    faults = [f"  fault at {fault}" for fault in agent["faults"][:_FAULTS]]
    if (more := len(agent["faults"]) - _FAULTS) > 0:
        faults.append(f"  and {counted(more, 'more fault')}: see the report")
    return [
        f"{outcome}{took} ({place}){reason}",
        f"  drove {agent['path_length']:.2f} m with {counted(agent['collisions'], 'collision')}{struck}{near};"
        f" {summary['sim_time']:.1f} s simulated in {summary['wall_time']:.1f} s"
        f" ({summary['real_time_factor']:.0f} times real time)",
        f"  {counted(agent['reflex_activations'], 'reflex', 'es')} held the wheels {share:.0f} % of the time{again},"
        f" {counted(agent['replans'], 're-plan')},"
        f" {counted(agent['route_switches'], 'switch', 'es')} between plan and reflex",
        *kept,
        *faults,
    ]


def _followed(leash: Mapping[str, Any] | None) -> list[str]:
    """How it kept its distance from its leader; nothing of who follows nobody, or never caught up."""
    if leash is None or not leash["periods"]:
        return []
    driving = leash["least_driving"]
    near = "" if driving is None else f", never nearer than {driving:.2f} m while it drove"
    return [
        f"  followed {leash['leader']} at {leash['mean_distance']:.2f} m in the mean,"
        f" {100.0 * leash['in_band']:.0f} % of the time within its band{near}"
    ]


def _located(error: Mapping[str, float] | None) -> list[str]:
    """How far off it took itself to be; nothing of who does not localise itself."""
    if error is None:
        return []
    rms, most = (
        f"{100.0 * error[f'position_{kind}']:.1f} cm and {math.degrees(error[f'heading_{kind}']):.1f} deg"
        for kind in ("rms", "max")
    )
    return [f"  its estimate of its pose was {rms} off (rms), at most {most}"]
