"""`rocs-bt knowledge`: query, draw, export and import the knowledge of agents; keys for sharing it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import Fault, InputError, KnowledgeError
from ..base.files import read_text, write_whole
from ..base.geometry import Pose2
from ..base.registered import load, registered
from ..base.units import NOT_NEGATIVE
from ..catalog import Catalog
from .content import json_option, open_recording
from .quantity import QuantityType
from .terminal import echo

if TYPE_CHECKING:
    from ..knowledge import Answers, Readable, Schema
    from ..knowledge.history import ChangeLog, State


run_argument = click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
agent_option = click.option("--agent", help="Name of the agent; optional if there is only one.")
run_number_option = click.option(
    "--run-number", type=click.IntRange(min=1), help="Number of the run in a file with several; by default the newest."
)


at_option = click.option(
    "--at", "t", type=QuantityType(bounds=NOT_NEGATIVE), help="Time of the state; by default the end."
)


@click.command()
@run_argument
@agent_option
@run_number_option
@at_option
@click.option(
    "--format",
    "form",
    type=click.Choice(["html", "svg", "text"]),
    default="html",
    show_default=True,
    help="Format of the drawing.",
)
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write to this file.")
def show(run: Path, agent: str | None, run_number: int | None, t: float | None, form: str, out: Path | None) -> None:
    """Draw the knowledge of an agent in RUN: an HTML page with search and a time slider, an SVG drawing, or a list.

    RUN is a run's folder, its run.mcap, a file written by `run --knowledge`, or an export. The page shows the whole
    run; the other formats show one time.
    """
    from ..record.knowledge import draw
    from ..record.pages import page_maker

    log = open_log(run, agent, run_number)
    if form == "html":
        text = page_maker("knowledge")(log)
    else:
        state = state_of(log, t)
        text = draw(state, log.agent) if form == "svg" else _listed(state)
    if form == "text" and out is None:
        echo(text.rstrip("\n"))
        return
    file = out or _beside(run) / f"knowledge.{form}"
    write_whole(file, text)
    echo(f"Knowledge of {log.agent}: {file}")


@click.command()
@run_argument
@agent_option
@run_number_option
@at_option
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write to this file.")
def export(run: Path, agent: str | None, run_number: int | None, t: float | None, out: Path | None) -> None:
    """Write an agent's knowledge in RUN as JSON, at the end or at the time --at.

    JSON is lossless and can be read by `knowledge import`.
    """
    from ..knowledge.history import to_json_text

    state = state_of(open_log(run, agent, run_number), t)
    text = to_json_text(state)
    if out is None:
        echo(text, nl=False)
        return
    write_whole(out, text)
    echo(f"{out}: {len(state.nodes())} nodes, {len(state.edges())} edges, as of {max(state.t, 0.0):g} s.")


@click.command(name="import")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.argument("knowledge", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--agent", help="Agent that gets the knowledge; by default the agent in the file.")
def take(file: Path, knowledge: Path, agent: str | None) -> None:
    """Add an export FILE to a KNOWLEDGE file as its newest run, for use by later runs.

    The file is checked against the schema first; if it has faults, nothing is changed.
    """
    from ..knowledge.history import write_state

    state = _exported(file, Catalog.here().load_schema())
    if agent is not None:
        state.agent = agent
    if not state.agent:
        raise InputError(Fault("the file does not name the agent.", file, hint="Give it: --agent NAME"))
    write_state(knowledge, state, file.name)
    echo(f"{knowledge}: {len(state.nodes())} nodes, {len(state.edges())} edges of {state.agent}.")


def open_log(run: Path, agent: str | None, number: int | None) -> ChangeLog:
    """Change log of an agent from a recording, a knowledge file, or an export."""
    from ..knowledge.history import History, log_of
    from ..record.knowledge import recorded_log

    schema, file = Catalog.here(code=False).load_schema(), _knowledge_file(run)
    if file.suffix == ".json":
        return log_of(_exported(file, schema), file.name)
    if file.suffix == ".mcap":
        return recorded_log(open_recording(file), agent, schema)
    with History(file, agent, number, schema) as history:
        return history


def state_of(log: ChangeLog, t: float | None) -> State:
    """State of a change log at a time [s], or at its end.

    Raises:
        InputError: The log does not cover that time.
    """
    try:
        return log.as_of(t)
    except KnowledgeError as error:
        raise InputError(str(error)) from error


def _knowledge_file(run: Path) -> Path:
    """File of a run: in a folder the knowledge file, or else the recording."""
    if not run.is_dir():
        return run
    knowledge = run / "knowledge.sqlite"
    return knowledge if knowledge.exists() else run / "run.mcap"


def _exported(file: Path, schema: Schema) -> State:
    from ..knowledge.history import from_json_text

    return from_json_text(read_text(file), file, schema)


def _listed(state: State) -> str:
    """List a state, one node or edge per line."""
    lines = []
    for name in state.nodes():
        known = ", ".join(f"{a} {value_text(v)}" for a, v in state.attributes(name).items())
        lines.append(f"{state.kind(name)} {name}{': ' if known else ''}{known}")
    for source, relation, target in state.edges():
        known = ", ".join(f"{a} {value_text(v)}" for a, v in (state.edge(source, relation, target) or {}).items())
        lines.append(f"{source} {relation} {target}{': ' if known else ''}{known}")
    return "\n".join(lines) + "\n"


def value_text(value: Any) -> str:
    """Format a value of a fact in human-readable form."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "unknown"}[value]
    if isinstance(value, float):
        return f"{value:.4g}"
    return "(" + ", ".join(map(value_text, value)) + ")" if isinstance(value, (list, tuple)) else str(value)


def _beside(run: Path) -> Path:
    return run if run.is_dir() else run.parent


@click.command()
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.argument("text", metavar="QUERY")
@agent_option
@run_number_option
@at_option
@json_option("Print the answers as JSON.")
def query(run: Path, text: str, agent: str | None, run_number: int | None, t: float | None, as_json: bool) -> int:
    """Query the knowledge of an agent, such as "object where moves and distance(pose, robot) < 2 m".

    RUN is a run's folder, its run.mcap, a file written by `run --knowledge`, or an export. For a recorded run, `robot`
    is the robot's pose at the time, and the query may use its signals. See docs/knowledge.md for the language.

    Exits with 0 if there is an answer, with 1 if there is none.
    """
    from ..knowledge import QueryContext, compile_query
    from ..record.knowledge import recorded_context

    log = open_log(run, agent, run_number)
    t = log.end if t is None else t
    context, signals = QueryContext(log.agent, None, t, past=log), None
    if (recorded := run / "run.mcap" if run.is_dir() else run).suffix == ".mcap" and recorded.exists():
        context, signals = recorded_context(open_recording(recorded), log, t)
    state = state_of(log, t)
    try:
        answers = compile_query(text, state.schema, signals).ask(state, context)
    except InputError as error:
        raise error.at(Path("query"), 1) from error
    except KnowledgeError as error:
        raise InputError(str(error)) from error
    echo(json.dumps([_plain(each) for each in answers.dicts]) if as_json else _table(answers))
    return 0 if answers else 1


def _table(answers: Answers) -> str:
    """Format the answers to a query as a text table."""
    if not answers:
        return "no answers."
    if not answers.variables and not answers.columns:
        return "yes."
    heads = [*answers.variables, *answers.columns]
    values = answers.values or ((),) * len(answers)
    rows = [[*names, *map(_shown, given)] for names, given in zip(answers.rows, values, strict=True)]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in [heads, *rows]]
    return "\n".join(line.rstrip() for line in lines)


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):
        return f"({', '.join(_shown(each) for each in value)})"
    return str(value)


def _plain(answer: dict[str, Any]) -> dict[str, Any]:
    return {name: [*value] if isinstance(value, (Pose2, tuple)) else value for name, value in answer.items()}


@click.command()
@run_argument
@agent_option
@run_number_option
@at_option
def why(run: Path, agent: str | None, run_number: int | None, t: float | None) -> None:
    """Print the reasons and outcomes of an agent's strategies in RUN; with --at, of the strategy active then.

    RUN is a run's folder, its run.mcap, a file written by `run --knowledge`, or an export.
    """
    log = open_log(run, agent, run_number)
    state = log.as_of()
    uses = sorted(state.nodes("use"), key=lambda use: state.get(use, "began") or 0.0)
    if t is not None:
        uses = [use for use in uses if _active(state, use, t)]
    if not uses:
        when = "" if t is None else f" at {t:g} s"
        hint = "Missions choose strategies with UseStrategy (docs/knowledge.md)."
        echo(f"No strategy of {log.agent} was active{when}. {hint}")
        return
    for use in uses:
        echo("\n".join(_use_lines(state, use)))


def _active(state: Readable, use: str, t: float) -> bool:
    ended = state.get(use, "ended")
    return bool((state.get(use, "began") or 0.0) <= t and (ended is None or t <= ended))


def _use_lines(state: Readable, use: str) -> Iterator[str]:
    known = state.attributes(use)
    names = ", ".join(state.related(use, "use_of")) or "a removed strategy"
    until = f"{known['ended']:.2f} s" if "ended" in known else "the end"
    outcome = known.get("outcome", "still active") + (f": {known['reason']}" if "reason" in known else "")
    yield f"{known.get('began', 0.0):.2f} s to {until}  {names}  {outcome}"
    yield from (f"    {line}" for line in known.get("why", "no reason recorded").splitlines())


@click.group()
def command() -> None:
    """Query, draw, export and import the knowledge of agents, and make keys for sharing it."""


for each in (query, why, show, export, take):
    command.add_command(each)
for name in registered("rocs_bt.commands"):
    if name.startswith("knowledge."):
        command.add_command(load("rocs_bt.commands", name))
