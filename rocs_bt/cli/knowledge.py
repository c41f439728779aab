"""`rocs-bt knowledge`: query, draw, export and import the knowledge of agents; keys for sharing it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError, KnowledgeError, unknown
from ..base.files import is_file, write_whole
from ..base.geometry import Pose2
from ..base.registered import load, registered
from ..base.units import NOT_NEGATIVE
from ..catalog import Catalog
from .content import json_option, open_recording
from .options import QuantityType
from .terminal import echo

if TYPE_CHECKING:
    from ..knowledge import Answers, Readable
    from ..knowledge.history import ChangeLog, GraphState


run_argument = click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
agent_option = click.option("--agent", help="Name of the agent; optional if there is only one.")
at_option = click.option(
    "--at", "t", type=QuantityType(bounds=NOT_NEGATIVE), help="Time of the state; by default the end."
)


@click.command()
@run_argument
@agent_option
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
def show(run: Path, agent: str | None, t: float | None, form: str, out: Path | None) -> None:
    """Draw the knowledge of an agent in RUN: an HTML page with search and a time slider, an SVG drawing, or a list.

    RUN is a run's folder, its run.mcap, or a file of knowledge, which holds the end of a run. The page shows the whole
    run; the other formats show one time.
    """
    from ..record.knowledge import draw
    from ..record.pages import page_maker

    log = open_log(run, agent)
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
@at_option
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write to this file.")
def export(run: Path, agent: str | None, t: float | None, out: Path | None) -> None:
    """Write an agent's knowledge in RUN as a file of knowledge, at the end or at the time --at.

    It is JSON without any loss, for `run --knowledge`.
    """
    from ..knowledge.history import to_json_text

    state = state_of(open_log(run, agent), t)
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
    """Add the agents of FILE to the file KNOWLEDGE, where they replace agents of the same name.

    Both are checked against the schema first; if there are faults, nothing is changed.
    """
    from ..knowledge.history import read_knowledge, to_json_text

    schema = Catalog.here().load_schema()
    states = read_knowledge(file, schema)
    if agent is not None:
        states = {agent: _chosen(states, None, file)}
        states[agent].agent = agent
    there = read_knowledge(knowledge, schema) if is_file(knowledge) else {}
    write_whole(knowledge, to_json_text(*(there | states).values()))
    for state in states.values():
        echo(f"{knowledge}: {len(state.nodes())} nodes, {len(state.edges())} edges of {state.agent}.")


def open_log(run: Path, agent: str | None) -> ChangeLog:
    """Change log of an agent from a recording or a file of knowledge."""
    from ..knowledge.history import ChangeLog, read_knowledge
    from ..record.knowledge import recorded_log

    schema = Catalog.here(code=False).load_schema()
    if _is_recording(run):
        return recorded_log(open_recording(run), agent, schema)
    return ChangeLog(_chosen(read_knowledge(run, schema), agent, run), run.name)


def _is_recording(run: Path) -> bool:
    return run.is_dir() or run.suffix == ".mcap"


def _chosen(states: Mapping[str, GraphState], agent: str | None, file: Path) -> GraphState:
    """State of the named agent, or of the only one."""
    if agent is None and len(states) != 1:
        raise InputError(
            f"'{file}' contains the knowledge of {', '.join(states) or 'no agent'}. Choose one with --agent."
        )
    if agent is not None and agent not in states:
        raise InputError(unknown("agent", agent, states, f"'{file}'"))
    return states[agent] if agent is not None else next(iter(states.values()))


def state_of(log: ChangeLog, t: float | None) -> GraphState:
    """State of a change log at a time [s], or at its end.

    Raises:
        InputError: The log does not cover that time.
    """
    try:
        return log.as_of(t)
    except KnowledgeError as error:
        raise InputError(str(error)) from error


def _listed(state: GraphState) -> str:
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
@at_option
@json_option("Print the answers as JSON.")
def query(run: Path, text: str, agent: str | None, t: float | None, as_json: bool) -> int:
    """Query the knowledge of an agent, such as "object where moves and distance(pose, robot) < 2 m".

    RUN is a run's folder, its run.mcap, or a file of knowledge. For a recorded run, `robot` is the robot's pose at the
    time, and the query may use its signals. See docs/knowledge.md for the language.

    Exits with 0 if there is an answer, with 1 if there is none.
    """
    from ..knowledge import QueryContext, compile_query
    from ..record.knowledge import recorded_context

    log = open_log(run, agent)
    t = log.end if t is None else t
    context, signals = QueryContext(log.agent, None, t, past=log), None
    if _is_recording(run):
        context, signals = recorded_context(open_recording(run), log, t)
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
    rows = [[*names, *map(value_text, given)] for names, given in zip(answers.rows, values, strict=True)]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in [heads, *rows]]
    return "\n".join(line.rstrip() for line in lines)


def _plain(answer: dict[str, Any]) -> dict[str, Any]:
    return {name: [*value] if isinstance(value, (Pose2, tuple)) else value for name, value in answer.items()}


@click.command()
@run_argument
@agent_option
@at_option
def why(run: Path, agent: str | None, t: float | None) -> None:
    """Print the reasons and outcomes of an agent's strategies in RUN; with --at, of the strategy active then.

    RUN is a run's folder, its run.mcap, or a file of knowledge.
    """
    log = open_log(run, agent)
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
